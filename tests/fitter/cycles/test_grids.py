"""The directions at which fits are looked at, against integrals over the hemisphere."""

import numpy as np
import pytest

from fitter.arrays import unit_vectors
from fitter.cycles import direction_grid


@pytest.mark.parametrize("theta_o", [0.0, 0.6, 1.3, direction_grid.GRAZING])
def test_the_directions_about_the_mirror_cover_the_hemisphere(theta_o):
    to = direction_grid.mirror_grid(theta_o)
    np.testing.assert_allclose(np.linalg.norm(to.unit, axis=1), 1)
    assert to.solid_angle.sum() == pytest.approx(2 * np.pi, rel=0.02)
    assert to.solid_angle @ np.cos(to.theta) == pytest.approx(np.pi, rel=3e-3)
    assert to.solid_angle @ np.cos(to.theta) ** 4 == pytest.approx(2 * np.pi / 5, rel=3e-3)


@pytest.mark.parametrize("degrees", [0.5, 1.0, 5.0])
def test_they_are_close_enough_together_for_a_highlight(degrees):
    """A lobe exp(k (cos delta - 1)) about the mirror direction integrates to 2 pi / k."""
    k, to = np.radians(degrees) ** -2, direction_grid.mirror_grid(0.7)
    lobe = np.exp(k * (to.unit @ [-np.sin(0.7), 0, np.cos(0.7)] - 1))
    assert to.solid_angle @ lobe == pytest.approx(2 * np.pi / k, rel=0.03)


@pytest.mark.parametrize("stretch", [1.0, 1.6])
@pytest.mark.parametrize("theta_o", [0.0, 0.5, direction_grid.GRAZING])
def test_the_half_vectors_cover_the_hemisphere(stretch, theta_o):
    wo = unit_vectors(theta_o, np.array([0.0, 0.7, 1.5]))
    to = direction_grid.half_vector_grid(wo, stretch)
    np.testing.assert_allclose(np.linalg.norm(to.unit, axis=-1), 1)
    np.testing.assert_allclose(to.solid_angle.sum(axis=1), 2 * np.pi, rtol=0.05)
    np.testing.assert_allclose((to.solid_angle * to.unit[..., 2]).sum(axis=1), np.pi, rtol=0.02)
    np.testing.assert_allclose((to.solid_angle * to.unit[..., 2] ** 4).sum(axis=1), 2 * np.pi / 5, rtol=0.02)
