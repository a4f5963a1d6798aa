"""The starter library: published parameters of all materials of MERL, as samples."""

import json
import math

import numpy as np
import pytest

import fitter
from benchmarks.report.baselines import neural
from fitter import cli
from fitter.arrays import unit_vectors
from fitter.formats import is_there, list_samples
from fitter.imaging.pictures import lit_sphere
from fitter.model import published
from support.cases import quick
from support.checkout import measurements
from tests.fitter.library.test_ready import at_random

# close to their models with Standard; foams and fabrics whose lobes hardly fall are the hardest
LARGEST_ERRORS = {"chrome": 0.01, "steel": 0.02, "alum-bronze": 0.02, "gold-metallic-paint": 0.02, "red-plastic": 0.03,
                  "white-marble": 0.05}


def by_hand(row, i, o):
    """The formula of Low and others for unit vectors, one after the other, with Fresnel's own equations: red."""
    h = [a + b for a, b in zip(i, o, strict=True)]
    length = math.sqrt(sum(part * part for part in h))
    h = [part / length for part in h]
    cosine = min(sum(a * b for a, b in zip(i, h, strict=True)), 1.0)
    eta = float(row["eta"])
    inside = math.sqrt(1 - (1 - cosine ** 2) / eta ** 2)
    s = (cosine - eta * inside) / (cosine + eta * inside)
    p = (inside - eta * cosine) / (inside + eta * cosine)
    shadowing = min(1, 2 * h[2] * i[2] / cosine, 2 * h[2] * o[2] / cosine)
    fall = (1 + float(row["b"]) * (1 - h[2])) ** float(row["c"])
    return float(row["kd_r"]) / math.pi + float(row["a_r"]) * (s * s + p * p) / 2 * shadowing / (
        math.pi * i[2] * o[2] * fall)


def unit(theta, phi):
    return math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)


def of_merl():
    return [name for name in fitter.list_published() if not published.find(name).is_computed]


def test_there_are_100_materials_50_metals_and_25_translucent_ones_each_with_a_label_and_tags():
    names = fitter.list_published()
    assert len(names) == 175 == len(set(names))
    assert len(of_merl()) == 100
    found = [published.find(name) for name in names]
    assert len({each.label for each in found}) == 175
    for each in found:
        assert each.label
        assert each.tags, each.name
        assert set(each.tags) <= set(published.TAGS), each.name
    for tag in published.TAGS:
        assert any(tag in each.tags for each in found), tag


def test_each_material_is_its_formula_and_says_that_it_is_not_measured():
    rows = {row["name"]: row for row in published._rows("low2012.csv")}
    for name in of_merl():
        samples = fitter.load_published(name)
        for which in np.linspace(0, len(samples) - 1, 12).astype(int):
            theta_i, phi_i, theta_o, phi_o = (float(angle[which]) for angle in samples.directions)
            expected = by_hand(rows[name], unit(theta_i, phi_i), unit(theta_o, phi_o))
            assert samples.values[which, 0] == pytest.approx(expected, rel=1e-6), name
        assert len(samples) <= 2000, name
        assert samples.channels == ("R", "G", "B")
        assert samples.name == published.find(name).label
        assert "not a measurement" in samples.notes[0], name
        assert "2012" in samples.notes[0], name
        assert samples.source == f"published:{name}"


def test_the_figures_are_those_that_were_published():
    path = measurements() / "merl" / "low2012_microfacet.json"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    figures = json.loads(path.read_text("utf-8"))["materials"]
    assert sorted(figures) == of_merl()
    for name, row in figures.items():
        model = published.find(name).model
        assert model.kd.tolist() == row["kd"]
        assert model.a.tolist() == row["A"]
        assert (model.b, model.c, model.eta) == (row["B"], row["C"], row["eta"])


@pytest.mark.parametrize("name", quick(LARGEST_ERRORS, "chrome"))
def test_standard_comes_close_to_a_model_where_it_has_no_samples(name, random):
    model = published.find(name).model
    fitted = fitter.fit(fitter.load_published(name), **fitter.PRESETS["Standard"])
    at = at_random(model, random)
    first, second = (np.cbrt(of.evaluate(*at) * np.cos(at[2])[:, None]) for of in (model, fitted))
    assert np.sqrt(np.mean((first - second) ** 2)) < LARGEST_ERRORS[name] * first.mean()
    difference = lit_sphere(model, 64)[..., :3] - lit_sphere(fitted, 64)[..., :3]
    assert np.sqrt(np.mean(difference ** 2)) < 0.015


def test_a_virtual_path_is_read_like_a_file(capsys, tmp_path):
    samples = fitter.load("published:chrome")
    np.testing.assert_array_equal(samples.values, fitter.load_published("chrome").values)
    assert list_samples("published:chrome") == []
    assert is_there("published:chrome")
    wide = fitter.load("published:chrome", colours="ACEScg")
    assert wide.colours == "ACEScg"
    assert abs(wide.values - samples.values).max() > 0.01
    assert cli.main(["info", "published:chrome"]) == 0
    assert "not a measurement" in capsys.readouterr().out
    assert cli.main(["fit", "published:teflon", "--preset", "Paper", "-o", str(tmp_path / "a.npz")]) == 0
    assert fitter.Fit.load(tmp_path / "a.npz").name == "Teflon"


@pytest.mark.parametrize(("name", "expected"), [("chrom", "did you mean chrome, "), ("Chrome", "did you mean chrome, "),
                                                ("gold", "gold-paint"), ("", "list_published"), ("../x", "no pub")])
def test_an_unknown_name_is_refused_with_similar_ones(name, expected):
    with pytest.raises(fitter.DatasetError, match=expected):
        fitter.load_published(name)
    for read in (fitter.load, list_samples):
        with pytest.raises(fitter.DatasetError, match=f"no published material '{name}'"):
            read(f"published:{name}")
    assert not is_there(f"published:{name}")


def test_a_published_material_has_one_sample():
    with pytest.raises(fitter.DatasetError, match="a single sample"):
        fitter.load("published:chrome", 2)


def test_no_file_with_the_name_of_a_virtual_path_is_opened(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "published:nothing").write_text("theta_i,theta_o,phi,BRDF\n10,10,180,1\n")
    assert not is_there("published:nothing")
    with pytest.raises(fitter.DatasetError, match="no published material"):
        fitter.load("published:nothing")


@pytest.mark.parametrize("name", ["black-fabric", "gold-polished", "gold-brushed"])
def test_no_pair_of_directions_is_sampled_twice(name):
    """Where both are one, the azimuth of their difference says nothing: a ninth of the samples said the same."""
    at = published.directions(published.find(name).model)
    i, o = unit_vectors(*at[:2]).round(9), unit_vectors(*at[2:]).round(9)
    assert len(np.unique(np.hstack([i, o]), axis=0)) == len(i)


def test_what_paints_with_flakes_are_too_bright_off_the_highlight_is_told(random):
    """Against networks that were fitted to the measurements, where the half vector is 25 degrees off the normal."""
    path = measurements() / "merl" / "nbrdf_nets.npz"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    theta_i, theta_o = np.arccos(np.sqrt(random.uniform(np.cos(np.radians(65)) ** 2, 1, (2, 20_000))))
    phi_o = random.uniform(0, 2 * np.pi, 20_000)
    halves = np.array([[*map(sum, zip(unit(i, 0), unit(o, phi), strict=True))]
                       for i, o, phi in zip(theta_i, theta_o, phi_o, strict=True)])
    off = halves[:, 2] < np.cos(np.radians(25)) * np.linalg.norm(halves, axis=1)
    at = theta_i[off], np.zeros(off.sum()), theta_o[off], phi_o[off]
    for name in of_merl():
        found = published.find(name)
        if "metallic" in found.tags:
            ratio = found.model.evaluate(*at).mean() / neural.published(path, name).evaluate(*at).mean()
            assert found.excess == pytest.approx(ratio if ratio > 1.25 else 1, rel=0.06, abs=0.1 * (ratio < 1.25)), name
            assert (f"{found.excess:g} times as bright" in found.description) == (found.excess > 1)
