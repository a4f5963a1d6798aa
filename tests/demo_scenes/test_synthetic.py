import numpy as np
import pytest

import fitter
from support import synthetic


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("synthetic")
    synthetic.write(folder)
    return folder


def test_synthetic_files_are_read_as_the_real_ones_and_say_that_they_are_not(folder):
    paint = fitter.load(folder / "cornell" / "krylon_blue.astm")
    assert "synthetic" in paint.name
    expected = synthetic.BLUE_HOUSE_PAINT.evaluate(*paint.directions)
    np.testing.assert_allclose(paint.values, expected, rtol=2e-4, atol=2e-5)
    foil = fitter.load(folder / "curet" / "abrdf.dat", "aluminum foil")
    expected = synthetic.BLUE_HOUSE_PAINT.evaluate(*foil.directions)[:, [2]]
    np.testing.assert_allclose(foil.values, expected, atol=6e-4)


def test_synthetic_paint_has_cornells_geometry(folder, cornell):
    ours, real = fitter.load(folder / "cornell" / "krylon_blue.astm"), cornell("krylon_blue")
    grids = [{tuple(np.round(row, 3) + 0.0) for row in
              np.column_stack([samples.theta_i, samples.theta_o, np.cos(samples.phi_o)])} for samples in (real, ours)]
    near = [any(np.allclose(row, other, atol=2e-3) for other in grids[1]) for row in list(grids[0])[::10]]
    assert all(near)


def test_the_demo_imports_fits_and_writes_its_figures(extension, folder, tmp_path, monkeypatch):
    """Everything but the rendering, which takes minutes."""
    from demo_scenes import __main__ as demo

    monkeypatch.setattr(demo, "render", lambda scene: np.zeros((8, 8, 4)))
    monkeypatch.setattr(demo, "FIGURE_4", {"felt": 1})
    monkeypatch.setattr(demo.synthetic, "measurements_or_synthetic", lambda: (folder, True))
    made = demo.Demo(demo.Quality(tmp_path, 0.1, 0.1))
    for figure in (demo.figure_3, demo.figure_4, demo.figure_8):
        figure(made)
    assert [levels for _, levels, *_ in made.rows] == [
        *(f"level {level}" for level in range(1, 7)), *["(4,6,95)"] * 4, "(4,6,95)", "(4,5,98.2)", "level 6"]
    assert len(list(tmp_path.glob("*.png"))) == 3


def test_the_title_picture_shows_the_materials_at_hand(extension, folder, tmp_path, monkeypatch):
    import bpy

    from demo_scenes import title

    monkeypatch.setattr(title.synthetic, "measurements_or_synthetic", lambda: (folder, True))
    few = {name: title.MATERIALS[name] for name in ("garnet red", "leather", "velvet")}
    monkeypatch.setattr(title, "MATERIALS", few)
    title.draw(tmp_path / "title.png", width=28, samples=1, preset="Draft")
    assert (tmp_path / "title.png").is_file()
    assert [item.active_material.name for item in bpy.data.objects if item.name.startswith("Suzanne")] == ["leather"]
