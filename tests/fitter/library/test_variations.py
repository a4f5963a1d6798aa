"""Variations: against the sum of bounces under water, and what is covered by dust."""

import numpy as np
import pytest

import fitter
from fitter.library import ready
from fitter.library.variations import VARIATIONS, WITHIN_WATER, variation
from fitter.quality.physics import directional_albedo

AT = [np.pi / 4]


@pytest.fixture(scope="module")
def fits():
    return {name: ready.make(name).fit for name in ("pink-felt", "red-specular-plastic", "copper-polished")}


def test_water_sends_back_what_a_denser_medium_reflects_of_diffuse_light():
    """The mean of Fresnel's equations over directions from within, by the cosine."""
    n = 1 / 1.333
    cosine = (np.arange(200_000) + 0.5) / 200_000
    sine2 = (1 - cosine ** 2) / n ** 2
    beyond = np.sqrt(np.maximum(1 - sine2, 0))
    s = (cosine - n * beyond) / (cosine + n * beyond)
    p = (n * cosine - beyond) / (n * cosine + beyond)
    reflected = np.where(sine2 >= 1, 1, (s ** 2 + p ** 2) / 2)
    assert (reflected * 2 * cosine).mean() == pytest.approx(WITHIN_WATER, abs=0.005)


def test_wet_felt_is_darker_by_the_sum_of_its_bounces_and_wet_plastic_is_only_coated(fits):
    edit = variation("wet", fits["pink-felt"])
    albedo = directional_albedo(fitter.edited(fits["pink-felt"], highlight=0), AT)[0]
    bounces = sum((1 - WITHIN_WATER) * albedo * (WITHIN_WATER * albedo) ** n for n in range(60))
    assert np.array(edit["diffuse"]) * albedo == pytest.approx(bounces, rel=1e-6)
    for name in ("red-specular-plastic", "copper-polished"):
        assert variation("wet", fits[name]) == variation("lacquered", fits[name])


def test_dust_covers_two_fifths(fits):
    plastic = fits["red-specular-plastic"]
    edit = variation("dusty", plastic)
    before, after = (directional_albedo(fitter.edited(plastic, highlight=0, diffuse=factor), AT)[0]
                     for factor in (1, edit["diffuse"]))
    lit = before > 0.005
    assert after[lit] == pytest.approx((0.6 * before + 0.4 * np.array([0.42, 0.38, 0.32]))[lit], rel=1e-3)


@pytest.mark.parametrize("name", VARIATIONS)
def test_a_variation_changes_any_material_and_reflects_no_more_light_than_there_is(fits, name):
    for fit in fits.values():
        edited = fitter.edited(fit, **variation(name, fit))
        assert directional_albedo(edited, np.radians([0, 45, 75])).max() < 1.02
        at = np.radians([45]), 0, np.radians([45]), np.pi
        assert not np.allclose(edited.evaluate(*at), fit.evaluate(*at), rtol=0.02)


def test_another_name_is_refused(fits):
    with pytest.raises(ValueError, match="expected one of satin, aged"):
        variation("burnt", fits["red-specular-plastic"])
