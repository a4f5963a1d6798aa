"""Reciprocity, energy and sign of models with known values."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.report.baselines import koenderink
from fitter.quality import physics


def model(function):
    """A model of one channel from a function of (theta_i, phi_i, theta_o, phi_o)."""
    def evaluate(*angles):
        angles = np.broadcast_arrays(*angles)
        return np.broadcast_to(function(*angles), angles[0].shape)[..., None]

    return SimpleNamespace(evaluate=evaluate)


def test_a_lambertian_is_physical():
    lambertian = model(lambda *_: 0.3 / np.pi)
    assert physics.measure(lambertian) == (0, 0, 0)
    np.testing.assert_allclose(physics.directional_albedo(lambertian, [0, 1.2]), 0.3, rtol=1e-12)


def test_directional_albedo_is_the_integral_over_the_hemisphere():
    """Of cos(theta_i)^4 and of a lobe around the normal's mirror image, in closed form."""
    power = model(lambda theta_i, *_: np.cos(theta_i)**4)
    np.testing.assert_allclose(physics.directional_albedo(power, [0.3]), 2 * np.pi / 6, rtol=1e-3)
    forward = model(lambda theta_i, phi_i, theta_o, phi_o: np.maximum(-np.sin(theta_i) * np.cos(phi_o - phi_i), 0))
    np.testing.assert_allclose(physics.directional_albedo(forward, [0.3]), 2 / 3, rtol=1e-3)


def test_reciprocity_error_is_the_mean_difference_over_the_mean():
    """f = cos^2 theta_i has the mean 1/2 over projected solid angle, and |f - f'| that of two uniform numbers, 1/3."""
    departures = physics.measure(model(lambda theta_i, *_: np.cos(theta_i)**2))
    assert departures.reciprocity_error == pytest.approx((1 / 3) / (1 / 2), rel=0.02)
    assert physics.measure(koenderink.Koenderink(2, np.arange(5.0)[:, None])).reciprocity_error < 1e-12


def test_what_is_negative_is_counted_and_weighed():
    """cos^2 theta_i - 1/4 is below 0 for a quarter; the parts are triangles of 1/4 and 3/4 a side."""
    departures = physics.measure(model(lambda theta_i, *_: np.cos(theta_i)**2 - 0.25))
    assert departures.negative_fraction == pytest.approx(0.25, abs=0.01)
    assert departures.negative_energy == pytest.approx((1 / 4)**2 / (3 / 4)**2, rel=0.05)
