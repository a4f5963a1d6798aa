"""RGL's anisotropic files: Mitsuba's values, which are in the shared data, and the material's own,
known in closed form.

tests/mitsuba/test_rgl_values.py compares with Mitsuba itself.
"""

import time
import tracemalloc

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from fitter.formats import rgl
from support import checkout, tensor_files
from support.anisotropic import unit

FILE = checkout.measurements() / "rgl" / "synthetic_aniso_rgb.bsdf"
real = pytest.mark.skipif(not FILE.is_file(), reason=f"{FILE} is absent")
AZIMUTHS = np.radians(np.arange(-180, 181, 30))


def read(path):
    return rgl.read_table(path.read_bytes())


def part(arrays, count):
    """The arrays of the first `count` azimuths."""
    return arrays | {name: np.ascontiguousarray(arrays[name][:count])
                     for name in ("phi_i", "vndf", "luminance", "rgb")}


@pytest.fixture(scope="module")
def golden():
    """theta_i, phi_i, theta_o, phi_o; f cos theta_o by Mitsuba; and of the material itself."""
    numbers = np.loadtxt(FILE.with_name(f"golden_{FILE.stem}.csv"), delimiter=",")
    return numbers[:, :4].T, numbers[:, 4:7], numbers[:, 7:10]


@real
def test_it_is_what_mitsuba_finds(golden):
    angles, expected, truth = golden
    found = read(FILE).evaluate(*angles) * np.cos(angles[2])[:, None]
    bright = expected > 1e-3
    assert np.count_nonzero(bright) > 500
    assert (np.abs(found - expected) < 1e-4 * expected)[bright].all()
    assert np.median((np.abs(found - truth) / truth)[bright]) < 0.012       # the tables are coarse


@real
def test_a_file_is_read_in_little_time_and_memory():
    content = FILE.read_bytes()
    start = time.process_time()
    samples = rgl.read(content)
    seconds = time.process_time() - start
    tracemalloc.start()
    rgl.read(content)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 150_000 < len(samples) < 300_000
    assert peak < 200e6
    assert seconds < 10         # .4 s on an idle machine


@real
def test_samples_are_the_function_at_its_nodes_and_between(golden):
    table, samples = read(FILE), fitter.load(FILE)
    assert not samples.isotropic
    assert samples.notes[0].startswith("110,645 nodes at 8 angles of incidence and 17 azimuths, ")
    assert samples.notes[1:] == ("synthetic: brushed gold, anisotropic GGX .12/.45 turned by 20 degrees",
                                 "Anisotropic, measured at 16 rotations from 0 to 337.5 degrees")
    some = np.random.default_rng(0).choice(len(samples), 20_000, replace=False)
    values = table.evaluate(*(angle[some] for angle in samples.directions))
    differs = ~np.isclose(values, samples.values[some], rtol=1e-6, atol=1e-9).all(axis=1)
    normal = np.abs(samples.theta_i - samples.theta_o) + np.abs(np.cos(samples.phi_o - samples.phi_i) + 1) < 1e-6
    assert (normal[some] | ~differs).all()          # of a column where the half vector is the normal, the mean
    between = np.setdiff1d(samples.phi_i.round(6), table.phi_i.round(6))
    assert np.degrees(np.diff(between)).max() < 1


@real
def test_half_a_turn_stands_for_a_whole_one(written, golden):
    path = written(part(rgl.read_arrays(FILE.read_bytes()), 9))
    table, whole = read(path), read(FILE)
    theta_i, phi_i, theta_o, phi_o = golden[0]
    turned = np.where(phi_i > 0, np.pi, 0)
    expected = whole.evaluate(theta_i, phi_i - turned, theta_o, phi_o - turned)
    np.testing.assert_allclose(table.evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-4)
    samples = fitter.load(path)
    assert samples.notes[2].startswith("Anisotropic, measured at 8 rotations from 180 to 337.5 degrees")
    assert samples.notes[3].startswith("Symmetry, half turn: ")
    assert 150_000 < len(samples) < 300_000
    values = table.evaluate(*samples.directions)
    assert np.isclose(values, samples.values, rtol=1e-4, atol=1e-4).all(axis=1).mean() > 0.99
    assert len(np.unique(np.floor(np.mod(samples.phi_i + 0.01, 2 * np.pi) / (np.pi / 2)))) == 4


def mirrored(seed=3, count=5, first=-180, last=-90):
    """A material of random tables over a quarter of a turn; sigma is 1, as it is not symmetrical by itself."""
    arrays = tensor_files.anisotropic(tensor_files.material(seed=seed), np.linspace(first, last, count), seed)
    return arrays | {"sigma": np.ones_like(arrays["sigma"])}


def test_a_quarter_of_a_turn_is_mirrored(written, random):
    """In the planes of its first and of its last azimuth: all four images have one value."""
    table = read(written(mirrored()))
    theta_i, theta_o = random.uniform(0.1, 1.3, (2, 400))
    phi_i, phi_o = random.uniform(-np.pi, np.pi, (2, 400))
    expected = table.evaluate(theta_i, phi_i, theta_o, phi_o)
    for factor, turn in ((-1, 0), (1, np.pi), (-1, np.pi)):
        values = table.evaluate(theta_i, factor * phi_i + turn, theta_o, factor * phi_o + turn)
        np.testing.assert_allclose(values, expected, rtol=1e-5)      # azimuths are stored in single precision
    samples = fitter.load(written(mirrored()))
    assert "Symmetry, half turn and mirror" in samples.notes[-1]
    np.testing.assert_allclose(np.unique(np.floor(np.mod(samples.phi_i + 0.01, 2 * np.pi) / (np.pi / 2))), range(4))


def test_azimuths_are_interpolated_and_those_of_half_vectors_are_absolute(written, random):
    """The grid is the unit square, in which the table holds its own coordinates and the azimuth of incidence."""
    arrays = tensor_files.anisotropic(tensor_files.material(angles=(0.1, 0.7, 1.3)), np.degrees(AZIMUTHS))
    arrays["rgb"][:, :, 2] = 1 + np.cos(AZIMUTHS)[:, None, None, None]
    table = read(written(arrays))
    theta_i, theta_o = random.uniform(0.15, 1.25, (2, 500))
    phi_i, phi_o = random.uniform(-np.pi, np.pi, (2, 500))
    wi, wo = unit(theta_i, phi_i), unit(theta_o, phi_o)
    half = (wi + wo) / np.linalg.norm(wi + wo, axis=0)
    x = np.sqrt(2 / np.pi * np.arccos(half[2]))
    y = (np.arctan2(half[1], half[0]) + np.pi) / (2 * np.pi)
    expected = np.stack([0.5 + 0.25 * x + 0.125 * y, 1 + theta_i,
                         1 + np.interp(phi_i, AZIMUTHS, np.cos(AZIMUTHS))], axis=1) / 2 / np.cos(theta_o)[:, None]
    np.testing.assert_allclose(table.evaluate(theta_i, phi_i, theta_o, phi_o), expected, rtol=1e-5)


def test_azimuths_may_begin_anywhere(written, random):
    arrays = mirrored(count=7, first=-180, last=180)
    arrays["vndf"][-1], arrays["rgb"][-1] = arrays["vndf"][0], arrays["rgb"][0]
    later = arrays | {"phi_i": (arrays["phi_i"] + np.pi).astype("<f4")}     # the same tables, half a turn on
    for name in ("vndf", "luminance", "rgb"):
        later[name] = np.concatenate([arrays[name][3:-1], arrays[name][:4]])
    one, other = (read(written(some)) for some in (arrays, later))
    angles = random.uniform(0.1, 1.3, (4, 300)) * [[1], [4], [1], [4]]
    np.testing.assert_allclose(one.evaluate(*angles), other.evaluate(*angles), rtol=1e-5)


def test_flat_spectra_of_several_azimuths_are_grey(written):
    arrays = mirrored()
    spectral = tensor_files.spectral(arrays, np.linspace(400, 700, 31))
    samples, colours = (fitter.load(written(some)) for some in (spectral, arrays))
    np.testing.assert_allclose(samples.values, np.repeat(colours.values[:, 1:2], 3, axis=1), rtol=1e-5)


@pytest.mark.parametrize(("azimuths", "expected"), [
    ([-180, -170, -60], "phi_i from -180 to -60 degrees found, expected rising angles over a turn, a half or a"),
    ([-180, 0, -90], "phi_i from -180 to -90 degrees found, expected rising"),
    ([-180, -180, 180], "expected rising"), ([-180, 0, 3600], "expected rising"),
    ([-180, 0, np.nan], "phi_i holds numbers that are not finite"),
    ([-180, -90, 0, 90], r"vndf has the shape \(3, 3, 5, 6\), expected \(4, 3"), ([-180, 180], "expected")])
def test_azimuths_that_make_no_turn_are_refused(written, azimuths, expected):
    arrays = mirrored(count=3) | {"phi_i": np.radians(azimuths).astype("<f4")}
    with pytest.raises(DatasetError, match=rf"made\.bsdf: .*{expected}"):
        fitter.load(written(arrays))


def test_more_directions_of_incidence_than_an_instrument_has_are_refused(written):
    arrays = tensor_files.anisotropic(tensor_files.material(2), np.linspace(-180, 180, 3500))
    with pytest.raises(DatasetError, match="3,500 azimuths and 3 angles of incidence found, expected at most 10,000"):
        fitter.load(written(arrays))


def test_asked_for_it_is_taken_as_isotropic(written):
    samples = fitter.load(written(mirrored()), isotropic=True)
    assert samples.isotropic
    assert samples.notes[-1] == "Taken as isotropic, as asked"
