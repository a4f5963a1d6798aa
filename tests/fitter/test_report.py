"""The report on measurements: its errors, by hand and by other means, and its files."""

import json

import numpy as np
import pytest

import fitter
from fitter import cli, report
from fitter.quality import cross_validation


def test_a_row_has_the_size_and_the_errors_of_a_fit(glossy):
    row, = report.rows(glossy, {"level 4": report.ways([4])["level 4"]})
    fit = fitter.fit(glossy, 4, None)
    values, theta_o = fit.evaluate(*glossy.directions), glossy.theta_o[:, None]
    assert row["bytes"] == fit.nbytes
    assert row["rmse"] == pytest.approx(np.sqrt(((values - glossy.values) ** 2).mean()))
    assert row["mae"] == pytest.approx(np.abs(values - glossy.values).max())
    cubes = np.cbrt(values * np.cos(theta_o)) - np.cbrt(glossy.values * np.cos(theta_o))
    assert row["cube_root_rmse"] == pytest.approx(np.sqrt((cubes ** 2).mean()))
    held_out = cross_validation.cross_validate(glossy, lambda samples: fitter.fit(samples, 4, None))
    assert row["held_out_rmse"] == pytest.approx(held_out.rmse)
    assert row["held_out_cube_root_rmse"] == pytest.approx(held_out.cube_root_rmse)


def test_of_one_sample_none_is_held_out():
    samples = fitter.Samples([0.3], [0], [0.4], [1], [[0.2]], name="a | b")
    found = report.rows(samples, {"level 0": report.ways([0])["level 0"]})
    assert found[0]["held_out_rmse"] is None
    assert report.markdown(found).splitlines()[2].startswith("| a \\| b | level 0 | ")


def test_the_command_writes_a_table_and_its_numbers(glossy, write_astm, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(report, "PRESETS", {"Draft": fitter.PRESETS["Draft"]})
    path = tmp_path / "glossy.astm"
    write_astm(path, glossy)
    assert cli.main(["report", str(path), "--levels", "3", "--out", str(tmp_path / "out")]) == 0
    told = json.loads((tmp_path / "out" / "results.json").read_text())
    assert [row["fit"] for row in told] == ["Draft", "level 3"]
    assert (tmp_path / "out" / "results.md").read_text() == capsys.readouterr().out == report.markdown(told)


def test_a_bad_file_leaves_no_report(tmp_path, capsys):
    (tmp_path / "bad.dat").write_text("nonsense")
    assert cli.main(["report", str(tmp_path / "bad.dat"), "--out", str(tmp_path / "out")]) == 1
    assert "in no known format" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
