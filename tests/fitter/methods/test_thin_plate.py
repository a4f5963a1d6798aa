"""Thin-plate splines: SciPy's, and samples left out one by one."""

import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from fitter.methods import thin_plate


@pytest.fixture
def scattered_values(random):
    mu = random.uniform(-1, 1, (60, 3))
    return mu, np.stack([np.sin(3 * mu[:, 0]) + mu[:, 1] ** 2, np.exp(mu[:, 2])], axis=1)


@pytest.mark.parametrize("smoothing", [1e-6, 0.03, 1.0])
def test_a_spline_is_scipys(scattered_values, random, smoothing):
    mu, z = scattered_values
    spline, _ = thin_plate.fit(mu, z, smoothing, np.zeros(60))
    truth = RBFInterpolator(mu, z, smoothing=smoothing, kernel="thin_plate_spline")
    at = random.uniform(-1.5, 1.5, (400, 3))
    np.testing.assert_allclose(spline.at(at), truth(at), atol=1e-5)


def test_predictions_of_left_out_samples_are_those_of_splines_without_them(scattered_values, random):
    mu, z = scattered_values
    noise = 0.1 * random.random(60)
    _, left_out = thin_plate.fit(mu, z, 0.01, noise)
    for k in range(0, 60, 7):
        rest = np.arange(60) != k
        spline, _ = thin_plate.fit(mu[rest], z[rest], 0.01, noise[rest])
        np.testing.assert_allclose(left_out[k], spline.at(mu[[k]])[0], atol=1e-6)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_samples_in_one_place_give_their_mean(count):
    mu = np.full((count, 3), 0.2)
    spline, _ = thin_plate.fit(mu, np.arange(1.0, count + 1)[:, None], 0.1, np.zeros(count))
    np.testing.assert_allclose(spline.at(mu[:1])[0, 0], (count + 1) / 2, rtol=1e-6)
