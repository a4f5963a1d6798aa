"""The energy check: what surfaces of a known albedo are said to reflect, and what explains too much."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.quality import albedo
from fitter.quality.describe import describe
from support import merl_files
from support.cases import release
from tests.fitter.quality.test_conventions import table


def hemisphere(step=15):
    return np.radians(np.meshgrid((10.0, 40.0, 70.0), np.arange(0.0, 81, step), np.arange(0.0, 181, 30)))


def plane():
    i, o = np.meshgrid((10.0, 40.0, 70.0), np.arange(-80.0, 81, 5))
    return np.radians([i, np.abs(o), np.where(o > 0, 180.0, 0.0)])


def samples(grid, values, **more):
    i, o, apart = (np.ravel(angle) for angle in grid)
    return fitter.Samples(i, 0 * i, o, apart, np.ravel(values(i, o, apart))[:, None], **more)


def lambertian(share):
    return lambda i, o, apart: np.full(len(i), share / np.pi)


def gloss(i, o, apart):
    """A highlight above a diffuse .3."""
    half = np.sqrt((np.sin(i) + np.sin(o) * np.cos(apart)) ** 2 + (np.sin(o) * np.sin(apart)) ** 2)
    return 0.3 / np.pi + 3 * np.exp(-(np.arctan2(half, np.cos(i) + np.cos(o)) / 0.12) ** 2)


@pytest.mark.parametrize("grid", [hemisphere(), plane()])
@pytest.mark.parametrize("share", [0.04, 0.5, 0.98])
def test_a_diffuse_surface_reflects_its_albedo(grid, share):
    found = albedo.estimate(samples(grid, lambertian(share)))
    assert found.share == pytest.approx(share, rel=1e-6)
    assert not found.is_doubtful


@pytest.mark.parametrize("grid", [hemisphere(5), plane()])
def test_a_narrow_highlight_is_no_doubt(grid):
    """Also of a scan in the plane of incidence, in which every second value is bright."""
    found = albedo.estimate(samples(grid, gloss))
    assert not found.is_doubtful
    assert 0.3 <= found.share < 0.8


@pytest.mark.parametrize(("times", "share", "question"), [
    (100 * np.pi, 0.98, "reflectance factors in percent? (Values: reflectance_percent)"),
    (np.pi, 0.8, "reflectance factors? (Values: reflectance_factor)"),
    (100, 0.9, "in percent? (Values: brdf_percent) or reflectance factors in percent? (Values: reflectance_percent)"),
    (1e6, 0.5, "in which units?")])
def test_what_would_explain_too_much_light(times, share, question):
    found = albedo.estimate(samples(hemisphere(), lambda *angles: times * lambertian(share)(*angles)))
    assert found.is_doubtful
    assert found.share == pytest.approx(times * share, rel=1e-6)
    assert found.text() == f"{times * share:,.3g} times the light that arrives: {question}"


def test_what_would_explain_next_to_no_light(tmp_path):
    """MERL's layout with values in 1/sr, which reading divides by 1500; what is told to be in percent, and is not."""
    path = tmp_path / "white.binary"
    path.write_bytes(merl_files.pack(np.full((9, 9, 18, 3), 0.8 / np.pi) * merl_files.SCALE))
    found = describe(fitter.load(path)).albedo
    assert found.is_doubtful
    assert found.text().startswith("0.00089 of the light that arrives, less than the blackest paints: values in 1/sr, "
                                   "which MERL's scale has divided by 1500?")
    path.write_bytes(merl_files.pack(np.full((9, 9, 18, 3), 0.8 / np.pi)))
    assert not describe(fitter.load(path)).albedo.is_doubtful
    path = table(tmp_path, ((i, o, 180, 0.1 / np.pi) for i in (0, 30, 60) for o in range(0, 81, 10)))
    assert not describe(fitter.load(path)).albedo.is_doubtful
    for quantity in ("brdf_percent", "reflectance_percent"):
        found = describe(fitter.load(path, quantity=quantity)).albedo
        assert found.text().endswith(": not in percent? (Values: brdf, or reflectance_factor)")
    dark = albedo.estimate(samples(hemisphere(), lambertian(1e-4)))
    assert dark.text() == "0.0001 of the light that arrives, less than the blackest paints: in which units?"


def test_the_issue_s_table_of_percent_is_told_in_the_description(tmp_path):
    path = table(tmp_path, ((i, o, 180, 96 + o / 40) for i in (0, 30, 60) for o in range(0, 81, 10)))
    row, = (row for row in describe(fitter.load(path)).rows() if row[0] == "Albedo")
    assert row[2]
    assert row[1].startswith("303 times the light that arrives: reflectance factors in percent?")
    mended = describe(fitter.load(path, quantity="reflectance_percent"))
    assert mended.albedo.share == pytest.approx(0.97, rel=0.01)


def test_a_cosine_that_is_not_in_the_values_explains_what_dividing_by_it_does(tmp_path):
    i, o, apart = (np.degrees(np.ravel(angle)) for angle in hemisphere())
    o = np.where(o == 75, 86, o)
    rows = np.column_stack([i, o, apart, np.full(len(i), 0.9 / np.pi)])
    path = table(tmp_path, rows, "theta_i,theta_o,phi,BRDF*cos_o")
    found = albedo.estimate(fitter.load(path))
    assert "without a cosine? (Values: brdf)" in found.text()
    assert not albedo.estimate(fitter.load(path, quantity="brdf")).is_doubtful


def test_radians_that_are_read_as_degrees_are_all_at_the_normal(tmp_path):
    i, o, apart = (np.ravel(angle) for angle in hemisphere())
    path = table(tmp_path, np.column_stack([i, o, apart, np.full(len(i), 0.9 / np.pi)]))
    assert albedo.estimate(fitter.load(path)).text().endswith(": angles in radians? (Angles: radians)")
    assert not albedo.estimate(fitter.load(path, angles="radians")).is_doubtful


@pytest.mark.parametrize("name", ["cornell/krylon_blue_RGB.astm", "goniometer/AnoBlackEC2onAlum_fred.txt",
                                  "goniometer/AnoBlackEC1onAlum.zemax.bsdf", "goniometer/aeroglaze_inplane.zemax.bsdf"])
def test_a_real_measurement_is_not_doubted(data, name):
    assert not albedo.estimate(fitter.load(data / name)).is_doubtful


@release
def test_no_real_measurement_and_no_published_fit_is_doubted(data):
    files = [*data.glob("cornell/*"), *data.glob("rgl/*.bsdf"), *data.glob("goniometer/*.*")]
    assert len(files) > 20
    shares = {path.name: albedo.estimate(fitter.load(path)) for path in files}
    assert not {name for name, found in shares.items() if found.is_doubtful}
    curet = fitter.load(data / "curet" / "abrdf.dat", "plaster a")
    assert not albedo.estimate(curet).is_doubtful
    for name in [*fitter.list_published()[::10], "black-obsidian", "specular-black-phenolic"]:
        assert not albedo.estimate(fitter.load_published(name)).is_doubtful


def test_an_anisotropic_highlight_is_not_taken_for_one_around_the_normal():
    """Brushed: the half vector's slope along x counts ten times as much."""
    i, pi, o, po = (np.ravel(grid) for grid in np.meshgrid(
        np.radians((20, 50)), np.radians(np.arange(0, 360, 30)), np.radians(np.arange(0, 80, 10)),
        np.radians(np.arange(0, 360, 30))))
    x, y = (np.sin(i) * turn(pi) + np.sin(o) * turn(po) for turn in (np.cos, np.sin))
    z = np.cos(i) + np.cos(o)
    values = 0.1 + np.exp(-((x / z) / 0.06) ** 2 - ((y / z) / 0.6) ** 2)
    turned = fitter.Samples(i, pi, o, po, values[:, None], isotropic=False)
    assert not albedo.estimate(turned).is_doubtful
    assert albedo.estimate(replace(turned, values=turned.values * 30)).is_doubtful
