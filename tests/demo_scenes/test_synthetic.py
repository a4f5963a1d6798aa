import pickle
import sys

import numpy as np
import pytest

import fitter
from support import synthetic
from support.cases import release


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("synthetic")
    synthetic.write(folder)
    return folder


def test_synthetic_files_are_read_as_the_real_ones_and_say_that_they_are_not(folder):
    paint = fitter.load(folder / "cornell" / "krylon_blue.astm")
    assert "synthetic" in paint.name
    expected = synthetic.blue_house_paint(*paint.directions)
    np.testing.assert_allclose(paint.values, expected, rtol=2e-4, atol=2e-5)
    foil = fitter.load(folder / "curet" / "abrdf.dat", "aluminum foil")
    expected = synthetic.blue_house_paint(*foil.directions)[:, [2]]
    np.testing.assert_allclose(foil.values, expected, atol=6e-4)


def test_synthetic_paint_has_cornells_geometry(folder, cornell):
    ours, real = fitter.load(folder / "cornell" / "krylon_blue.astm"), cornell("krylon_blue")
    grids = [{tuple(np.round(row, 3) + 0.0) for row in
              np.column_stack([samples.theta_i, samples.theta_o, np.cos(samples.phi_o)])} for samples in (real, ours)]
    rows, others = (np.array(sorted(grid)) for grid in grids)
    assert (np.abs(rows[::10, None] - others).max(axis=-1).min(axis=-1) < 2e-3).all()


def test_the_demo_imports_fits_and_writes_its_figures(extension, folder, tmp_path, monkeypatch, baked_once):
    """Everything but the rendering and the shaders, which take minutes."""
    from demo_scenes import __main__ as demo

    suns = []

    def render(scene):
        suns.extend(-np.degrees(item.rotation_euler.y) for item in scene.objects if item.name == "Sun")
        return np.zeros((8, 8, 4))

    said = []
    monkeypatch.setattr(demo, "render", render)
    monkeypatch.setattr(demo, "FIGURE_4", {"felt": 1})
    monkeypatch.setattr(demo.synthetic, "measurements_or_synthetic", lambda: (folder, True))
    made = demo.Demo(demo.Quality(tmp_path, 0.1, 0.1), said.append)
    for figure in (demo.figure_3, demo.figure_4, demo.figure_8):
        figure(made)
    assert [levels for _, levels, *_ in made.rows] == [
        *(f"level {level}" for level in range(1, 7)), *["(4,6,95)"] * 4, "(4,6,95)", "(4,5,98.2)", "level 6"]
    np.testing.assert_allclose(suns, [60] * 6 + [0, 30, 60, 90], atol=1e-4)
    assert [line for line in said if "felt" in line] == [
        "fitting felt", "rendering felt, 0°", "rendering felt, 30°", "rendering felt, 60°", "rendering felt, 90°"]
    assert len([line for line in said if line.startswith("rendering")]) == len(made.rows)
    assert {path.name for path in tmp_path.glob("*.png")} == {
        "figure_3_levels.png", "figure_4_materials.png", "figure_8_compression.png"}


def test_the_demo_is_small_and_the_figures_are_as_the_pages_have_them(blender):
    from demo_scenes import __main__ as demo
    from support import stage

    small, full = (quality.of(stage.black_scene(512, 448, samples=192, span=1)) and [
        blender.context.scene.render.resolution_x, blender.context.scene.render.resolution_y,
        blender.context.scene.cycles.samples] for quality in (demo.DEMO, demo.FULL))
    assert small == [256, 224, 24]
    assert full == [512, 448, 192]
    assert demo.DEMO.folder != demo.FULL.folder


def test_a_part_shows_its_own_lines_and_none_of_blenders(tmp_path, monkeypatch, capfd):
    """A script stands in for Python: it gets ``-m NAME --part PART RESULT``."""
    from demo_scenes import __main__ as demo

    result = tmp_path / "result"
    result.write_bytes(pickle.dumps(("a picture", ["a row"])))
    _stand_in(tmp_path, monkeypatch, f"echo Fra:1; echo 'demo: rendering felt'; echo Saved: >&2; cp {result} $5")
    assert demo.draw("figure 4", demo.DEMO) == ("a picture", ["a row"])
    shown = capfd.readouterr()
    assert (shown.out, shown.err) == ("rendering felt\n", "")


def test_a_part_that_fails_says_what_blender_said(tmp_path, monkeypatch):
    from demo_scenes import __main__ as demo

    _stand_in(tmp_path, monkeypatch, "echo 'no such device' >&2; exit 3")
    with pytest.raises(RuntimeError, match="figure 4 failed:\nno such device"):
        demo.draw("figure 4", demo.DEMO)


def _stand_in(folder, monkeypatch, commands):
    script = folder / "stand_in"
    script.write_text(f"#!/bin/sh\n{commands}\n")
    script.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(script))


@release
def test_the_title_picture_shows_the_materials_at_hand(extension, folder, tmp_path, monkeypatch):
    import bpy

    from demo_scenes import title

    monkeypatch.setattr(title.synthetic, "measurements_or_synthetic", lambda: (folder, True))
    monkeypatch.setattr(title, "OUT", tmp_path / "demo" / "title")
    title.draw(tmp_path / "title", width=28, height=12, samples=1, preset="Draft")
    assert {path.name for path in tmp_path.glob("title*")} == {"title.jpg", "title_principled.jpg"}
    fitted = {item.name for item in bpy.data.materials if item.measured_brdf.coefficients}
    assert fitted == {"leather", "Satin aluminium", "Polished gold", "Black obsidian"}
