"""The requirements of docs/stability.md, for every hard case; that page has the measured figures."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import fitter
from fitter.arrays import unit_vectors
from fitter.lattice import dense, perfect_hash
from support.cases import quick
from support.hard_cases import BOUND, RIGHT, gloss, hard_cases, many, probe
from support.osl_probe import probe_osl
from tools import stability

CASES = hard_cases()
SMOOTH = "values in single precision"
KRIGED = [name for name, options in fitter.PRESETS.items() if options.get("method") == "kriging"]
OTHERS = [name for name in fitter.PRESETS if name not in KRIGED]
QUICK = [name for name in fitter.PRESETS if name != "Reference"]
every_case = pytest.mark.parametrize("name", quick(
    CASES, "one sample", "all in the plane of incidence", "values over 10 orders of magnitude",
    "negative values and zeros", "nothing but zeros", "one value 10,000 times the others"))
# Reference takes seconds a fit: `python -m tools.stability` has it all
every_preset = pytest.mark.parametrize("preset", quick(QUICK, "Paper", "Standard"))


@cache
def fitted(name, preset):
    return CASES[name].fit(preset)


def scale(name):
    return np.abs(CASES[name].samples.values).max() or 1.0


@every_preset
@every_case
def test_a_fit_is_finite_and_bounded_everywhere_and_near_its_samples(name, preset):
    fit = fitted(name, preset)
    finite, largest, error = stability.measure(CASES[name].samples, fit)
    assert finite
    assert largest <= BOUND[preset] / (1 - getattr(fit.transform, "grey", 0.0))
    assert error <= CASES[name].bound(preset)


def test_the_papers_method_misses_a_constant_by_a_few_percent_between_the_samples():
    value = CASES[stability.CONSTANT].samples.values[0, 0]
    missed = np.abs(fitted(stability.CONSTANT, "Paper").evaluate(*probe()) / value - 1).max()
    assert 0.001 < missed < 0.03


@every_case
def test_the_error_of_mba_never_grows_with_the_level(name):
    errors = np.array(stability.errors_by_level(CASES[name].samples, range(7)))
    assert (np.diff(errors) <= 1e-6).all()      # coefficients are stored in single precision


@pytest.mark.parametrize("levels", [(0, None, 0), (8, None, 0), (0, 0, 0), (0, 8, 99.9), (4, 6, 0), (4, 6, 99.9),
                                    (8, 0, 99.9)])
@pytest.mark.parametrize("name", [SMOOTH, "one value 10,000 times the others"])
def test_the_ends_of_levels_and_compression_are_finite_and_bounded(name, levels):
    finite, largest, error = stability.measure(CASES[name].samples, fitter.fit(CASES[name].samples, *levels))
    assert finite
    assert largest <= BOUND["Paper"]
    assert error < 1


@every_preset
def test_two_values_in_one_direction_give_what_lies_between_them(preset):
    between = fitted("two values in one direction", preset).evaluate(0.5, 0, 0.7, 2.0)[0]
    assert 0.2 < between < 0.6
    if preset in OTHERS:
        assert between == pytest.approx(0.4, rel=1e-4)


@every_preset
def test_zeros_stay_zeros(preset):
    assert np.abs(fitted("nothing but zeros", preset).evaluate(*probe())).max() < 1e-5


@every_preset
def test_values_may_be_given_in_single_or_double_precision(preset):
    samples = CASES[SMOOTH].samples
    double = replace(samples, values=gloss(samples.theta_i, samples.theta_o, samples.phi_o)[:, None])
    assert (double.values != samples.values).any()
    change = fitter.fit(double, **fitter.PRESETS[preset]).evaluate(*probe()) - fitted(SMOOTH, preset).evaluate(*probe())
    assert np.abs(change).max() < 1e-2


@every_preset
@pytest.mark.parametrize("exponent", quick([-29, -3, 3, 29], 29))
def test_a_fit_scales_with_its_values(preset, exponent):
    """Reflectance has no natural unit, within single precision and where a fit need not be plausible."""
    samples = CASES[SMOOTH].samples
    plain, scaled = (fitter.fit(replace(samples, values=samples.values * factor), **fitter.PRESETS[preset],
                                plausible=False).evaluate(*probe()) / factor for factor in (1, 10.0 ** exponent))
    np.testing.assert_allclose(scaled, plain, rtol=1e-4, atol=1e-6)


def test_many_samples():
    samples = many(5_000)
    finite, largest, error = stability.measure(samples, fitter.fit(samples))
    assert finite
    assert largest < 1.2
    assert error < 0.02


@pytest.mark.parametrize("preset", OTHERS)
@every_case
def test_single_precision_in_numpy_agrees_with_double(name, preset):
    fit, directions = fitted(name, preset), probe()
    error = np.abs(stability.single_precision(fit, directions) - fit.evaluate(*directions)).max()
    assert error <= 2e-6 * scale(name)


@pytest.mark.parametrize("preset", quick(["Paper", "Standard"], "Standard"))
@pytest.mark.parametrize("name", quick([SMOOTH, "one sample", stability.CONSTANT, "half of them at normal incidence",
                                        "half of them at grazing angles", "values over 10 orders of magnitude",
                                        "one value 10,000 times the others"],
                                       "half of them at grazing angles", "values over 10 orders of magnitude"))
def test_single_precision_in_osl_agrees_with_double(blender, name, preset):
    from measured_brdf.addon.core.blender import osl_support

    fit = fitted(name, preset)
    theta_i, _, theta_o, phi = (angle[::3] for angle in probe())
    phi = np.where(theta_i < 1e-6, 0, phi)          # where incidence is normal, the shader takes it for that of wo
    wi, wo = unit_vectors(theta_i, 0 * phi), unit_vectors(theta_o, phi)
    assert not osl_support.reason_unavailable()
    code = (f"if (pixel < {len(phi)}) {{ int i = 3 * pixel; out = eval_fit(FIT, vector(WI[i], WI[i + 1], WI[i + 2]),"
            f" vector(WO[i], WO[i + 1], WO[i + 2])); }}")
    rendered = probe_osl(fit, code, len(phi), WI=wi.astype(np.float32), WO=wo.astype(np.float32))[:, :1]
    expected = np.maximum(fit.evaluate(theta_i, 0, theta_o, phi), 0)
    assert (np.abs(rendered - expected) <= 2e-5 * (expected + scale(name))).all()


@pytest.mark.parametrize("preset", OTHERS)
@every_case
def test_coefficients_in_half_precision_change_a_fit_by_their_rounding_and_no_more(name, preset):
    """B-spline weights sum to 1: no value changes by more than half a unit in the last place of the largest."""
    fit, directions = fitted(name, preset), probe()
    change = np.abs(stability.halved(fit).evaluate(*directions) - fit.evaluate(*directions)).max()
    assert change <= 2.0 ** -11 * (np.abs(fit.diffuse.control_points).max()
                                   + np.abs(fit.specular.coefficients).max(initial=0)) * 1.01


@pytest.mark.parametrize("level", range(7))
@pytest.mark.parametrize("share", [0.001, 0.1, 1.0])
def test_the_hash_finds_every_key_and_no_other_over_the_whole_lattice(random, level, share):
    count = int(np.prod(dense.shape(level)))
    keys = random.choice(count, max(1, int(share * count)), replace=False)
    slots = perfect_hash.build(keys).slots(np.arange(count))
    assert np.flatnonzero(slots >= 0).tolist() == sorted(keys.tolist())
    assert np.sort(slots[slots >= 0]).tolist() == list(range(len(keys)))


def test_directions_at_the_horizon_and_the_normal_are_where_they_say(random):
    """Exactly grazing and exactly normal samples are fitted like any others."""
    azimuth = random.random(200) * 2 * np.pi
    theta = np.where(np.arange(200) % 2, RIGHT, 0.0)
    samples = fitter.Samples(theta, 0 * azimuth, theta[::-1], azimuth, np.cos(theta)[:, None] + 1)
    fit = fitter.fit(samples)
    np.testing.assert_allclose(fit.evaluate([0.0, RIGHT], 0, [RIGHT, 0.0], [1.0, 2.0])[:, 0], [2, 1], atol=0.05)
