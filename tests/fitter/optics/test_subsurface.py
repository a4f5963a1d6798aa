"""Light below a surface: what leaves again, and where, against photons (`support.photons`) and published numbers."""

import numpy as np
import pytest

import fitter
from fitter.formats import is_there
from fitter.model import published
from fitter.optics import subsurface
from support import photons
from support.cases import quick

# what Jensen and others print beside their coefficients, of light that arrives
PUBLISHED = {"apple": (0.85, 0.84, 0.53), "chicken-1": (0.31, 0.15, 0.10), "chicken-2": (0.32, 0.16, 0.10),
             "cream": (0.98, 0.90, 0.73), "ketchup": (0.16, 0.01, 0.00), "marble": (0.83, 0.79, 0.75),
             "potato": (0.77, 0.62, 0.21), "skim-milk": (0.81, 0.81, 0.69), "skin-1": (0.44, 0.22, 0.13),
             "skin-2": (0.63, 0.44, 0.34), "spectralon": (1.00, 1.00, 1.00), "whole-milk": (0.91, 0.88, 0.76)}
PHOTONS = {"marble": 250_000, "skim-milk": 250_000, "skin-1": 150_000, "ketchup": 300_000}


def below(name):
    return published.find(name).model.subsurface


@pytest.mark.parametrize("name", quick(PHOTONS, "skin-1"))
def test_what_leaves_and_how_far_from_where_it_entered_is_as_photons_have_it(name):
    for truth, walk in photons.compare_walk(below(name), PHOTONS[name]):
        assert walk[0] == pytest.approx(truth[0], rel=0.02)
        assert walk[1:] == pytest.approx(truth[1:], rel=0.05)


@pytest.mark.parametrize("index", [1.15, 1.5])
@pytest.mark.parametrize("scattered", [0.3, 0.9])
def test_the_albedos_are_those_of_photons(scattered, index):
    found = photons.radii(scattered, index, 100_000)[1].sum()
    assert subsurface.multiple_scattering_albedo(scattered, index) == pytest.approx(found, rel=0.02)
    found = photons.cycles_radii(scattered, index, 100_000)[1].sum()
    assert subsurface.walk_albedo(scattered, index) == pytest.approx(found, rel=0.02)


def test_walks_that_end_too_early_are_darker_and_a_diffuse_surface_has_the_rest():
    found = photons.cycles_radii(0.999999, 1.14, 20_000)[1].sum()
    assert subsurface.walk_albedo(0.999999, 1.14) == pytest.approx(found, rel=0.01)
    assert found < 0.93
    walk = below("spectralon").walk
    np.testing.assert_allclose(walk.rest + subsurface.walk_albedo(0.999999, walk.entry), 1, atol=1e-9)


@pytest.mark.parametrize("name", PUBLISHED)
def test_albedos_are_those_that_were_published_with_the_coefficients(name):
    """They are of the dipole of the paper, which the surface's reflection takes part in."""
    np.testing.assert_allclose(below(name).albedo, PUBLISHED[name], atol=0.025)


def test_where_two_papers_have_a_medium_they_agree_as_far_as_two_milks_do():
    for one, other in (("skim-milk", "low-fat-milk"), ("whole-milk", "regular-milk")):
        first, second = below(one), below(other)
        np.testing.assert_allclose(first.albedo, second.albedo, atol=0.065)
        assert (second.mean_free_path / first.mean_free_path).min() > 0.5
        assert (second.mean_free_path / first.mean_free_path).max() < 1.2


def test_a_fit_is_its_model_and_comes_back_whole(tmp_path):
    samples = fitter.load("published:skin-1")
    made = fitter.fit(samples, **fitter.PRESETS["Draft"])
    assert made.columns == (0, 0, 0)
    at = 0.4, 0, np.array([0.1, 0.6, 1.1]), 1.5
    np.testing.assert_allclose(made.evaluate(*at), published.find("skin-1").model.evaluate(*at), rtol=0.02)
    made.save(tmp_path / "a.npz")
    back = fitter.Fit.load(tmp_path / "a.npz")
    assert back.to_bytes() == made.to_bytes()
    np.testing.assert_array_equal(back.evaluate(*at), made.evaluate(*at))
    redder = fitter.edited(made, diffuse=[1, 0.5, 0.5])
    np.testing.assert_allclose(redder.edited_subsurface.albedo, made.subsurface.albedo * (1, 0.5, 0.5))
    wide = fitter.load("published:skin-1", colours="ACEScg")
    found = fitter.fit(wide, **fitter.PRESETS["Draft"]).evaluate(*at)
    np.testing.assert_allclose(found, wide.subsurface.diffuse(0.4, at[2]), atol=0.05)


def test_a_material_is_described_by_a_name():
    """As coefficients, and as an albedo and a mean free path."""
    marble = published.find("marble").model.subsurface
    name = "translucent; scattering 2.19 2.62 3; absorption .0021, .0041, .0071; index 1.5; name My marble"
    samples = fitter.load(f"published:{name}")
    assert samples.name == "My marble"
    assert is_there(f"published:{name}")
    assert not is_there("published:translucent; albedo .8")
    np.testing.assert_allclose(samples.subsurface.albedo, marble.albedo)
    samples = fitter.load("published:translucent; albedo .8 .5 .2; path 2; width .3")
    assert samples.subsurface.mean_free_path.tolist() == [2, 2, 2]
    np.testing.assert_allclose(fitter.load("published:translucent; scattering 1; absorption 0").subsurface.albedo, 1)


@pytest.mark.parametrize(("words", "expected"), [
    ("", "expected scattering and absorption, or albedo and path"), ("albedo .5", "or albedo and path"),
    ("albedo 2; path 1", "albedo .*expected 0 to 1"), ("albedo .5; path 0", "mean free path .*expected 1e-06"),
    ("albedo .5; path 1; index 9", "index .*expected 1.1 to 2"), ("albedo .5 .5; path 1", "three numbers"),
    ("albedo x; path 1", "'x', expected three numbers"), ("albedo .5; path 1; colour 3", "'colour', expected"),
    ("scattering 0; absorption 0", "one of each channel"), ("scattering nan; absorption 1", "three numbers"),
    ("albedo .5; path 1; width 0", "width 0, expected 0.01 to 1")])
def test_what_describes_no_medium_is_refused(words, expected):
    with pytest.raises(fitter.DatasetError, match=expected):
        fitter.load(f"published:translucent; {words}")
