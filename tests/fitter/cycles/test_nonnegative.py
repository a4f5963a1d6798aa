"""Least squares and shares without negative numbers, against SciPy."""

import numpy as np
import pytest
import scipy.optimize

from fitter.cycles.nonnegative import nonnegative, shares

LEAST = 0.01                    # share of any density


@pytest.mark.parametrize("unlike", [1.0, 1e-2, 1e-4], ids="columns that differ by {}".format)
@pytest.mark.parametrize("unknowns", [1, 4, 10])
def test_the_least_squares_without_negatives(random, unknowns, unlike):
    matrix = random.standard_normal((300, 30, 1)) + unlike * random.standard_normal((300, 30, unknowns))
    target = random.standard_normal((300, 30))
    transposed = np.swapaxes(matrix, 1, 2)
    found = nonnegative(transposed @ matrix, (transposed @ target[..., None])[..., 0])
    for each, columns, wanted in zip(found, matrix, target, strict=True):
        best, residual = scipy.optimize.nnls(columns, wanted)
        assert each.min() >= 0
        assert np.linalg.norm(columns @ each - wanted) == pytest.approx(residual, rel=1e-9)
        np.testing.assert_allclose(each, best, atol=1e-7 / unlike)


def test_of_equal_columns_any_share_will_do():
    found = nonnegative(np.ones((3, 3)), np.array([2.0, 2.0, 2.0]))
    assert found.min() >= 0
    assert found.sum() == pytest.approx(2)


def test_no_problem_goes_round_in_circles(random):
    """Changing all wrong unknowns at once does, of about one in two hundred of these."""
    matrix, target = random.standard_normal((2000, 6, 6)), random.standard_normal((2000, 6))
    transposed = np.swapaxes(matrix, 1, 2)
    found = nonnegative(transposed @ matrix, (transposed @ target[..., None])[..., 0])
    for each, columns, wanted in zip(found, matrix, target, strict=True):
        assert np.linalg.norm(columns @ each - wanted) < scipy.optimize.nnls(columns, wanted)[1] + 1e-6


def second_moment(share, magnitude, density, solid_angle):
    """The integral of R^2 / p, the noise of sampling under an even light."""
    return (magnitude ** 2 / (share @ density)) @ solid_angle


def problems(random, count):
    """Magnitudes (count, 200) and three densities, (count, 3, 200), which integrate to 1."""
    solid_angle = 2 * np.pi / 200 * np.ones((count, 200))
    density = np.exp(2 * random.standard_normal((count, 3, 200)))
    density /= (density * solid_angle[:, None]).sum(axis=-1, keepdims=True)
    return np.exp(random.standard_normal((count, 200))), density, solid_angle


def test_shares_are_those_of_the_least_second_moment(random):
    arrays = problems(random, 12)
    arrays[0][3] = 5 * arrays[1][3, 1]              # one density is all that is needed
    for share, *problem in zip(shares(*arrays), *arrays, strict=True):
        best = scipy.optimize.minimize(second_moment, np.full(3, 1 / 3), tuple(problem), "SLSQP",
                                       bounds=3 * [(LEAST, 1)],
                                       constraints={"type": "eq", "fun": lambda x: x.sum() - 1})
        assert best.success
        assert share.sum() == pytest.approx(1)
        assert share.min() > 0.9 * LEAST
        assert second_moment(share, *problem) < 1.01 * best.fun
        np.testing.assert_allclose(share, best.x, atol=0.03)


def test_what_is_a_sum_of_the_densities_is_sampled_by_its_parts(random):
    """There the second moment is the least that any sampling has, the squared integral."""
    _, density, solid_angle = problems(random, 5)
    parts = np.array([0.3, 0.1, 0.2])
    magnitude = np.einsum("k,vkn->vn", parts, density)
    found = shares(magnitude, density, solid_angle)
    np.testing.assert_allclose(found, np.tile(parts / parts.sum(), (5, 1)), atol=0.02)
    for share, *problem in zip(found, magnitude, density, solid_angle, strict=True):
        assert second_moment(share, *problem) == pytest.approx(parts.sum() ** 2, rel=1e-3)


def test_where_there_is_nothing_to_carry_all_densities_are_sampled_alike(random):
    _, density, solid_angle = problems(random, 2)
    np.testing.assert_allclose(shares(np.zeros((2, 200)), density, solid_angle), 1 / 3)
