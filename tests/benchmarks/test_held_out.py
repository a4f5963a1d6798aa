"""The judge: its arithmetic by hand, its errors against the cross-validation of the fitter, what pictures show."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.harness import running
from benchmarks.held_out import bench, judging, lamps, pictures, ridge, sets, summary, views
from benchmarks.report.methods import METHODS
from fitter.quality import cross_validation
from fitter.samples import subset
from support.truths import TRUTHS

QUICK = ("Koenderink 8", "level 6")


def synthetic(name):
    found, = running.named(sets._synthetic(), [name])
    return found


def record(name, half="judged", family="CURET", truth=None, **errors):
    """A record of judging: for each method (RMSE, cube root) held out, and the same against the truth."""
    methods = {}
    for method, held_out in errors.items():
        pairs = (held_out, (truth or {}).get(method, (None, None)))
        methods[method] = dict(zip(judging.ERRORS, [value for pair in pairs for value in pair], strict=True))
        methods[method] |= {"bytes": 3000, "seconds": 1.0}
    return {"name": name, "half": half, "family": family, "samples": 205, "judged": 205, "folds": 5, "channels": 2,
            "methods": methods}


def results(*records):
    return {"methods": list(records[0]["methods"]), "sets": list(records), "left_out": [], "commit": "abc",
            "code": "0", "seconds": 1.0, "machine": "a machine"}


THREE = (record("felt", Standard=(0.2, 0.10), GGX=(0.4, 0.20), Neural=(0.3, 0.11)),        # first by both
         record("moss", Standard=(0.3, 0.21), GGX=(0.2, 0.20), Neural=(0.4, 0.30)),        # behind, near by one
         record("straw", Standard=(0.1, 0.30), GGX=(0.1, 0.20), Neural=(0.2, 0.25)))       # equal, and behind


def test_shares_are_those_counted_by_hand():
    found = summary.shares(list(THREE))
    assert found["sets"] == 3
    assert (found["smallest_cube_root"], found["near_cube_root"], found["smallest_rmse"]) == pytest.approx(
        (1 / 3, 2 / 3, 2 / 3))
    assert found["worst_cube_root"] == [("straw", pytest.approx(1.5)), ("moss", pytest.approx(1.05))]
    assert found["worst_rmse"] == [("moss", pytest.approx(1.5))]
    assert found["largest_bytes"] == 1500


def test_shares_against_the_truth_are_of_the_sets_that_have_one():
    with_truth = record("velvet a", family="synthetic", truth={"Standard": (2.0, 1.0), "GGX": (1.0, 4.0)},
                        Standard=(1.0, 1.0), GGX=(1.0, 1.0))
    found = summary.shares([THREE[0], with_truth], "truth")
    assert (found["sets"], found["smallest_cube_root"], found["smallest_rmse"]) == (1, 1, 0)
    assert summary.shares([THREE[0]], "truth") is None


def test_where_standard_failed_it_lost_and_others_that_failed_do_not_count():
    failed = record("foil", Standard=(None, None), GGX=(0.4, 0.2), Neural=(0.3, 0.1))
    assert summary.shares([failed])["smallest_rmse"] == 0
    other = record("foil", Standard=(0.3, 0.2), GGX=(None, None), Neural=(0.6, 0.1))
    assert summary.shares([other])["smallest_rmse"] == 1
    assert "| 0.3 / 0.2 | failed | 0.6 / **0.1** |" in summary.all_sets(results(other)).replace("**0.3**", "0.3")


def test_the_tables_tell_halves_and_families_apart_and_mark_the_best():
    text = summary.text(results(*THREE, record("rug", half="chosen", Standard=(0.2, 0.1), GGX=(0.4, 0.2),
                                               Neural=(0.3, 0.3))), ["held_out_spheres.png"])
    assert "| judged | CURET | 3 | 33 % | 67 % | 67 % | 1,500 |" in text
    assert "| chosen | all | 1 | 100 % | 100 % | 100 % | 1,500 |" in text
    assert "| wanted |  |  | 90 % | 100 % | 75 % | at most 16,384 |" in text
    assert "- judged, cube root: straw 1.50, moss 1.05\n- judged, RMSE: moss 1.50\n" in text
    assert "| judged | moss | 205 of 205 samples | 1,500 | 0.3 / 0.21 | **0.2** / **0.2** | 0.4 / 0.3 |" in text
    assert "![held_out_spheres](held_out_spheres.png)" in text
    assert "of the truth:" not in text


def test_a_small_set_is_predicted_in_five_folds_as_cross_validation_does():
    found = synthetic("matte b, CURET")
    samples, truth = found.open()
    judged, models = judging.judge(found, QUICK)
    assert (judged["folds"], judged["judged"], judged["samples"]) == (5, 196, 196)
    for name in QUICK:
        expected = cross_validation.held_out(samples, METHODS[name])
        row = judged["methods"][name]
        assert (row["held_out_rmse"], row["held_out_cube_root_rmse"]) == pytest.approx(tuple(expected))
        assert row["bytes"] == models[name].nbytes
        at = judging.directions()
        error = models[name].evaluate(*at) - truth.evaluate(*at)
        assert row["truth_rmse"] == pytest.approx(np.sqrt(np.mean(error**2)))


def test_of_a_large_set_one_fold_is_predicted_and_never_beyond_85_degrees():
    samples = TRUTHS["matte b"].measured("goniometer")
    part = cross_validation.folds(len(samples))[0]
    theta_o = samples.theta_o.copy()
    theta_o[part[:7]] = np.radians(87)
    samples = replace(samples, theta_o=theta_o)
    found = sets.JudgedSet("dark", "CURET", "judged", lambda: (samples, None))
    judged, models = judging.judge(found, QUICK[:1])
    kept = part[7:]
    assert (judged["folds"], judged["judged"]) == (1, len(kept))
    unseen = subset(samples, kept)
    expected = cross_validation.errors(unseen, models[QUICK[0]].evaluate(*unseen.directions))
    row = judged["methods"][QUICK[0]]
    assert row["held_out_rmse"] == pytest.approx(expected.rmse)
    assert row["truth_rmse"] is None
    again = METHODS[QUICK[0]](subset(samples, np.setdiff1d(np.arange(len(samples)), part)))
    np.testing.assert_array_equal(again.coefficients, models[QUICK[0]].coefficients)


def test_each_material_is_in_one_half():
    found = list(sets._synthetic())
    assert {each.name[:-len(", CURET")] for each in found if each.half == "judged" and each.name.endswith("CURET")} == {
        name for name in TRUTHS if name.endswith("b")}
    assert sum(each.half == "judged" for each in found) == len(found) / 2 == 18


def test_halves_of_the_real_data(data, monkeypatch):
    monkeypatch.setattr(sets.fitter, "load", lambda path: None)         # each file of RGL, to see whether it is there
    found, _ = sets.at_hand()
    half = {each.name: each.half for each in found}
    assert len(half) == len(found)
    assert (half["CURET 1 felt"], half["CURET 2 polyester"]) == ("chosen", "judged")
    assert (half["Cornell krylon_blue_RGB"], half["Cornell cayman"]) == ("chosen", "judged")
    assert {each.half for each in running.named(found, ["cc_green_malachite"])} <= {"judged"}
    assert sum(each.family == "CURET" for each in sets.at_hand("judged")[0]) == 30


def test_without_measurements_the_synthetic_sets_are_left_and_it_says_why(monkeypatch, tmp_path):
    monkeypatch.setenv("MEASURED_BRDF_DATA", str(tmp_path))
    found, left_out = sets.at_hand()
    assert {each.family for each in found} == {"synthetic"}
    assert any("abrdf.dat" in reason for reason in left_out)


def test_a_telling_set_is_drawn_and_judged_again_where_its_view_is_lost(tmp_path, monkeypatch):
    monkeypatch.setattr(views, "SIZE", 16)
    monkeypatch.setattr(views.lamps, "row_of_lamps", lambda model: np.full((16, 16, 3), 0.5, np.float32))
    monkeypatch.setitem(views.TELLING, "matte b, CURET", views.Telling(with_ridge=True, with_lamps=True))
    quick, found = bench.of(QUICK[:1]), [synthetic("matte b, CURET")]
    results = running.run(quick, found, tmp_path, progress=lambda line: None)
    assert views.read(tmp_path, found[0].name).names == ("truth", "Koenderink 8")
    (tmp_path / "report").mkdir()
    assert quick.draw(results, tmp_path, tmp_path / "report") == [pictures.SPHERES, pictures.LAMPS, pictures.RIDGE]
    assert (tmp_path / "report" / pictures.RIDGE).stat().st_size > 1000
    assert quick.draw({**results, "sets": list(THREE)}, tmp_path) == []
    record, = results["sets"]
    assert quick.is_whole(record, tmp_path)
    assert not bench.of(QUICK).is_whole(record, tmp_path)               # of other methods
    views.path(tmp_path, found[0].name).unlink()
    assert not quick.is_whole(record, tmp_path)


class Lobe:
    """A narrow lobe about the mirror direction, of energy 1: a Gaussian of the angle from it over the cosine."""

    def __init__(self, degrees=0.5):
        self.width = np.radians(degrees)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        cosine = np.cos(theta_i) * np.cos(theta_o) - np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o - phi_i)
        angle = np.arccos(np.clip(cosine, -1, 1))
        lobe = np.exp(-(angle / self.width) ** 2) / (np.pi * self.width**2) / np.cos(theta_o)
        return lobe[..., None] * np.array([1.0, 2.0, 3.0])


def test_the_energy_of_a_narrow_lobe_is_the_same_all_along_the_ridge():
    found = ridge.energy(Lobe(), np.radians([0, 30, 75]))
    np.testing.assert_allclose(found, [[1, 2, 3]] * 3, rtol=1e-3)


def test_measured_incidences_are_those_of_a_grid():
    assert np.degrees(ridge.measured(TRUTHS["matte b"].measured("Cornell"))).round(6).tolist() == [
        10, 20, 30, 40, 50, 60, 70, 80]


def test_a_lamp_is_mirrored_at_its_incidence_and_half_a_degree_wide():
    assert (len(lamps.INCIDENCES), lamps.COUNT) == (32, 32)
    for incidence in lamps.INCIDENCES[[0, 5, 16, 31]]:
        centre, *ring = lamps.disk(incidence)
        half = centre + (0, 0, 1)
        assert half[2] / np.linalg.norm(half) == pytest.approx(np.cos(incidence))
        angles = np.degrees(np.arccos(np.clip(np.array(ring) @ centre, -1, 1)))
        np.testing.assert_allclose(angles, 0.25 * np.sqrt(2 / 3), rtol=1e-3)
    assert lamps._WEIGHTS.sum() == 1


def test_a_row_of_lamps_shows_a_line_of_dots():
    picture = lamps.row_of_lamps(Lobe(2), 200)
    assert picture.shape == (200, 200, 3)
    np.testing.assert_allclose(picture[..., 1], 2 * picture[..., 0], rtol=1e-5, atol=1e-9)
    dots = pictures._highlights(picture)
    assert dots.max() < 3 * dots.min()
    bright = picture.max(axis=2) > 0.2 * dots.min()
    assert 32 <= bright.sum() < 800
