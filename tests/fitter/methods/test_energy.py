"""Conservation of energy: directional albedos by SciPy's adaptive cubature, for light arriving and light leaving.

Some fits are fitted; others are made, so that they are narrower and more unphysical than samples would have them.
"""

from functools import cache

import numpy as np
import pytest
from scipy import integrate

import fitter
from fitter import Fit, Samples
from fitter.coordinates.half_difference import HalfDifference
from fitter.coordinates.rusinkiewicz import Rusinkiewicz
from fitter.lattice import dense
from fitter.lattice.dense import DenseLattice
from fitter.methods import energy
from fitter.model.microfacet import Microfacet
from fitter.model.transform import LogRelative, factor_of_angle
from fitter.samples import subset
from fitter.shader_constants import DAMPING_KNOTS
from support import truths
from support.cases import quick

ANGLES = np.linspace(0, np.pi / 2, 200)
AT_MOST = 1.005
GREY = slice(0, 1)


def albedo(model, theta, leaving):
    """The largest of the channels: light that leaves at an angle or that arrives there."""
    def integrand(x):
        other, turn = x.T
        pair = (other, 0, theta, turn) if leaving else (theta, 0, other, turn)
        return 2 * np.maximum(model.evaluate(*pair), 0) * (np.sin(other) * np.cos(other))[:, None]

    # divided at the peaks, which adaptive cubature may not see otherwise
    peaks = [(theta, turn) for turn in (0.05, np.pi - 0.05)] if 0.01 < theta < np.pi / 2 - 0.01 else []
    integral = integrate.cubature(integrand, [0, 0], [np.pi / 2, np.pi], rtol=2e-3, atol=2e-3, points=peaks,
                                  max_subdivisions=5000)
    assert integral.status == "converged"
    return integral.estimate.max()


def albedos(model, angles=ANGLES, rule=albedo):
    """(2, angles): of light that arrives, and of light that leaves."""
    return np.array([[rule(model, theta, leaving) for theta in angles] for leaving in (False, True)])


def lobes(kd, *several):
    """A prior of one channel: a Lambertian and lobes (kind, strength, alpha, gamma, f0)."""
    kinds, ks, alpha, gamma, f0 = zip(*several, strict=True) if several else ((),) * 5
    return Microfacet(np.array([kd]), np.array(ks).reshape(-1, 1), *(np.array(numbers, dtype=float)
                                                                     for numbers in (alpha, gamma, f0)), kinds)


def measured(evaluate, count=350):
    """Samples of one channel at the goniometer's directions, some left out at random, and the peaks none."""
    directions = truths.goniometer()
    values = evaluate(*directions)[:, GREY]
    rest = np.random.default_rng(6).permutation(len(values))
    chosen = np.sort(np.unique(np.concatenate([rest[:count], np.argsort(values[:, 0])[-30:]])))
    return subset(Samples(*directions, values), chosen)


METAL = lobes(0.02, ("mirror", 25.0, 0.1, 2.0, 1.0))                # a peak of 100 / sr, an albedo of 0.8
BRIGHT = lobes(0.36, ("mirror", 1.8, 0.3, 2.0, 0.5))                 # an albedo of 1.3 at the normal
SETS = {
    "retro-reflective": lambda: measured(truths.TRUTHS["retro b"].evaluate),
    "brushed metal": lambda: measured(METAL.evaluate),
    "brighter than light": lambda: measured(BRIGHT.evaluate)}


@cache
def samples_of(name):
    return SETS[name]()


@cache
def fitted(name, plausible=True):
    return fitter.fit(samples_of(name), **fitter.PRESETS["Standard"], plausible=plausible)


def test_the_sets_are_what_they_are_called():
    assert 80 < samples_of("brushed metal").values.max() < 120
    assert albedos(METAL, ANGLES[::20])[:, :8].max() < 0.9
    assert 1.25 < albedo(BRIGHT, 0.0, True) < 1.4


@pytest.mark.parametrize("name", quick(SETS, "brighter than light"))
def test_a_fit_reflects_no_more_light_than_it_receives(name):
    assert albedos(fitted(name), ANGLES[::5]).max() <= AT_MOST


def random_fit(coordinates, prior, size, seed=3):
    """A dense lattice of random numbers of some size above a prior, with damping where it must be."""
    points = dense.representative(3).ravel()
    points = np.random.default_rng(seed).standard_normal(len(points))[points] * size
    diffuse = DenseLattice(3, points.reshape(*dense.shape(3), 1).astype(np.float32))
    return Fit(coordinates, diffuse, None, LogRelative(prior, 0.1, np.array([1e9]), 0.0))


def up_to(degrees):
    """Samples that reach so far; of their values only the message tells."""
    theta = np.radians(np.linspace(0, degrees, 50))
    return Samples(theta, 0 * theta, theta[::-1], 0 * theta, np.ones((50, 1)))


def checked_albedo(fit):
    """The directional albedo that is checked, at `energy.OUTGOING_ANGLES`: (views, channels)."""
    few = energy.reflected_light(fit, energy._FEW_POLAR_ANGLES, energy._COARSE_CELLS)
    return energy._reflected_at_angles(fit, few).sum(axis=2).max(axis=0)


def conserved(fit, samples):
    return energy.conserve_energy(fit, fit.transform, samples)


MADE = {
    "a mirror": (Rusinkiewicz(stretch=33.0), lobes(0.05, ("mirror", 1500.0, 0.015, 2.0, 1.0)), 0.05),
    "a narrow mirror": (Rusinkiewicz(stretch=33.0), lobes(0.05, ("mirror", 20_000.0, 0.004, 2.0, 1.0)), 0.0),
    "a narrow retro-reflector": (Rusinkiewicz(), lobes(0.1, ("retro", 400.0, 0.03, 2.5, 0.5)), 0.05),
    "a Lambertian of albedo 3": (HalfDifference(), lobes(0.95), 0.0),
    "a sheen that is bright at grazing angles": (HalfDifference(), lobes(0.1, ("sheen", 0.8, 1.5, 2.0, 0.2)), 0.1),
    "a rough field": (HalfDifference(stretch=5.0), lobes(0.25, ("mirror", 2.0, 0.4, 2.0, 0.1)), 0.8)}


@pytest.mark.parametrize("farthest", quick([90, 60], 60))
@pytest.mark.parametrize("name", quick(MADE, "a mirror", "a Lambertian of albedo 3", "a rough field"))
def test_whatever_a_fit_is_it_conserves_energy_once_it_is_damped(name, farthest):
    fit = random_fit(*MADE[name])
    damped = conserved(fit, up_to(farthest))
    assert albedos(fit, ANGLES[::16]).max() > 1.05
    assert albedos(damped, ANGLES[::13]).max() <= AT_MOST
    assert damped.transform.damping.shape == (DAMPING_KNOTS, 1)
    assert ((damped.transform.damping >= 0) & (damped.transform.damping <= 1)).all()
    np.testing.assert_array_equal(damped.diffuse.control_points, fit.diffuse.control_points)


@pytest.mark.parametrize("kd", [0.33, 0.5, 3.0])
def test_a_lambertian_that_is_too_bright_becomes_white(kd):
    fit = random_fit(HalfDifference(), lobes(kd), 0.0)
    damped = conserved(fit, up_to(90))
    theta = np.linspace(0, np.pi / 2, 30)
    np.testing.assert_allclose(np.pi * damped.evaluate(theta, 0, theta[::-1], 2.0), 0.999, atol=2e-3)


@pytest.mark.parametrize("name", quick(MADE, "a mirror", "a Lambertian of albedo 3"))
def test_no_more_light_is_lost_than_must_be(name):
    """Of the angles around the largest albedo; the factor is smooth, and so takes more from their neighbours."""
    fit = random_fit(*MADE[name])
    before, after = checked_albedo(fit)[:, 0], checked_albedo(conserved(fit, up_to(90)))[:, 0]
    assert after[before.argmax()] > 0.9
    assert after.max() == pytest.approx(0.999, abs=1e-3)


def test_a_fit_whose_albedo_is_below_1_is_not_touched():
    found = fitted("brushed metal")
    assert albedos(fitted("brushed metal", plausible=False), ANGLES[::10]).max() < 0.99
    assert found.changes == ()
    assert not found.transform.damping.size


def test_a_peak_that_was_measured_is_not_cut():
    """Issue 18: for an albedo of 1.5 beyond the samples, a ceiling took nearly all of a highlight."""
    samples = samples_of("brushed metal")
    error = fitted("brushed metal").evaluate(*samples.directions) - samples.values
    assert np.sqrt(np.mean(error ** 2)) < 0.02 * samples.values.max()


def test_far_from_where_an_albedo_exceeds_1_nothing_is_damped():
    """A retro-reflector that is too bright near the normal, within what was measured."""
    fit = random_fit(*MADE["a narrow retro-reflector"])
    before, found = checked_albedo(fit)[:, 0], conserved(fit, up_to(90))
    over = np.degrees(energy.OUTGOING_ANGLES[before > 0.99])
    assert 40 < over.max() < 65
    factor = factor_of_angle(found.transform.damping, energy.OUTGOING_ANGLES)[:, 0]
    np.testing.assert_allclose(factor[np.radians(over.max() + 17) < energy.OUTGOING_ANGLES], 1, rtol=1e-15)
    assert (factor[before > 1.01] < 1).all()


def test_what_was_not_measured_is_not_made_black():
    fit = random_fit(HalfDifference(), lobes(0.5), 0.0)
    damped = conserved(fit, up_to(70))
    assert damped.evaluate(np.radians(85), 0, np.radians(85), 1.0)[0] > 0.3


@pytest.mark.parametrize(("narrow", "farthest"), [(0.25, 91), (0.02, 91), (0.004, 70)])
def test_the_albedo_is_that_of_an_independent_integral(narrow, farthest):
    prior = lobes(0.1, ("mirror", 0.2 / narrow ** 2, narrow, 2.0, 0.7), ("retro", 2.0, 0.2, 2.0, 1.0))
    fit = random_fit(Rusinkiewicz(), prior, 0.2)
    some = np.flatnonzero(np.radians(farthest) > energy.OUTGOING_ANGLES)[::3]
    expected = albedos(fit, energy.OUTGOING_ANGLES[some]).max(axis=0)
    np.testing.assert_allclose(checked_albedo(fit)[some, 0], expected, rtol=0.02)


def test_the_message_says_where_and_what_it_cost():
    fit, samples = fitted("brighter than light"), samples_of("brighter than light")
    message, = fit.changes
    found = message.split()
    assert message.startswith("directional albedo ")
    assert "(measured up to 85 degrees)" in message
    assert "lowered to 1" in message
    worst = float(found[found.index("most") + 1])
    assert worst == pytest.approx(albedos(fitted("brighter than light", plausible=False), ANGLES[::4]).max(), rel=0.02)
    lost = float(found[found.index("lost") + 1])
    free, damped = (np.maximum(each.evaluate(*samples.directions), 0) * np.cos(samples.theta_o)[:, None]
                    for each in (fitted("brighter than light", plausible=False), fit))
    assert lost == pytest.approx(100 * (1 - damped.sum() / free.sum()), rel=0.05)


def test_a_fit_that_need_not_be_plausible_is_left_as_it_is():
    free = fitted("brighter than light", plausible=False)
    assert free.changes == ()
    assert not free.transform.damping.size
    assert albedos(free, ANGLES[:40:10]).max() > 1.2
