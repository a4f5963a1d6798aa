"""NVIDIA's .mbsdf: small tables in the test, and the car paint of the MDL SDK."""

import struct

import numpy as np
import pytest

import fitter
from fitter import DatasetError
from support.mbsdf_files import START, made

FILE = "paint.mbsdf"


@pytest.mark.parametrize("block", [b"MBSDF_DATA_REFLECTION=\n", b"MBSDF_DATA=\n"])
@pytest.mark.parametrize("channels", [1, 3])
def test_directions_and_values(load, block, channels):
    """3 x 3 x 5 cells: theta 0, 30, 60 degrees, phi 0, 45 ... 180; at the normal, phi means nothing."""
    samples = load(made((3, 3, 5, channels), block))
    assert (samples.channels, samples.name) == ((("R", "G", "B") if channels == 3 else ("grey",)), "paint")
    table = np.arange(45 * channels).reshape(3, 3, 5, channels)
    expected = {}
    for i in range(3):
        for j in range(3):
            for k in range(5 if i and j else 1):
                expected[30 * i, 30 * j, 45 * k] = table[i, j, k] if i and j else table[i, j].mean(axis=0)
    assert len(samples) == len(expected) == 2 * 2 * 5 + 5
    for theta_i, theta_o, phi, value in zip(samples.theta_i, samples.theta_o, samples.phi_o - samples.phi_i,
                                            samples.values, strict=True):
        place = tuple(round(float(np.degrees(angle)), 6) for angle in (theta_i, theta_o, phi))
        np.testing.assert_allclose(value, expected[place], rtol=1e-6)


def test_transmission_after_reflection_is_left_alone(load):
    both = made() + b"MBSDF_DATA_TRANSMISSION=\n" + struct.pack("<3I", 0, 2, 2) + bytes(32)
    np.testing.assert_array_equal(load(both).values, load(made()).values)


def test_the_car_paint_of_the_sdk(goniometer):
    """Highlights are in the plane of incidence, half a turn from the light, a little beyond the mirrored angle."""
    samples = fitter.load(goniometer("carpaint_blue.mbsdf"), keep_unmeasured=True)
    assert (len(samples), samples.channels) == (44 * 44 * 90 + 89, ("R", "G", "B"))
    assert samples.values.max() == pytest.approx(8.8918, abs=1e-4)
    assert (samples.values < 0).mean() == pytest.approx(0.135, abs=0.002)
    for angle in np.radians([20, 40, 60]):
        here = fitter.samples.subset(samples, np.isclose(samples.theta_i, angle))
        brightest = np.argmax(here.values[:, 2])
        assert here.phi_o[brightest] == pytest.approx(np.pi)
        assert here.theta_o[brightest] - angle == pytest.approx(np.radians(2))


@pytest.mark.parametrize(("content", "expected"), [
    (made()[:-1], r"539 bytes of values found, expected 540 for 3 x 3 x 5 x 3 float32"),
    (made() + b"\0", "541 bytes of values found, expected 540"),
    (made()[:70], "it ends before the table"),
    (made(block=b"MBSDF_DATA_TRANSMISSION=\n"), "transmitted light only, expected reflection"),
    (START, "no line MBSDF_DATA="),
    (made((3, 1, 5, 3)), "type 1, 1 x 1 x 5 values found, expected"),
    (made().replace(struct.pack("<3I", 1, 3, 5), struct.pack("<3I", 7, 3, 5)), "type 7, "),
    (made().replace(struct.pack("<3I", 1, 3, 5), struct.pack("<3I", 1, 2**32 - 1, 2**32 - 1)), "540 bytes of values"),
    (made(values=np.full(135, np.nan)), "not finite"),
])
def test_a_damaged_file_is_refused(load, content, expected):
    with pytest.raises(DatasetError, match=r"bad\.mbsdf: .*" + expected):
        load(content, "bad.mbsdf")
