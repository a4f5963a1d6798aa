from functools import partial

import numpy as np
import pytest

import fitter
from fitter.samples import subset
from support import truths
from support.cases import release


def rmse(samples, fit):
    return fitter.error_metrics(samples.values, fit.evaluate(*samples.directions)).rmse


@release
def test_the_tolerance_is_met_on_sets_of_every_kind_for_fewer_bytes_than_standard(curet, cornell, monkeypatch):
    # of surfaces that reflect more than they receive, a plausible fit cannot be within any tolerance
    monkeypatch.setattr(fitter.methods.tolerance, "fit", partial(fitter.fit, plausible=False))
    sets = [curet(number) for number in range(1, 62, 12)] + [cornell("garnet_red_RGB")]
    sets += [truth.measured("CURET") for truth in truths.TRUTHS.values()]
    for samples in sets:
        samples = subset(samples, np.flatnonzero((samples.values >= 0).all(axis=1)))    # no fit follows far below zero
        tolerance = 0.05 * float(np.sqrt(np.mean(samples.values ** 2)))
        fit = fitter.fit_within(samples, tolerance)
        assert rmse(samples, fit) <= tolerance, samples.name
        assert fit.nbytes <= 16384 * len(samples.channels), samples.name


@release
def test_a_smaller_tolerance_costs_more(curet):
    samples = curet("velvet")
    fits = [fitter.fit_within(samples, tolerance) for tolerance in (0.05, 0.005, 0.0005)]
    assert all(rmse(samples, fit) <= tolerance for fit, tolerance in zip(fits, (0.05, 0.005, 0.0005), strict=True))
    assert fits[0].nbytes < fits[1].nbytes < fits[2].nbytes


@release
def test_by_held_out_samples(curet):
    samples = curet("plaster a")
    fit = fitter.fit_within(samples, 0.01, held_out=True)
    again = fitter.quality.cross_validation.cross_validate(samples, lambda seen: fitter.fit(
        seen, fit.diffuse_level, fit.specular_level, fit.compression, "kriging"))
    assert again.rmse <= 0.01


@pytest.mark.parametrize("tolerance", [0, -1, float("nan"), 1e-12])
def test_what_cannot_be_reached_is_said(curet, tolerance):
    with pytest.raises(ValueError, match="expected"):
        fitter.fit_within(curet("felt"), tolerance)


@release
@pytest.mark.parametrize("tolerance", [0.03, 0.02, 0.002])
def test_a_grey_set_gets_the_same_fit_as_one_channel_or_as_three(tolerance):
    random = np.random.default_rng(1)
    theta_i, theta_o = np.arcsin(np.sqrt(random.random((2, 150)) * 0.98))
    phi = random.random(150) * 2 * np.pi
    mirror = np.cos(theta_i) * np.cos(theta_o) - np.sin(theta_i) * np.sin(theta_o) * np.cos(phi)
    values = (0.05 / np.pi + 0.5 * np.maximum(mirror, 0) ** 20)[:, None]
    grey = fitter.Samples(theta_i, 0 * theta_i, theta_o, phi, values)
    three = fitter.Samples(theta_i, 0 * theta_i, theta_o, phi, np.repeat(values, 3, axis=1), ("R", "G", "B"))
    of_one, of_three = fitter.fit_within(grey, tolerance), fitter.fit_within(three, tolerance)
    for name in ("diffuse_level", "specular_level", "compression", "nbytes"):
        assert getattr(of_one, name) == getattr(of_three, name), name
    directions = np.random.default_rng(2).random((4, 500)) * [[1.5], [6], [1.5], [6]]
    np.testing.assert_array_equal(np.repeat(of_one.evaluate(*directions), 3, axis=1), of_three.evaluate(*directions))
