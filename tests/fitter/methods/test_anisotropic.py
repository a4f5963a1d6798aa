"""Fits of anisotropic samples, against analytic truths between the samples and against other models."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import fitter
from fitter.methods import tolerance
from fitter.quality import physics
from fitter.quality.cross_validation import cube_root
from fitter.samples import RGB, Samples, subset
from support.anisotropic import ANISOTROPIC, between, brushed_fit, rotations
from support.cases import quick, release
from tests.fitter.methods.test_many_samples import relative

TRUTHS = {truth.name: truth for truth in ANISOTROPIC}
COUNT = 8000                # directions between the samples
STANDARD = fitter.PRESETS["Standard"]


def measured(truth, directions, noise=0.005, seed=0):
    values = truth.evaluate(*directions)
    random = np.random.default_rng(seed)
    return Samples(*directions, values * (1 + noise * random.standard_normal(values.shape)), RGB, isotropic=False)


@cache
def samples(name):
    return measured(TRUTHS[name], rotations(12))


@cache
def standard(name):
    return fitter.fit(samples(name), **STANDARD)


@release
@pytest.mark.parametrize("name", quick(["lacquered b", "woven b"], "lacquered b"))
def test_between_the_samples_it_has_less_than_half_of_the_error_of_other_models(name):
    truth, unseen = TRUTHS[name], between(COUNT)
    ours = relative(truth, standard(name), unseen)
    others = fitter.fit(samples(name), 2, 4, 93.0), fitter.fit(replace(samples(name), isotropic=True), **STANDARD)
    assert others[0].nbytes >= standard(name).nbytes
    assert ours <= 0.5 * min(relative(truth, each, unseen) for each in others)
    assert ours < 0.03


def test_it_is_reciprocal_and_physical_and_small():
    fit = standard("lacquered b")
    assert not fit.isotropic
    assert fit.nbytes <= 3 * 64 * 1024
    departures = physics.measure(fit)
    assert departures.negative_fraction == 0
    assert departures.reciprocity_error < 1e-9
    for phi_o in (0.0, 0.8, 2.0):
        assert physics.directional_albedo(fit, np.radians([0, 40, 75, 88]), phi_o=phi_o).max() <= 1.01


@release
def test_a_frame_that_is_turned_turns_the_fit():
    """The material is turned by 45 degrees, and so are the directions at which it is judged."""
    held = samples("woven b")
    turned = replace(held, phi_i=held.phi_i + np.pi / 4, phi_o=held.phi_o + np.pi / 4)
    a, b, c, d = unseen = between(COUNT)
    values = fitter.fit(turned, **fitter.PRESETS["Draft"]).evaluate(a, b + np.pi / 4, c, d + np.pi / 4)
    true = cube_root(c, TRUTHS["woven b"].evaluate(*unseen))
    assert np.sqrt(np.mean((cube_root(c, values) - true) ** 2) / np.mean(true ** 2)) < 0.03


@release
def test_noise_and_holes_leave_a_smooth_fit(random):
    """5 % noise, and no samples within a cone: the fit is nearer to the truth than its samples are."""
    truth, directions = TRUTHS["lacquered b"], rotations(12)
    noisy = measured(truth, directions, noise=0.05)
    azimuth = (noisy.phi_o - noisy.phi_i) % (2 * np.pi)
    hole = (np.abs(noisy.theta_o - 0.7) < 0.2) & (np.abs(azimuth - 2) < 0.4)
    kept = subset(noisy, ~hole)
    fitted = fitter.fit(kept, **STANDARD)
    assert hole.sum() > 300
    as_measured = SimpleNamespace(evaluate=lambda *_: kept.values)
    assert relative(truth, fitted, kept.directions) < 0.85 * relative(truth, as_measured, kept.directions)
    assert relative(truth, fitted, subset(noisy, hole).directions) < 0.03


@release
def test_half_of_the_values_may_be_zero():
    """A detector that sees nothing below a threshold: no fit of its zeros is negative or has lobes there."""
    full = samples("brushed b")
    dark = full.values.max(axis=1) < np.median(full.values.max(axis=1))
    cut = replace(full, values=np.where(dark[:, None], 0.0, full.values))
    fit = fitter.fit(cut, **STANDARD)
    values = fit.evaluate(*cut.directions)
    assert np.isfinite(values).all()
    assert (values >= 0).all()
    assert np.median(values[dark].max(axis=1)) < 0.2 * np.median(full.values[dark].max(axis=1))
    bright = full.values.max(axis=1) > np.quantile(full.values.max(axis=1), 0.9)
    np.testing.assert_allclose(np.cbrt(values[bright]), np.cbrt(full.values[bright]), rtol=0.1)


@release
def test_isotropic_samples_fitted_as_anisotropic_give_the_isotropic_reflectance():
    """A fit of four axes to a reflectance of three: it is the same at all rotations."""
    truth = replace(TRUTHS["brushed a"], function=lambda *directions: brushed_fit(0.2, 0.2).evaluate(*directions))
    fitted = fitter.fit(measured(truth, rotations(8)), **fitter.PRESETS["Draft"])
    theta_i, phi_i, theta_o, phi_o = unseen = between(COUNT)
    assert relative(truth, fitted, unseen) < 0.01
    here, there = (cube_root(theta_o, fitted.evaluate(theta_i, phi_i + turn, theta_o, phi_o + turn))
                   for turn in (0, 1.3))
    assert np.sqrt(np.mean((here - there) ** 2) / np.mean(here ** 2)) < 0.01


def test_few_samples_are_enough_for_a_lobe(random):
    """150 samples at random: no lattice can be told by them, but a lobe can."""
    truth = TRUTHS["brushed a"]
    few = subset(samples("brushed a"), random.permutation(len(samples("brushed a")))[:150])
    assert relative(truth, fitter.fit(few, **STANDARD), between(COUNT)) < 0.1


def test_the_papers_method_in_four_dimensions_meets_its_samples():
    """A few samples far from each other, at a level whose cells they do not share."""
    few = subset(samples("brushed a"), np.random.default_rng(4).permutation(len(samples("brushed a")))[:12])
    plain, both = fitter.fit(few, 5, None), fitter.fit(few, 2, 5, 0.0)
    assert both.notation == "(2,5,0)"
    theta_i, phi_i, theta_o, phi_o = few.directions
    for fit in (plain, both):
        np.testing.assert_allclose(fit.evaluate(*few.directions), few.values, rtol=2e-3, atol=1e-4)
        np.testing.assert_allclose(fit.evaluate(theta_o, phi_o, theta_i, phi_i), fit.evaluate(*few.directions),
                                   rtol=1e-5)


@release
def test_finer_levels_of_the_papers_method_are_truer_and_level_6_fits_in_memory():
    few = subset(samples("woven b"), np.random.default_rng(5).permutation(len(samples("woven b")))[:300])
    errors = [relative(TRUTHS["woven b"], fitter.fit(few, 2, level, compression), few.directions)
              for level, compression in ((3, 0.0), (4, 0.0), (6, 99.0))]
    assert errors[0] > max(errors[1:])


@pytest.mark.parametrize(("diffuse", "specular"), [(6, None), (2, 7)])
def test_levels_that_are_too_fine_are_refused(diffuse, specular):
    with pytest.raises(ValueError, match="of an anisotropic fit"):
        fitter.fit(samples("brushed a"), diffuse, specular)


@release
def test_the_smallest_fit_within_a_tolerance_is_found_again(monkeypatch):
    monkeypatch.setattr(tolerance, "DIFFUSE_LEVELS", (2,))
    monkeypatch.setattr(tolerance, "KEPT", (0, 188))
    some = subset(samples("woven b"), np.random.default_rng(5).permutation(len(samples("woven b")))[:500])
    fitted = fitter.fit_within(some, 0.05)
    assert np.sqrt(np.mean((fitted.evaluate(*some.directions) - some.values) ** 2)) <= 0.05
    again = fitter.fit(some, **tolerance.fit_arguments(fitted))
    assert again.notation == fitted.notation
    np.testing.assert_array_equal(again.evaluate(*some.directions), fitted.evaluate(*some.directions))
