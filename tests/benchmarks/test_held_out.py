"""The judge: its arithmetic by hand, its errors against the cross-validation of the fitter, and runs that stop."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.held_out import judging, lamps, pictures, ridge, run, sets, summary, supplement, views
from fitter.quality import cross_validation
from fitter.report.methods import METHODS
from fitter.samples import subset
from support.truths import TRUTHS

QUICK = ("Koenderink 8", "level 6")


def synthetic(name):
    found, = sets.named(list(sets._synthetic()), [name])
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
    assert math.isinf(summary.ratio(failed, "held_out_rmse"))
    assert summary.shares([failed])["smallest_rmse"] == 0
    other = record("foil", Standard=(0.3, 0.2), GGX=(None, None), Neural=(0.6, 0.1))
    assert summary.ratio(other, "held_out_rmse") == 0.5
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
    again = METHODS[QUICK[0]](judging.seen_of(samples))
    np.testing.assert_array_equal(again.coefficients, models[QUICK[0]].coefficients)


def test_a_method_that_fails_is_recorded_and_the_others_go_on(monkeypatch):
    def fails(samples):
        raise ZeroDivisionError("no samples")

    monkeypatch.setitem(METHODS, QUICK[1], fails)
    judged, models = judging.judge(synthetic("matte b, CURET"), QUICK)
    assert judged["methods"][QUICK[1]]["failed"] == "ZeroDivisionError('no samples')"
    assert judged["methods"][QUICK[1]]["held_out_rmse"] is None
    assert list(models) == [QUICK[0]]


def test_directions_are_many_about_the_mirror_direction_some_about_the_light_and_none_at_the_horizon():
    theta_i, phi_i, theta_o, phi_o = judging.directions()
    assert len(theta_i) == judging.DIRECTIONS
    assert np.degrees(max(theta_i.max(), theta_o.max())) <= 85
    product = np.sin(theta_i) * np.sin(theta_o) * np.cos(phi_o - phi_i)
    off_mirror, off_light = (np.degrees(np.arccos(np.clip(np.cos(theta_i) * np.cos(theta_o) + sign * product, -1, 1)))
                             for sign in (-1, 1))
    assert 1 / 3 < np.mean(off_mirror <= 15.01) < 0.5
    assert 1 / 6 < np.mean(off_light <= 15.01) < 1 / 3
    assert np.mean(off_mirror < 1) > 0.1
    assert all(map(np.array_equal, judging.directions(), judging.directions()))


def test_each_material_is_in_one_half():
    found = list(sets._synthetic())
    assert {each.name[:-len(", CURET")] for each in found if each.half == "judged" and each.name.endswith("CURET")} == {
        name for name in TRUTHS if name.endswith("b")}
    assert sum(each.half == "judged" for each in found) == len(found) / 2 == 18


def test_halves_of_the_real_data(data):
    found, _ = sets.at_hand()
    half = {each.name: each.half for each in found}
    assert len(half) == len(found)
    assert (half["CURET 1 felt"], half["CURET 2 polyester"]) == ("chosen", "judged")
    assert (half["Cornell krylon_blue_RGB"], half["Cornell cayman"]) == ("chosen", "judged")
    assert {each.half for each in sets.named(found, ["cc_green_malachite"])} <= {"judged"}
    assert sum(each.family == "CURET" for each in sets.at_hand("judged")[0]) == 30


def test_without_measurements_the_synthetic_sets_are_left_and_it_says_why(monkeypatch, tmp_path):
    monkeypatch.setenv("MEASURED_BRDF_DATA", str(tmp_path))
    found, left_out = sets.at_hand()
    assert {each.family for each in found} == {"synthetic"}
    assert any("abrdf.dat" in reason for reason in left_out)


@pytest.fixture
def two():
    return [synthetic("matte b, CURET"), synthetic("velvet b, CURET")]


def test_processes_judge_as_one_does_and_keep_the_order(two, tmp_path):
    alone = run.run(two, QUICK, tmp_path / "one", progress=lambda line: None)
    told = []
    together = run.run(two, QUICK, tmp_path / "two", jobs=2, left_out=["why"], progress=told.append)

    def errors(found):
        return {(each["name"], name, error): row[error] for each in found["sets"]
                for name, row in each["methods"].items() for error in judging.ERRORS}

    assert list(errors(together)) == list(errors(alone))
    assert errors(together) == pytest.approx(errors(alone))
    assert sorted(line[:5] for line in told) == ["[1/2]", "[2/2]"]
    written = json.loads((tmp_path / "two" / "results.json").read_text())
    assert written == together
    assert (written["methods"], written["left_out"], written["code"]) == (list(QUICK), ["why"], run.digest())


def test_an_interrupted_run_continues_where_it_stopped(two, tmp_path, monkeypatch):
    whole = run.run(two, QUICK[:1], tmp_path, progress=lambda line: None)
    lines = (tmp_path / "progress.jsonl").read_text()
    (tmp_path / "progress.jsonl").write_text(lines[:-20])               # stopped in the middle of the second
    judge, judged = judging.judge, []

    def counted(found, methods):
        judged.append(found.name)
        return judge(found, methods)

    monkeypatch.setattr(judging, "judge", counted)
    told = []
    again = run.run(two, QUICK[:1], tmp_path, resume=True, progress=told.append)
    assert judged == [two[1].name]
    assert told[0] == "1 of 2 sets were finished before"
    assert told[1].startswith("[2/2] velvet b, CURET: Koenderink 8 0.")
    assert [each["name"] for each in again["sets"]] == [each["name"] for each in whole["sets"]]
    assert len((tmp_path / "progress.jsonl").read_text().splitlines()) == 2

    run.run(two, QUICK[:1], tmp_path, resume=True, progress=told.append)
    assert len(judged) == 1
    run.run(two, QUICK[1:], tmp_path, resume=True, progress=told.append)        # other methods
    assert len(judged) == 3
    monkeypatch.setattr(run, "digest", lambda: "other code")
    run.run(two, QUICK[1:], tmp_path, resume=True, progress=told.append)
    assert len(judged) == 5
    run.run(two, QUICK[1:], tmp_path, progress=told.append)                     # from the beginning
    assert len(judged) == 7


def test_a_telling_set_whose_view_is_lost_is_judged_again(tmp_path, monkeypatch):
    monkeypatch.setitem(views.TELLING, "matte b, CURET", views.Telling())
    found = [synthetic("matte b, CURET")]
    run.run(found, QUICK[:1], tmp_path, progress=lambda line: None)
    view = views.read(tmp_path, found[0].name)
    assert view.names == ("truth", "Koenderink 8")
    views.path(tmp_path, found[0].name).unlink()
    run.run(found, QUICK[:1], tmp_path, resume=True, progress=lambda line: None)
    assert views.read(tmp_path, found[0].name)


def test_pictures_are_drawn_of_the_telling_sets(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(views, "SIZE", 16)
    monkeypatch.setattr(views.lamps, "row_of_lamps", lambda model: np.full((16, 16, 3), 0.5, np.float32))
    monkeypatch.setitem(views.TELLING, "matte b, CURET", views.Telling(with_ridge=True, with_lamps=True))
    found = run.run([synthetic("matte b, CURET")], QUICK, tmp_path, progress=lambda line: None)
    (tmp_path / "report").mkdir()
    assert pictures.draw(found, tmp_path, tmp_path / "report") == [pictures.SPHERES, pictures.LAMPS, pictures.RIDGE]
    assert (tmp_path / "report" / pictures.RIDGE).stat().st_size > 1000
    assert pictures.draw(results(*THREE), tmp_path) == []


def test_without_matplotlib_there_are_no_pictures(tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "pyplot", lambda: None)
    assert pictures.draw(results(*THREE), tmp_path) == []


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


def test_the_report_says_what_it_took_over_and_what_it_lacks(two):
    found = results(*THREE)
    assert "older than the code of this report" in supplement.origin(found, [])
    found["code"] = run.digest()
    assert supplement.origin(found, []).endswith(", with the code of this report.")
    assert "**2 sets of the half that judges are not among them.**" in supplement.origin(found, two)


def test_the_report_judges_where_nothing_was_judged_before(monkeypatch, two, tmp_path):
    monkeypatch.setattr(supplement, "FOLDER", tmp_path / "held_out")
    monkeypatch.setattr(sets, "at_hand", lambda half: (two, ["a set: why"]))
    monkeypatch.setattr(supplement, "METHODS", {"Standard": None, "level 6": None})
    monkeypatch.setitem(METHODS, "Standard", METHODS["Koenderink 8"])
    monkeypatch.setattr(supplement, "os", SimpleNamespace(cpu_count=lambda: 1))
    first = supplement.judged_sets([], tmp_path)
    assert first.key == "judged_sets"
    assert first.text.startswith("\n## Held-out errors over all sets at hand\n")
    assert "| judged | velvet b, CURET | 196 of 196 samples |" in first.text
    assert "Left out: a set: why." in first.text
    monkeypatch.setattr(run, "run", None)
    assert supplement.judged_sets([], tmp_path).data == json.loads(json.dumps(first.data))
