"""The parts of the estimate between the samples: the prior, the Gaussian process, and both together."""

import numpy as np
import pytest

from fitter import Samples
from fitter.methods import gaussian_process, prior
from fitter.methods.regression_kriging import Estimate
from fitter.model.microfacet import Microfacet
from fitter.model.transform import LogRelative


@pytest.fixture
def directions(random):
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 800)) * 0.97))
    return theta_i, np.zeros(800), theta_o, random.random(800) * 2 * np.pi


LOBES = Microfacet(np.array([0.02, 0.05]), np.array([[2.0, 1.5], [0.3, 0.4]]), np.array([0.1, 0.5]),
                   np.array([2.0, 3.0]), np.array([0.05, 0.4]))


def test_the_prior_is_burleys_distribution_schlicks_fresnel_and_heitzs_visibility():
    theta_i, theta_o, phi = 0.7, 1.1, 2.5
    i, o = (np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
            for t, p in ((theta_i, 0), (theta_o, phi)))
    h = (i + o) / np.linalg.norm(i + o)
    expected = LOBES.kd.copy()
    for ks, alpha, gamma, f0 in zip(LOBES.ks, LOBES.alpha, LOBES.gamma, LOBES.f0, strict=True):
        tan2 = 1 / h[2] ** 2 - 1
        fresnel = f0 + (1 - f0) * (1 - i @ h) ** 5
        smith = [n * np.sqrt(alpha**2 + (1 - alpha**2) * m**2) for n, m in ((i[2], o[2]), (o[2], i[2]))]
        expected += ks * (1 + tan2 / alpha**2) ** -gamma * fresnel * 0.5 / (sum(smith) + 1e-3)
    np.testing.assert_allclose(LOBES.evaluate(np.array([theta_i]), 0, theta_o, phi)[0], expected, rtol=1e-9)


def test_the_prior_finds_the_lobes_that_made_its_samples(directions):
    values = LOBES.evaluate(*directions)
    found = prior.fit(Samples(*directions, values, ("a", "b")), float(np.median(values)))
    np.testing.assert_allclose(found.evaluate(*directions), values, rtol=0.02, atol=0.002)


def test_the_prior_scales_with_its_samples(directions):
    values = LOBES.evaluate(*directions)
    small, large = (prior.fit(Samples(*directions, values * scale, ("a", "b")), scale * float(np.median(values)))
                    for scale in (1e-12, 1e12))
    np.testing.assert_allclose(small.evaluate(*directions) * 1e24, large.evaluate(*directions), rtol=1e-6)


def brute_correlation(a, b):
    """The kernel of one pair, image by image."""
    total = 0.0
    for image in ((1, 1, 1), (1, 1, -1), (-1, -1, 1), (-1, -1, -1)):
        for exchange, weight in ((1, 1 - gaussian_process.RECIPROCITY / 2), (-1, gaussian_process.RECIPROCITY / 2)):
            other = [b[0] * image[0], b[1] * image[1] * exchange, b[2] * image[2]]
            distance = np.sqrt(sum((p - q) ** 2 for p, q in zip(a, other, strict=True)))
            for share, length in ((1 / 3, 0.3), (2 / 3, 1.0)):
                r = np.sqrt(5) * distance / length
                total += weight / 4 * share * (1 + r + r * r / 3) * np.exp(-r)
    return total


def test_kriging_is_the_textbooks_formula(random):
    mu, probe = random.random((12, 3)), random.random((5, 3)) * [1, 2, 1] - [0, 1, 0]
    z, noise = random.standard_normal((12, 2)), np.full(12, 0.01)
    matrix = np.array([[brute_correlation(a, b) for b in mu] for a in mu]) + 0.01 * np.eye(12)
    cross = np.array([[brute_correlation(a, b) for b in mu] for a in probe])
    field = gaussian_process.krige(mu, z, noise)
    np.testing.assert_allclose(field.at(probe), cross @ np.linalg.inv(matrix) @ z, atol=1e-7)
    np.testing.assert_allclose(field.at(probe * [1, 1, -1]), field.at(probe), atol=1e-12)
    np.testing.assert_allclose(field.at(probe * [-1, -1, 1]), field.at(probe), atol=1e-12)


def test_field_and_reflectance_are_inverse(directions):
    values = LOBES.evaluate(*directions)
    transform = LogRelative(prior.lambertian(values), 0.05, np.array([np.inf, np.inf]))
    back = transform.reflectance(transform.field(values, *directions), *directions)
    np.testing.assert_allclose(back, values, rtol=1e-9)


def estimated(estimate, *angles):
    """The reflectance that an estimate predicts."""
    return estimate.transform.reflectance(estimate.field.at(2 * estimate.coordinates.encode(*angles) - 1), *angles)


def test_an_estimate_predicts_what_it_has_not_seen_and_is_nearly_reciprocal(directions, random):
    values = LOBES.evaluate(*directions)
    estimate = Estimate(Samples(*directions, values, ("a", "b")))

    def at(*angles):
        return estimated(estimate, *angles)

    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 300)) * 0.9))
    phi = random.random(300) * 2 * np.pi
    there, back = at(theta_i, np.zeros(300), theta_o, phi), at(theta_o, phi, theta_i, np.zeros(300))
    np.testing.assert_allclose(there, LOBES.evaluate(theta_i, 0, theta_o, phi), rtol=0.05, atol=0.005)
    np.testing.assert_allclose(there, back, rtol=0.05, atol=0.005)


def test_a_reading_of_nothing_in_the_midst_of_a_lobe_is_not_believed(directions):
    values = LOBES.evaluate(*directions)
    peak = np.argmax(values.sum(axis=1))
    blind = np.where(np.arange(800)[:, None] == peak, 0, values)
    estimate = Estimate(Samples(*directions, blind, ("a", "b")))
    seen = estimated(estimate, *(angle[[peak]] for angle in directions))
    np.testing.assert_allclose(seen, values[[peak]], rtol=0.4)
