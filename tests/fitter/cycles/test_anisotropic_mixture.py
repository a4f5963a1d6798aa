"""The mixture of anisotropic reflectances, its axes and its grid, against the reflectances themselves."""

import numpy as np
import pytest

from fitter.cycles import anisotropic_mixture, half_vector_grid
from fitter.cycles.closure_mixture import closure_mixture
from fitter.cycles.principal import principal
from fitter.shader_constants import ALBEDO_SCALE, AZIMUTH_VIEWS, POLAR_VIEWS, WEIGHTS
from support.anisotropic import ANISOTROPIC, brushed_fit

TRUTHS = {truth.name: truth for truth in ANISOTROPIC}


class Slanted:
    """A brushed surface that also shines to one side: half a turn changes it."""

    isotropic = False

    def __init__(self):
        self.brushed = brushed_fit(0.1, 0.4, 0.0)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        leaning = 1 + 0.8 * np.sin(theta_i) * np.cos(phi_i) * np.sin(theta_o) * np.cos(phi_o) \
            + 0.3 * (np.sin(theta_i) * np.cos(phi_i) + np.sin(theta_o) * np.cos(phi_o))
        return self.brushed.evaluate(theta_i, phi_i, theta_o, phi_o) * leaning[..., None]


def radiance(fit, mixture, to, view, theta_o, phi_o):
    """f cos theta_i at the points of a view's grid: (n, channels)."""
    turn = mixture.principal.turn
    value = np.maximum(fit.evaluate(to.theta[view], to.phi[view] + turn, theta_o, phi_o + turn), 0)
    return value * np.cos(to.theta[view])[:, None] * (to.solid_angle[view] > 0)[:, None]


@pytest.fixture(scope="module")
def brushed():
    fit = brushed_fit()
    return fit, closure_mixture(fit)


@pytest.mark.parametrize("stretch", [1.0, 1.6])
@pytest.mark.parametrize("number", [0, 3, POLAR_VIEWS - 1])
def test_the_grid_covers_the_hemisphere(stretch, number):
    theta_o = half_vector_grid.polar_angles()[number]
    wo = half_vector_grid.outgoing(theta_o, np.array([0.0, 0.7, 1.5]))
    to = half_vector_grid.grid(wo, stretch)
    np.testing.assert_allclose(np.linalg.norm(to.unit, axis=-1), 1)
    np.testing.assert_allclose(to.solid_angle.sum(axis=1), 2 * np.pi, rtol=0.05)
    np.testing.assert_allclose((to.solid_angle * to.unit[..., 2]).sum(axis=1), np.pi, rtol=0.02)
    np.testing.assert_allclose((to.solid_angle * to.unit[..., 2] ** 4).sum(axis=1), 2 * np.pi / 5, rtol=0.02)


@pytest.mark.parametrize(("stretch", "half_turn"), [(1.0, True), (1.6, True), (1.3, False)])
def test_directions_that_a_viewer_beside_a_view_may_sample_are_in_cells_that_are_reached(random, stretch, half_turn):
    polar, azimuth = half_vector_grid.polar_angles(), half_vector_grid.azimuths(half_turn)
    for number in range(POLAR_VIEWS):
        cells = half_vector_grid.reached(number, half_turn, stretch)
        low, high = polar[max(number - 1, 0)], polar[number + 1] if number + 1 < POLAR_VIEWS else np.pi / 2
        theta_o = low + (high - low) * random.random(20_000)
        view = random.integers(len(azimuth), size=20_000)
        spread = azimuth[1] if number else np.pi
        wo = half_vector_grid.outgoing(theta_o, azimuth[view] + spread * (2 * random.random(20_000) - 1))
        wi = half_vector_grid.outgoing(np.arccos(random.random(20_000)), 2 * np.pi * random.random(20_000))
        g = (wi + wo) / [stretch, 1 / stretch, 1]
        largest = (np.pi / 2 + theta_o) / 2
        ring = np.sqrt(np.arctan2(np.hypot(g[:, 0], g[:, 1]), g[:, 2])
                       / np.arctan2(stretch * np.sin(largest), np.cos(largest))) * half_vector_grid.HALF_RINGS
        sector = np.arctan2(g[:, 1], g[:, 0]) / (2 * np.pi) % 1 * half_vector_grid.HALF_SECTORS
        assert ring.max() < half_vector_grid.HALF_RINGS
        assert cells[view, ring.astype(int) * half_vector_grid.HALF_SECTORS + sector.astype(int)].all()


@pytest.mark.parametrize(("name", "degrees"), [("brushed a", 20 + 90), ("brushed b", -35), ("ward b", 45),
                                               ("ward a", 90)])
def test_the_first_axis_is_the_one_along_which_the_highlight_is_longest(name, degrees):
    found = principal(TRUTHS[name])
    off = np.degrees(found.turn) - degrees
    assert abs((off + 90) % 180 - 90) < 2
    assert found.stretch > 1.1
    assert found.half_turn


def test_a_surface_that_half_a_turn_changes_has_views_over_the_whole_turn():
    mixture = anisotropic_mixture.anisotropic_mixture(Slanted())
    assert not mixture.principal.half_turn
    for half_turn in (False, True):
        views = half_vector_grid.views(half_turn)
        assert len(mixture.table) == len(views) == 1 + AZIMUTH_VIEWS * (POLAR_VIEWS - 1)
        assert (views[:, 1] > -1e-9).all() == half_turn
    assert mixture.error < 0.15


@pytest.mark.parametrize("number", [0, 3, 6])
def test_the_mixture_is_nowhere_negative_and_seldom_above_the_fit(brushed, number):
    fit, mixture = brushed
    theta_o, azimuth = half_vector_grid.polar_angles()[number], half_vector_grid.azimuths(True)[[0, 5, 9]]
    to = half_vector_grid.grid(half_vector_grid.outgoing(theta_o, azimuth), mixture.principal.stretch)
    assert mixture.error < 0.1
    for i, (k, phi_o) in enumerate(zip((0, 5, 9), azimuth, strict=True)):
        view = 0 if number == 0 else 1 + (number - 1) * AZIMUTH_VIEWS + k
        wanted = radiance(fit, mixture, to, i, theta_o, phi_o)
        made = anisotropic_mixture.evaluate(mixture, view, half_vector_grid.outgoing(theta_o, phi_o), to.unit[i])
        assert (mixture.table[view, :WEIGHTS] >= 0).all()
        assert made.min() >= 0
        light = to.solid_angle[i] @ wanted
        assert (to.solid_angle[i] @ np.maximum(made - wanted, 0) < 0.03 * light).all()
        assert (to.solid_angle[i] @ np.abs(made - wanted) < 0.15 * light).all()
        np.testing.assert_allclose(to.solid_angle[i] @ (mixture.table[view, ALBEDO_SCALE] * made), light, rtol=0.02)
        weights = mixture.table[view, WEIGHTS:ALBEDO_SCALE].sum(axis=0) * mixture.table[view, ALBEDO_SCALE]
        np.testing.assert_allclose(weights, light, rtol=0.12)


def test_densities_are_those_of_the_directions_that_are_sampled():
    """Each integrates to 1, less the part below the horizon."""
    lobes = [anisotropic_mixture.Lobe(0, 8, 0.0, 8), anisotropic_mixture.Lobe(1, 0.4, 0.05, 0.1),
             anisotropic_mixture.Lobe(1, 0.1, 0.0, 0.3)]
    wo = half_vector_grid.outgoing(0.6, np.array([0.2, 1.4]))
    to = half_vector_grid.grid(wo, 1.0)
    total = (anisotropic_mixture._densities(lobes, wo, to.unit) * to.solid_angle[:, None]).sum(axis=-1)
    assert total == pytest.approx(np.ones((2, 4)), abs=0.12)
    assert (total < 1.03).all()


def test_an_isotropic_reflectance_has_the_same_mixture_for_all_azimuths():
    mixture = closure_mixture(brushed_fit(0.2, 0.2 * (1 + 1e-9)))
    isotropic = closure_mixture(brushed_fit(0.2, 0.2))
    assert isotropic.principal is None
    assert mixture.principal.stretch == pytest.approx(1, abs=0.02)
    assert mixture.error < isotropic.error + 0.05
    rows = mixture.table[1:].reshape(POLAR_VIEWS - 1, AZIMUTH_VIEWS, *mixture.table.shape[1:])
    scale = rows[:, :, ALBEDO_SCALE]
    assert np.ptp(scale, axis=1).max() < 0.02


def test_black_stays_black():
    class Black:
        isotropic = False

        def evaluate(self, *angles):
            return np.zeros((*np.broadcast_shapes(*map(np.shape, angles)), 1))

    mixture = closure_mixture(Black())
    assert np.isfinite(mixture.table).all()
    assert mixture.error < 1e-9
