"""Sums of closure nodes against brute-force integrals of the fits that they approximate."""

import numpy as np
import pytest
import scipy.optimize

import fitter
from fitter.cycles import node_lobes, node_mixture
from fitter.cycles.closure_mixture import closure_mixture
from fitter.cycles.node_lobes import Pairs, Shape
from fitter.cycles.nonnegative import coordinate_descent
from support.cases import quick

CONSTANT = [("diffuse", 1.0, 0.0, 0.0), ("GGX", 0.5, 0.1, 0.4), ("Beckmann", 0.25, 0.0, 0.0), ("sheen", 0.3, 0.0, 0.0)]


class Lobes:
    """A reflectance that is a sum of the first lobes of CONSTANT, the same for all viewers."""

    isotropic = True

    def __init__(self, count=4, scale=1.0):
        colours = np.array([[0.2, 0.1, 0.05], [0.05, 0.1, 0.2], [0.1, 0.1, 0.1], [0.02, 0.03, 0.02]])
        self.colours = scale * colours[:count]

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        theta_i, phi, theta_o = (each.ravel() for each in np.broadcast_arrays(theta_i, phi_i - phi_o, theta_o))
        shape = np.broadcast_shapes(theta_i.shape)
        wi = np.stack([np.sin(theta_i) * np.cos(phi), np.sin(theta_i) * np.sin(phi), np.cos(theta_i)], axis=-1)
        wo = np.stack([np.sin(theta_o), 0 * theta_o, np.cos(theta_o)], axis=-1)
        pairs = Pairs.of(wo, wi[:, None], np.broadcast_to([1.0, 0, 0], wo.shape))
        total = np.zeros((*shape, 3))
        for (kind, *form), colour in zip(CONSTANT, self.colours, strict=False):
            lobe = node_lobes.evaluate(kind, Shape(*(np.full(shape, number) for number in form)), pairs)[:, 0]
            total += lobe[:, None] * colour
        return total / np.maximum(wi[:, 2:], 1e-6)


def sampled(random, count):
    """Directions above the horizon, evenly by solid angle: (count, 3)."""
    z, azimuth = random.random(count), 2 * np.pi * random.random(count)
    return np.stack([np.sqrt(1 - z * z) * np.cos(azimuth), np.sqrt(1 - z * z) * np.sin(azimuth), z], axis=1)


def seen_from(fit, mixture, theta_o, phi_o, wi):
    """Reflected radiance of a fit and of a mixture: (n, channels) each."""
    wo = np.array([np.sin(theta_o) * np.cos(phi_o), np.sin(theta_o) * np.sin(phi_o), np.cos(theta_o)])
    truth = fit.evaluate(np.arccos(wi[:, 2]), np.arctan2(wi[:, 1], wi[:, 0]), theta_o, phi_o)
    return np.maximum(truth, 0) * wi[:, 2:], node_mixture.evaluate(mixture, wo, wi)


def test_the_coordinate_descent_finds_the_least_squares_without_negatives(random):
    for _ in range(20):
        matrix, target = random.standard_normal((30, 5)), random.standard_normal(30)
        found = coordinate_descent(matrix.T @ matrix, matrix.T @ target, None, 300)
        np.testing.assert_allclose(found, scipy.optimize.nnls(matrix, target)[0], atol=1e-6)


@pytest.mark.parametrize(("count", "within"), [(1, 0.01), (2, 0.02), (4, 0.13)])
def test_a_sum_of_such_lobes_is_found(random, count, within):
    """One or two nearly; of four, which hide one another, no worse than about what is found."""
    fit = Lobes(count)
    mixture = node_mixture.node_mixtures(fit).cycles
    assert mixture.error < within
    wi = sampled(random, 20_000)
    for theta_o in (0.03, 0.5, 1.1):
        truth, found = seen_from(fit, mixture, theta_o, 0.7, wi)
        assert np.abs(found - truth).sum() / truth.sum() < 1.3 * within


def test_the_error_that_is_told_is_that_of_brute_force(random, glossy):
    fit = fitter.fit(glossy, **fitter.PRESETS["Draft"])
    wi = sampled(random, 40_000)
    for mixture in node_mixture.node_mixtures(fit):
        angles = np.linspace(0, 1, 24) * np.radians(87)
        each = [seen_from(fit, mixture, angle, 0.0, wi) for angle in angles]
        errors = [np.abs(found - truth).sum() / truth.sum() for truth, found in each]
        assert np.mean(errors) == pytest.approx(mixture.error, rel=0.3)
        assert max(errors) < 1.5 * mixture.worst + 0.02


@pytest.mark.parametrize("material", quick(
    ["felt", "aluminum foil", "velvet", "krylon_blue_RGB", "garnet_red_RGB", "cayman"], "velvet", "krylon_blue_RGB"))
def test_nodes_misplace_at_most_one_and_a_half_times_what_fast_does(random, curet, cornell, material):
    samples = cornell(material) if material in ("krylon_blue_RGB", "garnet_red_RGB", "cayman") else curet(material)
    fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
    mixture = node_mixture.node_mixtures(fit).cycles
    assert mixture.error <= 1.5 * closure_mixture(fit).error
    wi = sampled(random, 60_000)
    for theta_o in np.radians((10, 35, 55)):
        truth, found = (each.mean(axis=0) for each in seen_from(fit, mixture, theta_o, 0.0, wi))
        np.testing.assert_allclose(found, truth, atol=0.02 * truth.mean())


def test_nothing_is_negative_and_black_stays_black():
    black = node_mixture.node_mixtures(Lobes(scale=0.0))
    for mixture in black:
        assert np.abs(mixture.colour).max() < 1e-9
    for mixture in node_mixture.node_mixtures(Lobes()):
        assert (mixture.colour >= 0).all()
        assert ((mixture.shape.roughness > 0) & (mixture.shape.roughness <= 1)).all()
        assert (np.abs(mixture.shape.tilt) <= 1).all()
        assert (np.abs(mixture.shape.anisotropy) < 1).all()


def test_eevee_gets_only_what_it_renders(glossy):
    mixture = node_mixture.node_mixtures(fitter.fit(glossy, **fitter.PRESETS["Draft"])).eevee
    assert set(mixture.kinds) <= {"diffuse", "GGX"}
    assert not mixture.shape.anisotropy.any()


def test_an_anisotropic_highlight_turns_with_the_viewer(random):
    from support.anisotropic import brushed_fit

    fit = brushed_fit()
    mixture = node_mixture.node_mixtures(fit).cycles
    wi = sampled(random, 60_000)
    errors = []
    for theta_o in (0.2, 0.8):
        for phi_o in (0.0, 0.9, 2.2, 4.0):
            truth, found = seen_from(fit, mixture, theta_o, phi_o, wi)
            errors.append(np.abs(found - truth).sum() / truth.sum())
            np.testing.assert_allclose(found.mean(axis=0), truth.mean(axis=0), rtol=0.05)
    assert np.mean(errors) < 0.1
    assert np.mean(errors) == pytest.approx(mixture.error, abs=0.03)
