"""Reciprocity, energy, sign and ringing of models with known values."""

from types import SimpleNamespace

import numpy as np
import pytest

import fitter
from benchmarks.report import ringing
from benchmarks.report.baselines import koenderink
from fitter.coordinates.nusselt import Nusselt
from fitter.quality import physics


def model(function):
    """A model of one channel from a function of (theta_i, phi_i, theta_o, phi_o)."""
    def evaluate(*angles):
        angles = np.broadcast_arrays(*angles)
        return np.broadcast_to(function(*angles), angles[0].shape)[..., None]

    return SimpleNamespace(evaluate=evaluate)


def of_nusselt(function):
    """A model from a function of Nusselt coordinates (..., 3)."""
    return model(lambda *angles: function(Nusselt().encode(*angles)))


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


@pytest.fixture
def spread(random):
    """Samples of 2 kappa_o + lambda_o, at random places."""
    r, turn = np.sqrt(random.random(200)) / 2, random.random(200) * np.pi
    x = np.stack([0.5 + random.random(200) / 2, 0.5 + r * np.cos(turn), 0.5 + r * np.sin(turn)], axis=1)
    return fitter.Samples(*Nusselt().decode(x), (2 * x[:, 1] + x[:, 2])[:, None])


def test_a_function_that_is_monotone_between_samples_does_not_ring(spread):
    linear = of_nusselt(lambda x: 2 * x[..., 1] + x[..., 2])
    assert ringing.ringing(spread, linear) == pytest.approx(0, abs=1e-12)


def test_a_known_oscillation_rings_by_its_variation():
    """Samples 1/4 apart along kappa_o; between two, the model rises and falls by 0.3 while the data rise by 1/4."""
    start = np.array([[0.75, k / 4, 0.5] for k in range(4)])
    end = start + [0, 0.25, 0]
    lines = start, end, np.full((4, 1), 0.25)
    bumps = of_nusselt(lambda x: 0.3 * np.sin(4 * np.pi * x[..., 1])**2)
    assert ringing.ringing(None, bumps, lines) == pytest.approx(2 * 0.3 / 0.25, rel=1e-6)


def test_samples_with_none_between_them_are_neighbours(spread):
    """Where no third sample is in the ball over the line between two, that line is an edge of the tessellation."""
    start, end, difference = ringing.neighbours(spread)
    found = {frozenset((tuple(a), tuple(b))) for a, b in zip(start, end, strict=True)}
    x = Nusselt().encode(*spread.directions).round(5)
    for a in range(len(x)):
        middle = (x + x[a]) / 2
        to_others = np.linalg.norm(x - middle[:, None], axis=2)
        alone = (to_others < np.linalg.norm(x - x[a], axis=1)[:, None] / 2 - 1e-4).sum(axis=1) == 0
        alone[a] = False
        assert alone.any()
        assert all(frozenset((tuple(x[a]), tuple(x[b]))) in found for b in np.flatnonzero(alone))
    np.testing.assert_allclose(difference[:, 0], np.abs((end - start) @ [0, 2, 1]), atol=1e-4)


def test_mirror_images_are_one_sample():
    at = np.radians([10, 50, 30, 70.0, 70.0]), np.radians([30.0, 40, 75, 60, 60]), np.array([1.0, 2, 0.4, 3, -3])
    samples = fitter.Samples(at[0], np.zeros(5), at[1], at[2], np.array([[1.0], [2], [3], [4], [6]]))
    start, _, difference = ringing.neighbours(samples)
    assert len(start) == 6                       # the edges of one tetrahedron
    assert difference.max() == pytest.approx(4)  # 1 and the mean of 4 and 6


def test_on_curet_ringing_falls_as_the_diffuse_level_rises(curet):
    for name in ("felt", "leather", "aluminum foil"):
        samples = curet(name)
        lines = ringing.neighbours(samples)
        coarse, fine = (ringing.ringing(samples, fitter.fit(samples, level, 6, 90), lines) for level in (1, 4))
        assert fine < 0.9 * coarse
