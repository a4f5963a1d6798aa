"""UTIA's .bin: an analytic material on its grid, and each number where a naive reader finds it."""

import time

import numpy as np
import pytest

from fitter import DatasetError
from support import anisotropic as instruments
from support import utia_files

FILE = "fabric01.bin"
TRUTH = instruments.ggx(turn=0.4)


@pytest.fixture(scope="module")
def values():
    return utia_files.values_of(TRUTH)


def test_an_anisotropic_material_is_read_as_it_is(load, values):
    start = time.process_time()
    samples = load(utia_files.pack(values))
    assert time.process_time() - start < 5      # .1 s on an idle machine
    assert (samples.channels, samples.name, samples.isotropic) == (("R", "G", "B"), "fabric01", False)
    assert samples.notes[0].startswith("Values as they are stored; ")
    assert samples.notes[1] == "Anisotropic, measured at 48 rotations from 0 to 352.5 degrees"
    assert len(samples) == (1 + 5 * 48) ** 2
    normal = (samples.theta_i == 0) | (samples.theta_o == 0)
    np.testing.assert_allclose(samples.values[~normal], TRUTH(*samples.directions)[~normal], rtol=1e-12)
    np.testing.assert_allclose(samples.values, TRUTH(*samples.directions), rtol=1e-9)
    assert np.degrees([samples.theta_i.max(), samples.theta_o.max(), samples.phi_o.max()]) == pytest.approx(
        [75, 75, 352.5])


def test_every_number_is_where_a_naive_reader_finds_it(load, random):
    numbers = 0.1 + random.random(3 * 288 * 288)
    samples = load(numbers.tobytes())
    steps = np.rint(np.degrees(np.transpose(samples.directions)) / [15, 7.5, 15, 7.5]).astype(int)
    for row in random.choice(len(samples), 500, replace=False):
        i_theta, i_phi, o_theta, o_phi = steps[row]
        for plane in range(3):
            found = [numbers[plane * 288 ** 2 + 288 * (48 * i_theta + i) + 48 * o_theta + o]
                     for i in ([i_phi] if i_theta else range(48)) for o in ([o_phi] if o_theta else range(48))]
            assert samples.values[row, plane] == pytest.approx(np.mean(found), rel=1e-12)


def test_an_isotropic_material_with_noise_is_found_to_be_one(load, random):
    values = utia_files.values_of(instruments.ggx(0.25, 0.25))
    samples = load(utia_files.pack(values * (1 + 0.05 * random.standard_normal(values.shape))))
    assert samples.isotropic
    assert samples.notes[-1] == "Measured at 48 rotations, which agree: taken as isotropic"


@pytest.mark.parametrize("encoding", ["srgb", "srgb140"])
def test_encoded_values_are_decoded(load, values, encoding):
    """Written by the inverse: IEC 61966-2-1; and that of a hundredth, times 140."""
    def encoded(linear):
        return np.where(linear > 0.0031308, 1.055 * linear ** (1 / 2.4) - 0.055, 12.92 * linear)

    stored = encoded(values) if encoding == "srgb" else 140 * encoded(values / 100)
    samples = load(utia_files.pack(stored), encoding=encoding)
    np.testing.assert_allclose(samples.values, TRUTH(*samples.directions), rtol=0.05)
    assert "asked" in samples.notes[0]
    assert not np.allclose(load(utia_files.pack(stored)).values, samples.values)


def test_negative_values_are_kept_unless_the_encoding_cuts_them(load, values):
    dark = values.copy()
    dark[3, 5, 2] = -0.01
    assert (load(utia_files.pack(dark)).values < 0).any()
    assert (load(utia_files.pack(dark), encoding="srgb140").values >= 0).all()


@pytest.mark.parametrize("change", [
    lambda numbers: np.zeros_like(numbers), lambda numbers: -numbers, lambda numbers: numbers * np.nan,
    lambda numbers: numbers * 1e-200, lambda numbers: numbers * 1e200,
    lambda numbers: np.where(np.arange(len(numbers)) == 7, np.inf, numbers),
    lambda numbers: np.frombuffer(b"0.12\0,34" * len(numbers))])
def test_numbers_that_are_no_reflectances_are_refused(load, random, change):
    content = change(0.3 * random.random(3 * 288 * 288)).tobytes()
    with pytest.raises(DatasetError, match=r"fabric01\.bin: as large as .* UTIA, but its numbers are no reflectances"):
        load(content)


@pytest.mark.parametrize("size", [-8, 8])
def test_another_size_is_no_such_file(load, values, size):
    content = utia_files.pack(values)
    with pytest.raises(DatasetError, match="fabric01"):
        load(content[:size] if size < 0 else content + bytes(size))


def test_another_encoding_is_refused(load, values):
    with pytest.raises(DatasetError, match="encoding 'sRGB' found, expected raw, srgb or srgb140"):
        load(utia_files.pack(values), encoding="sRGB")
