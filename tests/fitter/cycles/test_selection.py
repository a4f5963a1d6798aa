"""Shares with which densities are sampled, against SciPy."""

import numpy as np
import pytest
import scipy.optimize

from fitter.cycles.selection import selection_probabilities

LEAST = 0.01                    # share of any density


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
    for share, *problem in zip(selection_probabilities(*arrays), *arrays, strict=True):
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
    found = selection_probabilities(magnitude, density, solid_angle)
    np.testing.assert_allclose(found, np.tile(parts / parts.sum(), (5, 1)), atol=0.02)
    for share, *problem in zip(found, magnitude, density, solid_angle, strict=True):
        assert second_moment(share, *problem) == pytest.approx(parts.sum() ** 2, rel=1e-3)


def test_where_there_is_nothing_to_carry_all_densities_are_sampled_alike(random):
    _, density, solid_angle = problems(random, 2)
    np.testing.assert_allclose(selection_probabilities(np.zeros((2, 200)), density, solid_angle), 1 / 3)
