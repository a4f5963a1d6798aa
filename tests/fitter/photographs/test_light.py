"""Exposures, photographs of the dark and of an even surface: beside a camera that is simulated."""

import numpy as np
import pytest

import fitter
from fitter.colours import decode_srgb
from fitter.imaging.picture_files import camera_exposure
from fitter.imaging.pictures import srgb
from fitter.photographs import pictures
from fitter.photographs.pictures import Exposure, divide_flat, merge_exposures, subtract_dark


def exposed(radiance, exposure, random):
    """What a camera makes of radiance: photons, electronics, and white at 1."""
    pixels = radiance * exposure
    noise = np.sqrt(pictures.READ ** 2 + pictures.SHOT * pixels) * random.standard_normal(pixels.shape)
    return Exposure(np.minimum(pixels + noise, 1.0), exposure=exposure)


def test_exposures_are_merged_without_bias_and_with_the_noise_that_they_have():
    random = np.random.default_rng(1)
    radiance = np.repeat([0.002, 0.02, 0.2, 2.0], 5000).reshape(4, 5000, 1) * np.ones(3)
    found = merge_exposures([exposed(radiance, exposure, random) for exposure in (0.25, 2.0, 16.0)])
    assert found.known.all()
    scatter = (found.radiance - radiance) / found.noise
    assert np.abs(scatter.mean(axis=(1, 2))).max() < 0.03
    assert np.abs(scatter.std(axis=(1, 2)) - 1).max() < 0.03
    single = exposed(radiance, 0.25, random)
    assert (found.noise[0] < 0.1 * merge_exposures([single]).noise[0]).all()


def test_what_every_exposure_saturates_is_not_known():
    picture = np.full((1, 3, 3), 0.5)
    picture[0, 1, 2] = 0.97
    merged = merge_exposures([Exposure(picture), Exposure(picture, exposure=2.0)])
    assert merged.known.tolist() == [[True, False, True]]


def test_the_room_is_subtracted_and_vignetting_divided():
    y, x = np.mgrid[-1:1:41j, -1:1:61j]
    falls = (1 / (1 + 0.3 * (x ** 2 + y ** 2)) ** 2)[..., None] * np.ones(3)
    truth = 0.1 + 0.05 * np.sin(5 * x)[..., None] * np.ones(3)
    lit, dark = merge_exposures([Exposure((truth + 0.03) * falls)]), merge_exposures([Exposure(0.03 * falls)])
    middle = 0.7 * np.array([1, 0.9, 0.8])
    found = divide_flat(subtract_dark(lit, dark), merge_exposures([Exposure(falls * middle)]), middle)
    np.testing.assert_allclose(found.radiance, truth, rtol=0.01)
    assert (found.noise > np.hypot(lit.noise, dark.noise)).mean() > 0.9


def test_srgb_and_exposures():
    np.testing.assert_allclose(srgb(decode_srgb(np.linspace(0, 1, 50))), np.linspace(0, 1, 50),
                               atol=1e-6)
    assert camera_exposure(0.1, 2.8, 200) == pytest.approx(0.1 / 7.84 * 2)
    with pytest.raises(fitter.DatasetError, match="0 s at f/1"):
        camera_exposure(0)
