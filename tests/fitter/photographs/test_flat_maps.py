"""Maps of a flat sample as files: the command line."""

import os
import subprocess
import sys

import numpy as np
import pytest

import fitter
from fitter import cli
from fitter.formats import saved_samples
from fitter.imaging.picture_files import read_picture
from fitter.photographs.flat import map_files
from support import anisotropic as instruments
from support import flat_files, flat_scene
from support.checkout import ROOT


@pytest.fixture(scope="module")
def sample(cornell):
    fits = tuple(fitter.fit(cornell(name), **fitter.PRESETS["Draft"]) for name in ("garnet_red_RGB", "krylon_blue_RGB"))
    return flat_scene.Sample(fits, flat_scene.smooth_weights(2), flat_scene.bumps)


def test_the_command_line_writes_masks_and_normals_that_are_the_truth(openimageio, sample, tmp_path, capsys):
    top = "texels = 20\nmaterials = ['first.npz', 'second.npz']"
    path = flat_files.write(tmp_path, sample, flat_scene.lamps(10), top=top)
    for fit, name in zip(sample.fits, ("first.npz", "second.npz"), strict=True):
        fit.save(tmp_path / name)
    environment = os.environ | {"PYTHONPATH": str(openimageio)}

    done = subprocess.run([sys.executable, "-m", "fitter", "flat", str(path), "-o", str(tmp_path / "maps")], cwd=ROOT,
                          env=environment, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr

    def run(file, out, *more):
        return cli.main(["flat", str(file), "-o", str(out), *more]), capsys.readouterr().err
    report = (tmp_path / "maps" / "report.txt").read_text("utf-8")
    assert "20 x 16 texels of 2 materials, 10 photographs" in report
    missed = float(report.partition("is predicted within ")[2].partition("%")[0])
    assert 0.1 < missed < 5         # the noise is 1 %
    most = float(report.partition("a weight of ")[2].split()[0])
    u, v = flat_scene.texels((16, 20))
    for number in (0, 1):
        mask = read_picture(tmp_path / "maps" / f"mask-{number + 1}.png", "linear").pixels[::-1, :, 0] * most
        assert np.abs(mask.ravel() - sample.weights(u, v)[:, number]).mean() < 0.03
        saved = fitter.Fit.load(tmp_path / "maps" / f"material-{number + 1}.npz")
        np.testing.assert_allclose(saved.evaluate(0.3, 0, 0.5, 2), sample.fits[number].evaluate(0.3, 0, 0.5, 2))
        assert saved.source == ["garnet_red_RGB.astm", "krylon_blue_RGB.astm"][number], "without its folder"
    assert read_picture(tmp_path / "maps" / "mask-1.png", "linear").linear()[1] == pytest.approx(1 / 65535)
    normal = read_picture(tmp_path / "maps" / "normal.png", "linear")
    assert normal.linear()[1] == pytest.approx(1 / 65535)
    found = (normal.pixels[::-1] * 2 - 1).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-4)
    cosine = (found * sample.normals(u, v)).sum(axis=1)
    assert np.degrees(np.median(np.arccos(np.clip(cosine, -1, 1)))) < 1
    # half of it or more, and it says how large it is
    assert run(path, tmp_path / "tile", "--tile")[0] == 0
    height, width = read_picture(tmp_path / "tile" / "normal.png").pixels.shape[:2]
    assert (8 <= height < 16, 10 <= width < 20) == (True, True)
    assert (f"The tile has {width} x {height} texels and is {0.1 * width / 20:.4g} x {0.08 * height / 16:.4g} m large"
            in (tmp_path / "tile" / "report.txt").read_text("utf-8"))
    # what fails writes nothing
    before = {each.name: each.stat().st_mtime_ns for each in (tmp_path / "maps").iterdir()}
    bad = tmp_path / "bad.toml"
    bad.write_text(path.read_text("utf-8").replace("second.npz", "third.npz"), "utf-8")
    code, said = run(bad, tmp_path / "maps")
    assert code == 1
    assert "third.npz" in said
    one = tmp_path / "one.toml"
    one.write_text(path.read_text("utf-8").partition("[[photograph]]\nfiles = ['lamp2")[0], "utf-8")
    assert "1 photograph found, expected two or more" in run(one, tmp_path / "none")[1]
    assert {each.name: each.stat().st_mtime_ns for each in (tmp_path / "maps").iterdir()} == before
    assert not (tmp_path / "none").exists()
    # of fewer materials there are fewer files than before
    alone = tmp_path / "alone.toml"
    text = path.read_text("utf-8").replace(", 'second.npz'", "")
    alone.write_text(text.replace("texels = 20", "texels = 6"), "utf-8")
    assert run(alone, tmp_path / "maps")[0] == cli.BAD      # one material does not tell of two
    assert sorted(each.name for each in (tmp_path / "maps").iterdir()) == [
        ".measured_brdf", "mask-1.png", "material-1.npz", "normal.png", "report.txt"]


@pytest.mark.parametrize("said", ["brushed: anisotropic, expected materials that are isotropic",
                                  "5 materials found, expected 1 to 4"])
def test_materials_that_cannot_be_mixed_are_refused_before_any_is_fitted(openimageio, glossy, tmp_path, monkeypatch,
                                                                         capsys, said):
    even = fitter.Samples(*glossy.directions, np.full_like(glossy.values, 0.1), glossy.channels)
    paper = flat_scene.Sample((fitter.fit(even, **fitter.PRESETS["Draft"]),), lambda u, v: np.ones((len(u), 1)),
                              lambda u, v: np.zeros((len(u), 2)))
    directions = instruments.grid([20, 50], range(0, 91, 15), range(10, 81, 10), range(0, 360, 30))
    brushed = fitter.Samples(*directions, instruments.ggx()(*directions), ("R", "G", "B"), "brushed", isotropic=False)
    names = ["white.npz"] * 5 if said.startswith("5") else ["white.npz", "brushed.npz"]
    path = flat_files.write(tmp_path, paper, flat_scene.lamps(2), top=f"materials = {names}")
    for samples, name in ((even, "white.npz"), (brushed, "brushed.npz")):
        saved_samples.write(samples, tmp_path / name)
    monkeypatch.setattr(cli, "fit_samples", lambda *_, **__: pytest.fail("fitted"))
    assert cli.main(["flat", str(path), "-o", str(tmp_path / "maps")]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "maps").exists()


def test_a_glint_does_not_darken_the_masks(random):
    """Of 4,096 texels the 4 brightest are white."""
    weights = random.uniform(0.2, 1, (64, 64, 2))
    weights[7, 9] = 50.0, 30.0
    _, brightness, most = map_files.layers(weights)
    assert most == np.sort(weights.sum(axis=2).ravel())[-5]
    assert (brightness.max(), np.median(brightness) > 0.5) == (1, True)
    assert map_files.white(np.zeros((3, 3))) == 1


@pytest.mark.parametrize("count", [1, 2, 4])
def test_layers_upon_one_another_have_the_weights(random, count):
    weights = random.uniform(0, 1.5, (5, 4, count)) * (random.uniform(size=(5, 4, 1)) > 0.2)
    masks, brightness, most = map_files.layers(weights)
    assert min(masks.min(initial=0), brightness.min()) >= 0
    assert max(masks.max(initial=0), brightness.max()) <= 1
    shown = np.zeros((5, 4, count))
    shown[..., 0] = 1
    for number in range(1, count):
        share = masks[..., number - 1]
        shown *= (1 - share)[..., None]
        shown[..., number] = share
    np.testing.assert_allclose(shown * (brightness * most)[..., None], weights[::-1], atol=1e-12)
