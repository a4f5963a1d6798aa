import numpy as np
import pytest
from scipy.interpolate import BSpline, NdBSpline

from fitter.coordinates.anisotropic_nusselt import AnisotropicNusselt
from fitter.coordinates.nusselt import Nusselt
from fitter.lattice import dense


def random_points(random, count, axes=3):
    """Coordinates of pairs of directions at random, (count, axes)."""
    if axes == 3:
        theta_i, theta_o, delta_phi = random.random((3, count)) * np.array([[np.pi / 2], [np.pi / 2], [np.pi]])
        return Nusselt().encode(theta_i, 0, theta_o, delta_phi)
    theta_i, theta_o = np.arccos(random.random((2, count)))
    return AnisotropicNusselt().encode(theta_i, 2 * np.pi * random.random(count), theta_o,
                                       2 * np.pi * random.random(count))


def levels(of_three, of_four):
    return pytest.mark.parametrize(("level", "axes"), [*((level, 3) for level in range(of_three)),
                                                       *((level, 4) for level in range(of_four))])


def random_lattice(random, level, axes=3, channels=2):
    return random.standard_normal((*dense.shape(level, axes), channels))


def test_the_basis_is_the_uniform_cubic_b_spline():
    s = np.linspace(0, 1, 11)
    expected = np.nan_to_num(np.stack([BSpline.basis_element(np.arange(k - 3.0, k + 2))(s) for k in range(4)], axis=1))
    np.testing.assert_allclose(dense.weights(s), expected, atol=1e-15)


@levels(6, 4)
def test_evaluate_is_the_tensor_product_spline_of_scipy(random, level, axes):
    points = random_lattice(random, level, axes)
    x = random_points(random, 300, axes)
    m = dense.cells(level)
    knots = tuple((first - 2 + np.arange(count + 4)) / m
                  for first, count in zip(dense.origin(level, axes), dense.shape(level, axes), strict=True))
    spline = NdBSpline(knots, points, k=3)
    for times in ((1, 1), (5, 1)):      # few points and many are evaluated in two ways
        found = dense.evaluate(points, level, np.tile(x, times))
        np.testing.assert_allclose(found, np.tile(spline(x), times), atol=1e-12)


@levels(8, 4)
def test_refinement_changes_nothing_but_the_lattice(random, level, axes):
    points = random_lattice(random, level, axes, 1)
    x = random_points(random, 200, axes)
    fine = dense.refine(points, level)
    assert fine.shape[:-1] == dense.shape(level + 1, axes)
    np.testing.assert_allclose(dense.evaluate(fine, level + 1, x), dense.evaluate(points, level, x), atol=1e-13)


@pytest.mark.parametrize("level", [0, 3, 6])
def test_constant_and_linear_functions_are_reproduced_from_their_coefficients(random, level):
    m = dense.cells(level)
    greville = [(first + np.arange(count)) / m
                for first, count in zip(dense.origin(level), dense.shape(level), strict=True)]
    grid = np.meshgrid(*greville, indexing="ij")
    points = np.stack([np.full_like(grid[0], 3.0), 2 * grid[0] - grid[1] + 5 * grid[2]], axis=-1)
    x = random_points(random, 100)
    expected = np.stack([np.full(len(x), 3.0), x @ [2, -1, 5]], axis=1)
    np.testing.assert_allclose(dense.evaluate(points, level, x), expected, atol=1e-13)


@levels(7, 5)
def test_reachable_holds_every_control_point_that_is_read_and_few_others(random, level, axes):
    x = random_points(random, 200_000 if axes == 3 else 400_000 if level == 3 else 50_000, axes)
    if axes == 3:
        x[:3] = [[0.5, 0.5, 0.5], [1, 0, 0.5], [1, 0.5, 1]]
    first, _ = dense.locate(x, level)
    assert first.min() >= 0
    read = np.zeros(dense.shape(level, axes), dtype=bool)
    for offset in np.ndindex(*axes * [4]):
        read[tuple((first + offset).T)] = True
    reachable = dense.reachable(level, axes)
    assert not (read & ~reachable).any()
    if level <= {3: 4, 4: 3}[axes]:     # enough points to touch nearly every cell
        assert reachable.sum() <= {3: 1.02, 4: 1.15}[axes] * read.sum()


def test_the_box_is_about_a_quarter_of_the_full_lattice():
    assert np.prod(dense.shape(6)) < 0.28 * dense.full_size(6)
    assert [dense.full_size(h) for h in (0, 3, 4, 6)] == [64, 1331, 6859, 300763]
