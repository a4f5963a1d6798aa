"""What is drawn beyond the end of an instrument is left out, and nothing that was measured."""

import numpy as np
import pytest

import fitter
from fitter.formats import unmeasured
from fitter.formats.reading import BY_DEFAULT, Reading
from fitter.model.microfacet import Microfacet
from fitter.samples import Samples

PAINT = Microfacet(np.array([0.02, 0.03, 0.05]), np.full((1, 3), 3.0), np.array([0.2]), np.array([2.0]),
                   np.array([0.1]))
DRAWN = {"straight": lambda theta, last: last * ((90 - theta) / 15)[:, None], "constant": lambda theta, last: last,
         "zero": lambda theta, last: 0 * last}


def scanned(reflectance, random):
    """A table of outgoing directions to the horizon, with the noise of an instrument."""
    theta_i, phi, theta_o = (np.radians(axis.ravel()) for axis in np.meshgrid(
        [0, 20, 40, 60], np.arange(0, 181, 15), np.arange(0, 91, 3), indexing="ij"))
    values = reflectance(theta_i, phi, theta_o)
    values = values * (1 + 0.01 * random.standard_normal(values.shape))
    return Samples(theta_i, 0 * theta_i, theta_o, phi, values, ("R", "G", "B"))


def painted(theta_i, phi, theta_o):
    return PAINT.evaluate(theta_i, 0, theta_o, phi)


@pytest.mark.parametrize("rule", DRAWN)
def test_what_is_drawn_beyond_75_degrees_is_left_out_and_told(random, rule):
    samples = scanned(painted, random)
    theta = np.degrees(samples.theta_o)
    known = {(i, p): value for i, p, o, value in zip(samples.theta_i, samples.phi_o, theta, samples.values, strict=True)
             if np.isclose(o, 75)}
    last = np.array([known[pair] for pair in zip(samples.theta_i, samples.phi_o, strict=True)])
    values = np.where((theta > 75.1)[:, None], DRAWN[rule](theta, last), samples.values)
    drawn = Samples(*samples.directions, values, samples.channels)
    found = unmeasured.remove_unmeasured(drawn, BY_DEFAULT)
    np.testing.assert_array_equal(found.values, samples.values[theta < 75.1])
    note, = found.notes
    assert note.startswith("Left out as not measured: 260 of 1,612 samples beyond theta_o = 75 degrees")
    assert unmeasured.remove_unmeasured(drawn, Reading(keep_unmeasured=True)) is drawn


def test_angles_of_incidence_at_which_nothing_was_measured_are_left_out_too(random):
    samples = scanned(painted, random)
    ends, values = np.radians(66), samples.values.copy()
    rows = zip(samples.theta_i, samples.phi_o, samples.theta_o, values, strict=True)
    last = {(theta_i, phi): value for theta_i, phi, theta_o, value in rows if np.isclose(theta_o, ends)}
    for row in np.flatnonzero(samples.theta_o > ends + 0.001):
        values[row] = last[samples.theta_i[row], samples.phi_o[row]]
    swapped = Samples(samples.theta_o, samples.phi_i, samples.theta_i, samples.phi_o, values, samples.channels)
    found = unmeasured.remove_unmeasured(swapped, BY_DEFAULT)
    assert np.degrees(found.theta_i.max()) == pytest.approx(66)
    assert "theta_i = 66 degrees, with the value there again" in found.notes[0]


@pytest.mark.parametrize("reflectance", [
    painted, lambda theta_i, phi, theta_o: np.full((len(theta_i), 3), 0.3),
    lambda theta_i, phi, theta_o: 0.3 * np.cos(theta_o)[:, None] * np.ones(3),
    lambda theta_i, phi, theta_o: (0.3 / (np.cos(theta_i) + np.cos(theta_o) + 1e-9))[:, None] * np.ones(3),
    lambda theta_i, phi, theta_o: painted(theta_i, phi, theta_o) * np.cos(theta_o)[:, None]],
    ids=["paint", "Lambertian", "cosine", "Lommel-Seeliger", "paint times cosine"])
@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_surfaces_keep_all_that_was_measured(random, reflectance, noise):
    samples = scanned(reflectance, random)
    if not noise:
        samples = Samples(*samples.directions, reflectance(samples.theta_i, samples.phi_o, samples.theta_o),
                          samples.channels)
    assert unmeasured.remove_unmeasured(samples, BY_DEFAULT) is samples


@pytest.mark.parametrize(("name", "left", "kept"), [
    ("lighttec_C9_Gold.astm", 75, 10_804), ("lighttec_C1_White.astm", 75, 10_804),
    ("carpaint_blue.mbsdf", 80, 118_874)])
def test_files_of_instruments_that_end_early(goniometer, name, left, kept):
    path = goniometer(name)
    samples, whole = fitter.load(path), fitter.load(path, keep_unmeasured=True)
    assert len(samples) == kept < len(whole)
    assert np.degrees(samples.theta_o.max()) == pytest.approx(left, abs=0.01)
    assert any(note.startswith("Left out as not measured") for note in samples.notes)


@pytest.mark.parametrize("name", ["krylon_blue", "garnet_red"])
def test_files_of_instruments_that_measured_all_keep_all(cornell, name):
    assert len(cornell(name)) == 1439
