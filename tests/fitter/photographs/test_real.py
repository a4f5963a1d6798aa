"""Real photographs: a gray ball before a dim room, on a lamp's foot, and a chrome ball of another size."""

from dataclasses import replace

import numpy as np
import pytest

import fitter
from fitter.photographs.ball import measuring
from fitter.photographs.ball.measuring import place_photographs
from fitter.photographs.description import parsing
from fitter.photographs.description.parsing import parse
from support.checkout import measurements

FOLDER = measurements() / "photographs" / "gray_ball"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"{FOLDER} is not there")
FEW = 0, 6, 10              # lamps 43, 30 and 8 degrees from the camera


@pytest.fixture
def described(openimageio):
    """The description of three photographs: places are those of the pictures."""
    shots = [{"files": [str(FOLDER / f"gray.{k}.png")], "chrome": str(FOLDER / f"chrome.{k}.png")} for k in FEW]
    return {"name": "gray ball", "camera": {"position": "far", "encoding": "linear"}, "ball": {"centre": "outline"},
            "chrome": {"mask": str(FOLDER / "chrome.mask.png")}, "scale": {"albedo": 0.5}, "photograph": shots}


def of_mask(name):
    """The middle and the radius of a mask's disc, pixels from the left and the top, by its area and its mean."""
    import OpenImageIO

    mask = np.asarray(OpenImageIO.ImageBuf(str(FOLDER / name)).get_pixels(OpenImageIO.FLOAT))[..., 0] > 0.5
    rows, columns = np.nonzero(mask)
    return columns.mean() + 0.5, rows.mean() + 0.5, np.sqrt(mask.sum() / np.pi)


def in_picture(shot):
    """The same of the ball of a photograph, whose camera is far and looks along -z."""
    axis, _, limb = shot.sight
    height, width = shot.radiance.shape[:2]
    pixel = 2 * np.tan(np.radians(0.5)) / width
    return width / 2 - axis[0] / axis[2] / pixel, height / 2 + axis[1] / axis[2] / pixel, np.tan(limb) / pixel


@pytest.mark.parametrize("mask", [None, "gray.mask.png"])
def test_a_real_ball_is_found_before_its_room_and_on_its_stand(described, mask):
    """With a mask of the ball, and without."""
    if mask is not None:
        described["ball"]["mask"] = str(FOLDER / mask)
    shot = place_photographs(measuring.read_photographs(parse(described, FOLDER / "none.toml"))[0], "gray ball")[0]
    assert in_picture(shot) == pytest.approx(of_mask("gray.mask.png"), abs=1.0)


def test_the_lamps_of_real_photographs_are_where_the_chrome_ball_says(described):
    """By the brightest pixels and the disc of its mask: for a camera far away the normal is the place on the disc."""
    import OpenImageIO

    column, row, radius = of_mask("chrome.mask.png")
    for shot, k in zip(measuring.read_photographs(parse(described, FOLDER / "none.toml"))[0], FEW, strict=True):
        picture = np.asarray(OpenImageIO.ImageBuf(str(FOLDER / f"chrome.{k}.png")).get_pixels(OpenImageIO.FLOAT))
        rows, columns = np.nonzero(picture.mean(axis=2) > 0.9)
        normal = np.array([columns.mean() + 0.5 - column, row - rows.mean() - 0.5, 0.0]) / radius
        normal[2] = np.sqrt(1 - normal @ normal)
        away = 2 * normal[2] * normal - (0, 0, 1)
        assert np.degrees(np.arccos(away @ shot.lamp / np.linalg.norm(shot.lamp))) < 1.0


def test_one_note_for_all_files(described):
    del described["camera"]["encoding"]
    notes = measuring.measure_ball(parse(described, FOLDER / "none.toml")).samples.notes
    for text in ("8 bits", "sRGB, which was made linear"):
        note, = [note for note in notes if text in note]
        assert note.startswith("6 files, gray.0.png to chrome.10.png: ")


def test_a_folder_with_light_positions_is_all_there_is_to_say(described, tmp_path):
    """The lamps are those that the chrome ball shows; the .lp file has them with decimal commas."""
    shots = measuring.read_photographs(parse(described, FOLDER / "none.toml"))[0]
    lines = [str(len(FEW))]
    for shot, k in zip(shots, FEW, strict=True):
        (tmp_path / f"gray.{k}.png").symlink_to(FOLDER / f"gray.{k}.png")
        toward = shot.lamp / np.linalg.norm(shot.lamp)
        lines.append(f"C:\\dome 2\\gray.{k}.png " + " ".join(f"{x:.6f}".replace(".", ",") for x in toward))
    (tmp_path / "dome.lp").write_text("\r\n".join(lines))
    for path in (tmp_path, tmp_path / "dome.lp"):
        found = parsing.read(path)
        found = replace(found, camera=replace(found.camera, encoding="linear"))
        assert found.title == tmp_path.name
        for again, shot in zip(measuring.read_photographs(found)[0], shots, strict=True):
            np.testing.assert_allclose(again.centre - again.camera, shot.centre - shot.camera, rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(again.lamp, shot.lamp, rtol=1e-5, atol=1e-3)
            np.testing.assert_array_equal(again.radiance, shot.radiance)


def test_a_ball_that_is_elsewhere_is_told_in_pixels_and_sectors(described):
    described["camera"] |= {"position": [0, 0, 10], "up": [0, 1, 0], "field_of_view": 1.0}
    described["ball"] = {"centre": [0, 0, 0], "radius": 0.037}
    shots = measuring.read_photographs(parse(described, FOLDER / "none.toml"))[0]
    with pytest.raises(fitter.DatasetError, match=r"gray.0.png: .* of \d+ of its 48 sectors, .* \d+ have their edge "
                                                  r"within 2 pixels, .* \d+\.\d pixels off"):
        fitter.samples_from_ball(shots)
