import numpy as np
import pytest

import fitter
from fitter.cycles import closure_mixture as closures
from fitter.cycles import direction_grid, sampling_table


class Analytic:
    """A reflectance with the `evaluate` of a fit."""

    def __init__(self, function):
        self.function = function

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        return self.function(*np.broadcast_arrays(theta_i, phi_o - phi_i, theta_o))[..., None]


def test_the_grid_covers_the_hemisphere():
    to = direction_grid.grid()
    np.testing.assert_allclose(np.linalg.norm(to.unit, axis=1), 1)
    assert to.solid_angle.sum() == pytest.approx(2 * np.pi)
    assert to.solid_angle @ np.cos(to.theta) == pytest.approx(np.pi, rel=1e-3)
    assert to.solid_angle @ np.cos(to.theta) ** 4 == pytest.approx(2 * np.pi / 5, rel=1e-3)


def test_a_diffuse_surface_is_all_mixture():
    mixture = closures.closure_mixture(Analytic(lambda theta_i, phi, theta_o: np.full(theta_i.shape, 0.5 / np.pi)))
    assert mixture.error < 1e-3
    weights = mixture.table[:, closures.WEIGHTS:closures.TOTAL_WEIGHT, 0]
    np.testing.assert_allclose(weights.sum(axis=1), 0.5, rtol=0.02)
    assert (weights >= 0).all()


def test_the_mixture_comes_close_to_a_glossy_surface(glossy):
    fit = fitter.fit(glossy, 4, 6)
    assert closures.closure_mixture(fit).error < 0.15


def test_black_stays_black():
    mixture = closures.closure_mixture(Analytic(lambda theta_i, phi, theta_o: np.zeros(theta_i.shape)))
    assert np.isfinite(mixture.table).all()
    assert mixture.error == 0


def test_weights_add_to_about_the_albedo(glossy):
    """Cycles' denoising passes use the weights as the albedo."""
    fit = fitter.fit(glossy, 4, 6)
    to = direction_grid.grid()
    mixture = closures.closure_mixture(fit)
    for view in (0, 15, 25):
        value = np.maximum(fit.evaluate(to.theta, to.phi, direction_grid.views()[view], 0), 0)
        albedo = (to.solid_angle * np.cos(to.theta)) @ value
        weights = mixture.table[view, closures.WEIGHTS:closures.TOTAL_WEIGHT].sum(axis=0)
        assert 0.55 < weights.mean() / albedo.mean() < 1.65
        assert mixture.table[view, closures.TOTAL_WEIGHT] == pytest.approx(weights.mean())


def test_densities_are_those_of_the_directions_that_are_sampled():
    """Each integrates to 1, less the part below the horizon."""
    to = direction_grid.grid()
    for theta_o in (0.1, 0.8):
        density = closures._densities(theta_o, 0.0, (8, 60), 0.2, to.unit)
        total = density @ to.solid_angle
        assert total == pytest.approx([1, 1, 1, 1], abs=0.1)
        assert (total < 1.001).all()


def test_shares_make_sampling_quieter_than_equal_ones(glossy):
    """The second moment of value over density is the noise under an even light."""
    to = direction_grid.grid()
    theta_o = 0.6
    density = closures._densities(theta_o, 0.0, (8, 60), 0.2, to.unit)
    mixture = np.stack([0.1 * density[0] + 0.8 * density[2]] * 2, axis=1)
    shares = closures._shares(mixture, density, to.solid_angle)
    assert shares.sum() == pytest.approx(1)
    assert shares[[0, 2]] == pytest.approx([1 / 9, 8 / 9], abs=0.04)

    def second_moment(shares):
        return (mixture[:, 0] ** 2 / (shares @ density)) @ to.solid_angle

    assert second_moment(shares) < 0.6 * second_moment(np.full(4, 0.25))


def test_the_sampling_table_follows_what_is_to_be_carried(random):
    to = direction_grid.grid()
    rest = random.random((3, len(to.theta)))
    rest[1] = 0
    table = sampling_table.sampling_table(rest, to.solid_angle, 0.1)
    share = np.diff(table, axis=1, prepend=0)
    np.testing.assert_allclose(table[:, -1], 1)
    points = direction_grid.SUBSAMPLES
    cell = np.zeros((direction_grid.RINGS, points, direction_grid.SECTORS, points), dtype=bool)
    cell[20, :, 5, :] = True
    part = [(values * to.solid_angle)[cell.ravel()].sum() / (values * to.solid_angle).sum()
            for values in (rest[0], np.ones_like(rest[0]))]
    assert share[0, 20 * direction_grid.SECTORS + 5] == pytest.approx(0.9 * part[0] + 0.1 * part[1], rel=1e-3)
    assert share[1, 20 * direction_grid.SECTORS + 5] == pytest.approx(part[1], rel=1e-3)
