"""What only a real window does: ``make test-window`` makes one (Debian, as root), and runs this."""

import hashlib
import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import fitter
from fitter.library import ready
from support import ball_files, ball_scene, flat_files, flat_scene
from support.checkout import ROOT

SCRIPTS = ROOT.parent / "shared" / "tools" / "blender_gui"
BLENDER = Path(os.environ.get("MEASURED_BRDF_WINDOW", ROOT / "build" / "window"))
DRIVERS = Path(__file__).parent


def in_window(driver, folder):
    """The lines of words that a driver prints in a Blender with the extension as it is in the checkout, a list each.

    What is in `folder` / "source" before lies there in /share/src.
    """
    if not (SCRIPTS / "shot.sh").is_file() or not (BLENDER / "usr" / "bin" / "blender").is_file():
        pytest.skip(f"no Blender with a window in {BLENDER}: make test-window, or name it in MEASURED_BRDF_WINDOW")
    source, files = folder / "source", ["blender_manifest.toml", "__init__.py", "__main__.py", "LICENSE"]
    source.mkdir(exist_ok=True)
    library = ["starter_library"] if (ROOT / "starter_library").is_dir() else []
    subprocess.run(["cp", "-r", *files, *library, "addon", "fitter", "osl", source], cwd=ROOT, check=True)
    done = subprocess.run(["bash", SCRIPTS / "shot.sh", BLENDER, source, DRIVERS / driver, folder / "window.png"],
                          capture_output=True, text=True, check=False, env=os.environ | {"SHOT_TIMEOUT": "500"})
    assert done.returncode == 0, done.stdout + done.stderr
    return [line.split("|") for line in done.stdout.splitlines() if "|" in line]


def test_what_a_mix_of_the_dialog_follows_is_saved(tmp_path):
    found = {word: {*rest} for word, *rest in in_window("mix_driver.py", tmp_path)}
    assert len(found["MADE"]) == 2
    assert found["MADE"] <= found["SAVED"]


def test_photographs_are_measured_by_the_file_browser_and_in_the_background(openimageio, tmp_path):
    scenes = ball_scene.scenes((30, 75, 120), size=(80, 80))
    ball_files.write(tmp_path / "source" / "ball", ball_scene.satin(), scenes)
    found = {word: rest for word, *rest in in_window("photographs_driver.py", tmp_path)}
    assert found["OPENED"] == ["3", "CAMERA"]
    assert [*map(float, found["OUTLINE"])] == pytest.approx([0, 0, 0], abs=0.003)
    assert found["MEASURED"] == ["True"]
    assert float(found["COMPARED"][0]) < 0.03
    assert found["UNDONE"] == ["0", "True"]


def test_a_flat_sample_whose_corners_are_clicked_is_measured_and_escape_leaves_nothing(openimageio, glossy, tmp_path):
    folder = tmp_path / "source" / "flat"
    fits = [fitter.fit(replace(glossy, values=glossy.values * share), **fitter.PRESETS["Draft"]) for share in (0.3, 1)]
    sample = flat_scene.Sample(tuple(fits), flat_scene.smooth_weights(2), flat_scene.bumps)
    places, wrong = (f"corners = {[[round(float(x) + off, 3) for x in place] for place in flat_files.corners()]}"
                     for off in (0, 3))
    path = flat_files.write(folder, sample, flat_scene.lamps(8), top="texels = 40\nmaterials = ['a.npz', 'b.npz']")
    for fit, name in zip(fits, "ab", strict=True):
        fit.save(folder / f"{name}.npz")
    assert places in path.read_text()
    path.write_text(path.read_text().replace(places, wrong))
    (folder / "corners.json").write_text(json.dumps(flat_files.corners().tolist()))
    found = {word: rest for word, *rest in in_window("flat_driver.py", tmp_path)}
    assert found["DRAWN"] == ["4"]
    assert found["WORKS"] == ["True"]
    assert found["ESCAPED"] == ["True", *found["BEFORE"]]
    assert found["MADE"] == ["0.1000", "0.0800", "0.0000", "flat sample (synthetic)", "3"]


def test_an_asset_that_is_dropped_is_the_material_of_the_library(tmp_path):
    """Appended, as the extension adds its library, and packed, as Blender imports by default; and so is a click's."""
    found = ready.find("alumina-oxide").fit
    expected = hashlib.sha256(replace(found, name="", source="").to_bytes()).hexdigest()
    lines = in_window("drop_driver.py", tmp_path)
    assert ["LIBRARY", "APPEND"] in lines
    for method, is_linked in (("APPEND", "False"), ("PACK", "True")):
        assert ["DROPPED", method, "Alumina", is_linked, "True", "NODES", expected] in lines
    clicked = next(line for line in lines if line[0] == "CLICKED")
    assert clicked[2] == expected
    assert float(clicked[1]) < 3            # s, of a software renderer beside other work; a fit takes ten
