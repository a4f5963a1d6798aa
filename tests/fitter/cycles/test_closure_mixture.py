import numpy as np
import pytest

import fitter
from fitter.cycles import closure_mixture as closures
from fitter.cycles import direction_grid, nonnegative, sampling_table
from fitter.shader_constants import ALBEDO_SCALE, GGX, PHONG, WEIGHTS


class Analytic:
    """A reflectance with the `evaluate` of a fit."""

    def __init__(self, function):
        self.function = function

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        return self.function(*np.broadcast_arrays(theta_i, phi_o - phi_i, theta_o))[..., None]


def radiance(fit, to, theta_o):
    """f cos theta_i at the points of a grid: (n, channels)."""
    return np.maximum(fit.evaluate(to.theta, to.phi, theta_o, 0), 0) * np.cos(to.theta)[:, None]


@pytest.mark.parametrize("theta_o", [0.0, 0.6, 1.3, direction_grid.GRAZING])
def test_the_grid_covers_the_hemisphere(theta_o):
    to = direction_grid.grid(theta_o)
    np.testing.assert_allclose(np.linalg.norm(to.unit, axis=1), 1)
    assert to.solid_angle.sum() == pytest.approx(2 * np.pi, rel=0.02)
    assert to.solid_angle @ np.cos(to.theta) == pytest.approx(np.pi, rel=3e-3)
    assert to.solid_angle @ np.cos(to.theta) ** 4 == pytest.approx(2 * np.pi / 5, rel=3e-3)
    assert (to.reachable >= to.solid_angle).all()


def test_cells_gather_the_points_around_the_mirror_direction():
    theta_o = 0.7
    to = direction_grid.grid(theta_o)
    away = np.arccos(np.clip(to.unit @ [-np.sin(theta_o), 0, np.cos(theta_o)], -1, 1))
    within = direction_grid.cells(np.where(to.solid_angle > 0, away, np.nan))
    last, first = (each(axis=1).reshape(direction_grid.RINGS, -1) for each in (within.max, within.min))
    seen = ~np.isnan(last[:-1]) & ~np.isnan(first[1:])
    assert seen.sum() > 400
    assert (last[:-1] < first[1:])[seen].all(), "rings are ordered by the angle from the mirror direction"


def test_a_diffuse_surface_is_all_mixture():
    mixture = closures.closure_mixture(Analytic(lambda theta_i, phi, theta_o: np.full(theta_i.shape, 0.5 / np.pi)))
    assert mixture.error < 0.01
    assert mixture.worst < 0.03
    weights = mixture.table[:, WEIGHTS:ALBEDO_SCALE, 0]
    np.testing.assert_allclose(weights.sum(axis=1), 0.5, rtol=0.06)
    assert (weights >= 0).all()


def test_the_mixture_comes_close_to_a_glossy_surface(glossy):
    fit = fitter.fit(glossy, 4, 6)
    assert closures.closure_mixture(fit).error < 0.15


def test_black_stays_black():
    mixture = closures.closure_mixture(Analytic(lambda theta_i, phi, theta_o: np.zeros(theta_i.shape)))
    assert np.isfinite(mixture.table).all()
    assert mixture.error < 1e-9


@pytest.mark.parametrize("view", [0, 15, 25])
def test_the_mixture_is_nowhere_negative_and_seldom_above_the_fit(glossy, view):
    """What it exceeds the fit by has to be subtracted, at random."""
    fit = fitter.fit(glossy, 4, 6)
    mixture = closures.closure_mixture(fit)
    theta_o = direction_grid.views()[view]
    to = direction_grid.grid(theta_o + 1e-3)            # not where it was fitted
    made, wanted = closures.evaluate(mixture, view, theta_o + 1e-3, to.unit), radiance(fit, to, theta_o + 1e-3)
    assert (mixture.table[view, :WEIGHTS] >= 0).all()
    assert made.min() >= 0
    light = to.solid_angle @ wanted
    assert (to.solid_angle @ np.maximum(made - wanted, 0) < 0.03 * light).all()
    scaled = mixture.table[view, ALBEDO_SCALE] * made
    np.testing.assert_allclose(to.solid_angle @ scaled, light, rtol=0.02)


def test_the_table_has_what_the_mixture_misses(glossy):
    fit = fitter.fit(glossy, 4, 6)
    mixture = closures.closure_mixture(fit)
    for view in (3, 20):
        theta_o = direction_grid.views()[view]
        to = direction_grid.grid(theta_o)
        wanted = radiance(fit, to, theta_o)
        missing = wanted - closures.evaluate(mixture, view, theta_o, to.unit)
        cells = direction_grid.cells(np.where(to.solid_angle[:, None] > 0, missing, np.nan)).mean(axis=1)
        inside = ~np.isnan(cells).any(axis=1)
        assert inside.sum() > 300
        np.testing.assert_allclose(mixture.missing[view][inside], cells[inside], atol=2e-3 * np.abs(missing).max())


def test_weights_add_to_about_the_albedo(glossy):
    """Cycles' denoising passes use the weights as the albedo."""
    fit = fitter.fit(glossy, 4, 6)
    mixture = closures.closure_mixture(fit)
    for view in (0, 15, 25):
        theta_o = direction_grid.views()[view]
        to = direction_grid.grid(theta_o)
        albedo = to.solid_angle @ radiance(fit, to, theta_o)
        weights = mixture.table[view, WEIGHTS:ALBEDO_SCALE].sum(axis=0)
        weights *= mixture.table[view, ALBEDO_SCALE]
        np.testing.assert_allclose(weights, albedo, rtol=0.1)


LOBES = [closures.Lobe(PHONG, 8, 0.0), closures.Lobe(PHONG, 60, 0.1),
         closures.Lobe(GGX, 0.2, 0.05)]


def test_densities_are_those_of_the_directions_that_are_sampled():
    """Each integrates to 1, less the part below the horizon."""
    for theta_o in (0.1, 0.8):
        to = direction_grid.grid(theta_o)
        total = closures._densities(theta_o, LOBES, to.unit) @ to.solid_angle
        assert total == pytest.approx([1, 1, 1, 1], abs=0.1)
        assert (total < 1.01).all()


def test_shares_make_sampling_quieter_than_equal_ones():
    """The second moment of value over density is the noise under an even light."""
    theta_o = 0.6
    to = direction_grid.grid(theta_o)
    density = closures._densities(theta_o, LOBES, to.unit)
    mixture = np.stack([0.1 * density[0] + 0.8 * density[2]] * 2, axis=1)
    shares = nonnegative.shares(mixture, density, to.solid_angle)
    assert shares.sum() == pytest.approx(1)
    assert shares[[0, 2]] == pytest.approx([1 / 9, 8 / 9], abs=0.04)

    def second_moment(shares):
        seen = to.solid_angle > 0
        return (mixture[seen, 0] ** 2 / (shares @ density[:, seen])) @ to.solid_angle[seen]

    assert second_moment(shares) < 0.6 * second_moment(np.full(4, 0.25))


def test_coefficients_are_the_least_squares_where_those_are_positive(random):
    """Against SciPy, with errors above the target counted no more than others."""
    from scipy.optimize import nnls

    to = direction_grid.grid(0.5)
    basis = closures._basis(0.5, LOBES, to.unit)
    target = basis @ random.random(basis.shape[1])[:, None] * 0.1
    weight = np.sqrt(nonnegative.weights(target, to.solid_angle))
    expected, _ = nnls(weight * basis, (weight * target)[:, 0])
    found = nonnegative.solve(basis, target, to.solid_angle, steps=4000, reweightings=1)[:, 0]
    error, floor = (np.linalg.norm(weight[:, 0] * (basis @ x - target[:, 0])) for x in (found, np.zeros_like(found)))
    assert error < 0.01 * floor
    assert np.linalg.norm(weight[:, 0] * (basis @ expected - target[:, 0])) < 0.01 * floor


def test_the_sampling_table_follows_what_is_to_be_carried(random):
    to = direction_grid.grid(0.4)
    rest = 1 + random.random((3, len(to.theta)))
    rest[1] = 0
    rest[2] = 0
    rest[2, np.arange(len(to.theta)) // (direction_grid.SECTORS * 2) == 7] = 1      # one ring of cells
    solid_angle, reachable = np.stack([to.solid_angle] * 3), np.stack([to.reachable] * 3)
    table = sampling_table.sampling_table(rest, solid_angle, reachable, 0.1)
    share = np.diff(table, axis=1, prepend=0)
    np.testing.assert_allclose(table[:, -1], 1)
    points = direction_grid.SUBSAMPLES
    cell = np.zeros((direction_grid.RINGS, points[0], direction_grid.SECTORS, points[1]), dtype=bool)
    cell[10, :, 5, :] = True
    part = [values[cell.ravel()].sum() / values.sum() for values in (rest[0] * to.solid_angle, to.reachable)]
    assert share[0, 10 * direction_grid.SECTORS + 5] == pytest.approx(0.9 * part[0] + 0.1 * part[1], rel=0.01)
    assert share[1, 10 * direction_grid.SECTORS + 5] == pytest.approx(part[1], rel=1e-3)
    ring = share[2].reshape(direction_grid.RINGS, -1).sum(axis=1)
    assert ring[7] > 0.5
    assert min(ring[6], ring[8]) > 0.04, "beside a peak, another may have been missed"
    assert ring[9] < 0.02
