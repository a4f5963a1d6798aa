"""The rims of balls: what nobody measured looks like what was measured."""

import numpy as np
import pytest

import fitter
from fitter import Samples
from fitter.arrays import unit_vectors
from fitter.formats import rgl
from fitter.methods import extrapolation, regression_kriging
from support.cases import quick, release
from support.checkout import measurements
from support.faults import Clipped, albedo, error, ratios_to_samples


@pytest.fixture(scope="module")
def of_rgl():
    def opened(stem):
        path = measurements() / "rgl" / f"{stem}_rgb.bsdf"
        if not path.is_file():
            pytest.skip(f"{path.name} is absent from {path.parent}")
        return fitter.load(path), Clipped(rgl.read_table(path.read_bytes()))
    return opened


@pytest.mark.parametrize(("stem", "limit"), quick(
    [("chm_mint", 0.16), ("cc_green_malachite", 0.10), ("ilm_solo_m_68", 0.13), ("aurora_white", 0.04),
     ("cc_ibiza_sunset", 0.04), ("cm_military_green", 0.04), ("irid_flake_paint1", 0.06), ("vch_silk_blue", 0.06)],
    ("chm_mint", 0.16), ("cc_green_malachite", 0.10)))
def test_a_fit_is_the_authors_own_function_between_the_nodes_and_reflects_as_much(of_rgl, stem, limit):
    """By the authors' reader at 200 pairs of directions, and by integrals of the file's function."""
    samples, table = of_rgl(stem)
    fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
    golden = np.loadtxt(measurements() / "rgl" / f"golden_{stem}_rgb.csv", delimiter=",")
    assert error(fit, golden) < limit
    degrees = [30, 50, 66, 75, 80, 86]
    ratio = albedo(fit, degrees) / albedo(table, degrees)
    assert np.abs(np.log(ratio)).max() < np.log(1.4)
    assert np.abs(np.log(ratio)).mean() < np.log(1.1)


@pytest.mark.parametrize("name", ["lighttec_C9_Gold.astm", "lighttec_C1_White.astm"])
def test_rims_beyond_the_instrument_are_neither_dark_nor_of_another_colour(goniometer, name):
    fit = fitter.fit(fitter.load(goniometer(name)), **fitter.PRESETS["Standard"])
    last, seventy, rim = albedo(fit, [60, 70, 88])
    assert (rim > 0.7 * seventy).all()
    ratio = rim / last
    assert ratio.max() < 1.25 * ratio.min()


@pytest.mark.parametrize("name", ["lighttec_C1_White.astm", "lighttec_C9_Gold.astm"])
def test_within_a_degree_and_a_half_of_a_mirror_nothing_is_beyond_the_samples_around(goniometer, name):
    """The finest cells of a lattice once had no samples, and values up to x3.8."""
    samples = fitter.load(goniometer(name))
    fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
    assert ratios_to_samples(fit, samples).max() < 1.2


@release
def test_between_incidences_of_two_degrees_a_highlight_has_no_hole(goniometer):
    """Its azimuths are .07 degrees apart at 2 degrees of incidence; there were holes down to nothing in the plane."""
    samples = fitter.load(goniometer("carpaint_blue.mbsdf"))
    assert ratios_to_samples(fitter.fit(samples, **fitter.PRESETS["Standard"]), samples)[1] < 2


def test_how_fine_half_angles_are_is_told_by_steps_in_the_plane_of_incidence():
    theta_i, theta_o, phi = (each.ravel() for each in np.meshgrid(np.radians(range(0, 80, 2)), np.radians(
        range(0, 80, 2)), np.pi - np.radians(np.arange(0, 20, 0.5)), indexing="ij"))
    samples = Samples(theta_i, 0 * phi, theta_o, phi, np.ones((len(phi), 1)))
    assert regression_kriging._finest(samples) == pytest.approx(np.sin(np.radians(1)) / 3, rel=0.01)


def test_a_teal_paint_has_a_white_highlight_and_no_red_rim(cornell):
    samples = cornell("cayman")
    fit = fitter.fit(samples, **fitter.PRESETS["Standard"])
    found = fit.evaluate(*samples.directions)
    bright = samples.values.min(axis=1) > 5
    assert np.count_nonzero(bright) >= 2
    hue = found[bright] / samples.values[bright]
    hue /= (found[bright].sum(axis=1) / samples.values[bright].sum(axis=1))[:, None]
    assert np.abs(np.log(hue)).max() < np.log(1.2)
    assert (albedo(fit, [84, 88])[:, 0] < 1.5 * albedo(fit, [84, 88])[:, 1]).all()


def test_directions_that_stand_for_those_beyond_have_their_half_vectors(random):
    limits = extrapolation.MeasuredDomain(*np.radians([75.0, 60.0]))
    pairs = extrapolation.sample_extrapolated(limits, isotropic=True)
    assert len(pairs[0]) > 500
    assert extrapolation.is_extrapolated(pairs[0], pairs[2], limits).all()
    inside = extrapolation.clamp_to_domain(pairs, limits)
    margin = extrapolation.MeasuredDomain(limits.larger + 1e-4, limits.smaller + 1e-4)
    assert not extrapolation.is_extrapolated(inside[0], inside[2], margin).any()

    def half(theta_i, phi_i, theta_o, phi_o):
        both = unit_vectors(theta_i, phi_i) + unit_vectors(theta_o, phi_o)
        return both / np.linalg.norm(both, axis=1, keepdims=True)

    near = np.arccos(np.clip(half(*pairs)[:, 2], -1, 1)) < limits.smaller - 1e-3
    cosine = (half(*pairs) * half(*inside)).sum(axis=1)
    assert np.degrees(np.arccos(np.clip(cosine[near], -1, 1))).max() < 0.1
