"""Photographs from files, by a description in TOML and the command line."""

import os
import subprocess
import sys

import numpy as np
import pytest

import fitter
from fitter.photographs.picture_files import read_picture
from fitter.photographs.setup import measure
from support import ball_files, ball_scene
from support.checkout import ROOT

SIZE = {"size": (80, 80)}


@pytest.fixture(scope="module")
def scenes():
    return ball_scene.scenes((30, 75, 120), **SIZE)


@pytest.fixture(scope="module")
def written(openimageio, scenes, tmp_path_factory):
    return ball_files.write(tmp_path_factory.mktemp("ball"), ball_scene.satin(), scenes)


def off(samples, model):
    return np.median(np.abs(samples.values / model.evaluate(*samples.directions) - 1))


def test_photographs_of_files_measure_the_material(written):
    """The ball by its outline, the scale by a card."""
    samples = measure(written)
    assert samples.name == "painted ball (synthetic)"
    assert off(samples, ball_scene.satin()) < 0.02
    assert any(note.startswith("The ball's centre by its outline: ") for note in samples.notes)
    assert "Scale and colour by a card of known albedo" in samples.notes


def test_the_command_line_writes_samples_that_load_reads_and_fits(openimageio, written, tmp_path):
    environment = os.environ | {"PYTHONPATH": str(openimageio)}

    def run(*arguments):
        return subprocess.run([sys.executable, "-m", "fitter", *map(str, arguments)], cwd=ROOT, env=environment,
                              capture_output=True, text=True, check=False, timeout=120)

    done = run("photographs", written, "-o", tmp_path / "ball.npz")
    assert done.returncode == 0, done.stderr
    assert "Put the next lamp at" in done.stdout
    loaded, measured = fitter.load(tmp_path / "ball.npz"), measure(written)
    assert (loaded.name, loaded.channels, loaded.isotropic) == (measured.name, measured.channels, True)
    for field in ("theta_i", "theta_o", "phi_o", "values", "deviation"):
        np.testing.assert_allclose(getattr(loaded, field), getattr(measured, field), rtol=1e-6, atol=1e-7)
    assert set(measured.notes) <= set(loaded.notes)
    assert "direction pairs" in run("info", tmp_path / "ball.npz").stdout
    missing = run("photographs", tmp_path / "none.toml", "-o", tmp_path / "none.npz")
    assert missing.returncode == 1
    assert "none.toml: cannot be read" in missing.stderr
    assert not (tmp_path / "none.npz").exists()


def test_without_openimageio_the_message_says_what_to_do(written, tmp_path):
    code = ("import sys; sys.modules['OpenImageIO'] = None\nfrom fitter.cli import main\n"
            f"sys.exit(main(['photographs', {str(written)!r}, '-o', {str(tmp_path / 'ball.npz')!r}]))")
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "needs OpenImageIO" in done.stderr


def test_exposures_a_dark_room_a_flat_field_a_matrix_and_a_white_ball(openimageio, scenes, tmp_path):
    """All at once: what the camera saw is worked out backwards."""
    model, matrix = ball_scene.satin(), np.array([[0.9, 0.1, 0.0], [0.05, 0.9, 0.05], [0.0, 0.2, 0.8]])
    white = ball_scene.truths.Truth("", "", lambda *angles: np.full((len(angles[0]), 3), 0.9 / np.pi))
    y, x = np.mgrid[-1:1:80j, -1:1:80j]
    falls = (1 / (1 + 0.2 * (x ** 2 + y ** 2)))[..., None]

    def camera(radiance, path, seconds):
        seen = (radiance @ np.linalg.inv(matrix).T + 0.01) * falls * seconds
        ball_files.write_picture(tmp_path / path, np.clip(seen, 0, 1), ExposureTime=seconds, FNumber=1.0)

    files = []
    for number, scene in enumerate(scenes):
        picture = ball_scene.photograph(model, scene)
        files.append([f"{number}_{seconds}.tif" for seconds in (0.125, 1.0, 4.0)])
        for name, seconds in zip(files[-1], (0.125, 1.0, 4.0), strict=True):
            camera(picture, name, seconds)
    camera(ball_scene.photograph(white, scenes[1]), "white.tif", 0.5)
    camera(np.zeros((80, 80, 3)), "dark.tif", 2.0)
    ball_files.write_picture(tmp_path / "flat.exr", 0.5 * falls * np.ones(3), ExposureTime=1.0)
    text = ball_files.description(
        scenes, files, f'ball = {{file = "white.tif", albedo = 0.9, lamp = {list(map(float, scenes[1].lamp))}}}',
        centre=scenes[0].centre, more='dark = "dark.tif"\nflat = "flat.exr"')
    (tmp_path / "setup.toml").write_text(text.replace("[ball]\n", f"matrix = {matrix.tolist()}\n\n[ball]\n", 1))
    assert off(measure(tmp_path / "setup.toml"), model) < 0.01


def test_what_a_file_says_of_the_camera_is_read(openimageio, tmp_path):
    random = np.random.default_rng(0)
    pixels = random.random((4, 6, 3))
    wide = [0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290]
    ball_files.write_picture(tmp_path / "a.exr", pixels, ExposureTime=0.5, FNumber=2.0,
                             Exif__PhotographicSensitivity=200)
    picture = read_picture(tmp_path / "a.exr")
    np.testing.assert_allclose(picture.pixels, pixels, atol=1e-3)
    assert picture.exposure == pytest.approx(0.25)
    assert picture.matrix is None or np.allclose(picture.matrix, np.eye(3), atol=1e-3)
    import OpenImageIO

    file = OpenImageIO.ImageBuf(pixels.astype(np.float32))
    file.specmod().attribute("chromaticities", "float[8]", tuple(wide))
    assert file.write(str(tmp_path / "wide.exr"))
    np.testing.assert_allclose(read_picture(tmp_path / "wide.exr").matrix,
                               fitter.colours.conversion("Rec.2020", "Rec.709"), atol=1e-3)
    ball_files.write_picture(tmp_path / "b.png", np.full((4, 6, 3), 0.5))
    picture = read_picture(tmp_path / "b.png")
    np.testing.assert_allclose(picture.pixels, 0.2140, atol=0.004)
    assert "was made linear" in picture.notes[0]
    assert "8 bits: its steps are 1.9%" in picture.notes[1]
    assert read_picture(tmp_path / "b.png", "linear").pixels[0, 0, 0] == pytest.approx(0.5, abs=0.003)


@pytest.mark.parametrize(("old", "new", "message"), [
    ("radius = 0.05", "radius = -1", r"setup.toml: ball.radius is -1, expected a number above 0"),
    ("radius = 0.05\n", "", "ball.radius is missing"),
    ("position = ", "place = ", "camera.place is not known, expected one of position"),
    ("field_of_view = 4.2\n", "", "camera.field_of_view is missing"),
    ("[scale]", "[scale]\nalbedo = 0.5", "scale has albedo, card, expected one of"),
    ("lamp1.exr", "lamp7.exr", "lamp7.exr: cannot be read: no such file"),
    ("files = [\"lamp2.exr\"]", "files = []", "photograph 2.files is \\[\\], expected the name of a file"),
    ("files = [\"lamp2.exr\"]", "files = [\"lamp2.exr\", \"lamp1.exr\"]", "photograph 2.exposures is missing"),
    ("lamp = [", "lamb = [", "lamb is not known"),
    ("name = ", "name : ", "not TOML"),
    ("centre = \"outline\"", "centre = [0, 0]", "ball.centre is \\[0, 0\\], expected 3 numbers"),
    ("albedo = 0.18", "albedo = 18", "card.exr: an albedo of"),
    ("region = [", "region = [900, ", "scale.card.region is"),
    ("centre = \"outline\"", "centre = [0.5, 0, 0]", "no pixel sees the ball|not where it is said to be"),
], ids=str)
def test_what_is_wrong_is_named_by_file_and_key(written, tmp_path, old, new, message):
    text = written.read_text()
    assert old in text
    for picture in written.parent.glob("*.exr"):
        os.link(picture, tmp_path / picture.name)
    (tmp_path / "setup.toml").write_text(text.replace(old, new))
    with pytest.raises(fitter.DatasetError, match=message):
        measure(tmp_path / "setup.toml")
