"""The harness of both benches: errors by hand, directions, runs that stop and go on, and what is told of them."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.harness import command, judging, running, summary
from fitter.samples import Samples


@pytest.fixture
def bench():
    """A bench of things that are judged at once; `asked` lists them, and each writes a file."""
    asked = []

    def judge(thing, out):
        asked.append(thing.name)
        (out / thing.name).touch()
        return {"name": thing.name, "models": {"a": {"rmse": 0.25}, "b": {"rmse": None, "failed": "why"}}}

    found = running.Bench(
        "made_up", "things", "A title", " Of nothing.", judge, lambda record, out: (out / record["name"]).is_file(),
        "models", "rmse", lambda results, pictures: f"{len(results['things'])} things, {pictures}", lambda _: "well",
        lambda results, out, into=None: [str(into or out)], ("support/sheet.py",), {"methods": ["a", "b"]})
    return SimpleNamespace(bench=found, asked=asked)


def things(*names):
    return [SimpleNamespace(name=name) for name in names]


def test_errors_are_those_by_hand():
    theta, truth, found = np.array([0.0, np.pi / 3]), np.array([[8.0], [16.0]]), np.array([[1.0], [54.0]])
    assert judging.errors("there", theta, truth, found) == pytest.approx(
        {"there_rmse": math.sqrt((49 + 38 ** 2) / 2), "there_cube_root_rmse": 1.0, "there_cube_root_mae": 1.0})
    assert list(judging.errors("there", theta, truth, found, ("rmse",))) == ["there_rmse"]
    with pytest.raises(ArithmeticError, match="there"):
        judging.errors("there", theta, truth, found * np.inf)


def test_what_fails_is_recorded():
    row = judging.attempted(lambda: 1 / 0, ("rmse", "bytes"))
    assert (row["rmse"], row["bytes"], row["failed"][:17]) == (None, None, "ZeroDivisionError")
    assert judging.attempted(lambda: {"rmse": 1.0, "seconds": 7.0}, ()) == {"rmse": 1.0, "seconds": 7.0}


def test_samples_at_the_horizon_are_not_judged():
    angles = np.radians([0, 85, 86, 40])
    samples = Samples(angles, 0 * angles, angles[::-1], 0 * angles, np.ones((4, 1)))
    assert judging.are_judged(samples).tolist() == [True, False, False, True]


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


def test_an_interrupted_run_continues_where_it_stopped(bench, tmp_path, monkeypatch):
    told = []

    def run(*names, resume=True):
        bench.asked.clear()
        return running.run(bench.bench, things(*names), tmp_path, 1, resume, ["why"], told.append)

    whole = run("a", "b")
    assert bench.asked == ["a", "b"]
    assert told[-1].startswith("[2/2] b: a 0.25, b failed; 0 s, ")
    assert json.loads((tmp_path / "results.json").read_text()) == whole
    assert [record["name"] for record in whole["things"]] == ["a", "b"]
    assert (whole["left_out"], whole["methods"], whole["code"]) == (["why"], ["a", "b"], running.digest(bench.bench))
    lines = (tmp_path / "progress.jsonl").read_text()
    (tmp_path / "progress.jsonl").write_text(lines[:-20])               # stopped in the middle of the second
    told.clear()
    again = run("a", "b", "c")
    assert bench.asked == ["b", "c"]
    assert told[0] == "1 of 3 things were finished before"
    assert [record["name"] for record in again["things"]] == ["a", "b", "c"]
    run("c", "b")
    assert bench.asked == []
    (tmp_path / "b").unlink()                                           # what was written beside is lost
    run("a", "b")
    assert bench.asked == ["b"]
    run("a", "b", resume=False)
    assert bench.asked == ["a", "b"]
    monkeypatch.setattr(running, "digest", lambda _: "other code")
    run("a", "b")
    assert bench.asked == ["a", "b"]


def test_the_digest_is_of_the_sources_of_a_bench(bench):
    assert running.digest(bench.bench) == running.digest(replace(bench.bench, name="another"))
    assert running.digest(bench.bench) != running.digest(replace(bench.bench, sources=("support/stage.py",)))


def test_processes_do_the_work_of_one():
    assert sorted(running.each_of(abs, [-1, 2, -3], 2)) == [1, 2, 3]


def test_names_choose_things():
    assert [each.name for each in running.named(things("Red paint", "steel"), ["PAINT"])] == ["Red paint"]
    assert len(running.named(things("Red paint", "steel"), ())) == 2


@pytest.mark.parametrize(("own", "rivals", "expected"), [
    (0.3, (0.2, 0.4), 1.5), (0.1, (0.2, None), 0.5), (None, (0.2,), math.inf), (0.0, (0.0,), 1.0),
    (0.1, (0.0,), math.inf), (1.0, (None,), math.nan)])
def test_a_ratio_is_to_the_best_rival_that_did_not_fail(own, rivals, expected):
    rows = {"own": {"rmse": own}, **{str(n): {"rmse": error} for n, error in enumerate(rivals)}}
    assert summary.ratio(rows, "own", ("0", "1"), "rmse") == pytest.approx(expected, nan_ok=True)
    assert math.isnan(summary.ratio(rows, "absent", ("0",), "rmse"))


def test_the_command_writes_a_page_and_the_report_takes_it_over(bench, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(running, "ROOT", tmp_path)
    monkeypatch.setattr(command.os, "cpu_count", lambda: 1)
    found = things("a", "b")
    command.judge(bench.bench, found[:1], ["c: why"], command.parser(bench.bench, "Words.").parse_args(["--jobs", "1"]))
    folder = tmp_path / "build" / "made_up"
    assert (folder / "made_up.md").read_text().startswith("# A title\n\nCommit ")
    assert "left out: c: why" in (said := capsys.readouterr().out)
    assert "\nwell\n" in said
    part = command.supplement(bench.bench, "key", found, [], tmp_path)
    assert bench.asked == ["a"]
    assert part.text.startswith("\n## A title\n\nMade by `make made-up` at commit ")
    assert ", with the code of this report. **1 things are not among them.** Of nothing.\n\n1 things, " in part.text
    monkeypatch.setattr(running, "digest", lambda _: "other code")
    assert "older than the code of this report" in command.supplement(bench.bench, "key", found, [], tmp_path).text
    (folder / "results.json").unlink()
    assert len(command.supplement(bench.bench, "key", found, [], tmp_path).data["things"]) == 2
    with pytest.raises(SystemExit, match="no things of these names"):
        command.judge(bench.bench, [], [], command.parser(bench.bench, "Words.").parse_args([]))
