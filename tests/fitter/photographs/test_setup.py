"""Photographs from files, by a description in TOML and the command line."""

import dataclasses
import os
import subprocess
import sys
import tomllib

import numpy as np
import pytest

import fitter
from fitter import cli
from fitter.imaging import picture_files
from fitter.imaging.picture_files import read_picture
from fitter.photographs.ball import measuring
from fitter.photographs.capture import resolve
from fitter.photographs.description import parsing
from support import ball_files, ball_scene, wrong_values
from support.checkout import ROOT

SIZE = {"size": (80, 80)}


def measure(path):
    """The samples of a description, light positions, or a folder with either."""
    return measuring.measure_ball(parsing.read(path)).samples


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


@pytest.fixture
def short_command(monkeypatch):
    """The command neither judges photographs nor advises, which takes fits."""
    monkeypatch.setattr(cli, "report_ball", lambda measured: (measured.samples.notes, measured.doubts))


@pytest.mark.usefixtures("short_command")
def test_a_line_break_in_a_description_begins_no_line(written, tmp_path, capsys):
    broken = written.with_name("broken.toml")
    broken.write_text(written.read_text().replace("painted ball", "painted\\nerror: none"))
    assert cli.main(["photographs", str(broken), "-o", str(tmp_path / "ball.npz")]) == 0
    assert capsys.readouterr().out.splitlines()[0] == rb"painted\nerror: none (synthetic)".decode()


def test_the_command_line_writes_samples_that_load_reads_and_fits(openimageio, scenes, tmp_path):
    written = ball_files.write(tmp_path, ball_scene.satin(), scenes[:1])
    written.write_text(written.read_text("utf-8").replace('"outline"', str(list(scenes[0].centre))), "utf-8")
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
    assert "8 bits a channel, whose steps are 1.9%" in picture.notes[1]
    assert read_picture(tmp_path / "b.png", "linear").pixels[0, 0, 0] == pytest.approx(0.5, abs=0.003)


@pytest.mark.parametrize(("name", "said", "is_bent"), [
    ("a.png", "sRGB", True), ("a.tif", "sRGB", True), ("a.png", "lin_rec709", False), ("a.tif", "", False),
    ("a.exr", "", False), ("a.png", "g22_rec709", True)])
@pytest.mark.parametrize("depth", ["uint8", "uint16", "float"])
def test_values_are_what_the_file_says_whatever_its_depth(openimageio, tmp_path, name, said, is_bent, depth):
    """Against the formula of IEC 61966-2-1. TIFF of 8 bits that says nothing is sRGB; PNG and EXR have some depths."""
    depth = "half" if name == "a.exr" else "uint16" if name == "a.png" and depth == "float" else depth
    attributes = {"oiio:ColorSpace": said} if said else {}
    ball_files.write_picture(tmp_path / name, np.full((4, 6, 3), 0.5), depth, **attributes)
    picture = read_picture(tmp_path / name)
    is_bent |= (name, said, depth) == ("a.tif", "", "uint8")
    expected = ((0.5 + 0.055) / 1.055) ** 2.4 if is_bent else 0.5
    assert picture.pixels == pytest.approx(expected, abs=0.004)
    assert any("made linear" in note for note in picture.notes) == is_bent
    assert read_picture(tmp_path / name, "linear").pixels == pytest.approx(0.5, abs=0.004)


@pytest.mark.parametrize(("place", "whole", "expected"), [
    ((2, 1, 4, 3), (0, 0, 8, 6), (slice(1, 4), slice(2, 6))),
    ((-2, -1, 4, 3), (0, 0, 8, 6), (slice(0, 2), slice(0, 2))),
    ((12, 11, 4, 3), (10, 10, 8, 6), (slice(1, 4), slice(2, 6))), ((0, 0, 4, 3), (9, 0, 4, 3), None)],
    ids=["crop", "overscan", "window elsewhere", "beside"])
def test_the_pixels_of_an_exr_are_in_their_place_of_its_display_window(openimageio, tmp_path, place, whole, expected):
    import OpenImageIO

    path, random = tmp_path / "a.exr", np.random.default_rng(0)
    pixels = random.random((place[3], place[2], 3)).astype(np.float32)
    file = OpenImageIO.ImageBuf(pixels)
    spec = file.specmod()
    spec.x, spec.y, spec.width, spec.height = place
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = whole
    file = OpenImageIO.ImageBuf(spec)
    file.set_pixels(OpenImageIO.ROI(place[0], place[0] + place[2], place[1], place[1] + place[3]), pixels)
    assert file.write(str(path))
    if expected is None:
        with pytest.raises(fitter.DatasetError, match=r"a\.exr: none of its pixels is in its display window"):
            read_picture(path)
        return
    found = read_picture(path)
    inside = np.zeros((6, 8, 3))
    rows, columns = expected
    inside[rows, columns] = pixels[-(rows.stop - rows.start):, -(columns.stop - columns.start):]
    np.testing.assert_allclose(found.pixels, inside, atol=1e-6)
    assert picture_files.read_picture_info(path).size == (6, 8)
    assert [note for note in found.notes if "4 x 3 beside a display window of 8 x 6" in note]


@pytest.mark.parametrize(("names", "read", "said"), [
    ("diffuse.R diffuse.G diffuse.B R G B", (3, 4, 5), "the layer without a name is read, of -, diffuse"),
    ("a.Normal.R a.Normal.G a.Normal.B a.Combined.R a.Combined.G a.Combined.B", (3, 4, 5),
     "the layer a.combined is read, of a.combined, a.normal"),
    ("left.R left.G left.B depth.Z right.Y", (0, 1, 2), ""),
    ("a.R b.R b.G b.B a.G a.B", (0, 4, 5), "the layer a is read")])
def test_of_several_layers_one_is_read_whole_and_told(openimageio, tmp_path, names, read, said):
    """OpenImageIO sorts the channels of an EXR file, so each has a value of its own."""
    import OpenImageIO

    names = names.split()
    pixels = np.broadcast_to(np.arange(1, len(names) + 1, dtype=np.float32), (2, 2, len(names)))
    file = OpenImageIO.ImageBuf(np.ascontiguousarray(pixels))
    file.specmod().channelnames = names
    assert file.write(str(tmp_path / "a.exr"))
    found = read_picture(tmp_path / "a.exr")
    assert found.pixels[0, 0].tolist() == [each + 1 for each in read]
    notes = [note for note in found.notes if "the layer" in note]
    assert (bool(notes), said in "".join(notes)) == (bool(said), True)


@pytest.mark.usefixtures("short_command")
def test_that_a_file_has_further_parts_and_is_to_be_turned_is_told(openimageio, scenes, tmp_path, capsys):
    """By the command: pixels are where the sensor has them."""
    import OpenImageIO

    written = ball_files.write(tmp_path, ball_scene.satin(), scenes)
    first = OpenImageIO.ImageBuf(str(tmp_path / "lamp1.exr")).get_pixels("float")
    spec, second = (OpenImageIO.ImageSpec(80, 80, 3, "float") for _ in range(2))
    spec.attribute("Orientation", 6)
    for number, each in enumerate((spec, second)):
        each.attribute("oiio:subimagename", str(number))
    file = OpenImageIO.ImageOutput.create(str(tmp_path / "lamp1.exr"))
    assert file.open(str(tmp_path / "lamp1.exr"), (spec, second))
    assert file.write_image(first)
    assert file.open(str(tmp_path / "lamp1.exr"), second, "AppendSubimage")
    assert file.write_image(np.ones((80, 80, 3), np.float32))
    file.close()
    assert cli.main(["photographs", str(written), "-o", str(tmp_path / "ball.npz")]) == 0
    said = capsys.readouterr().out
    assert "lamp1.exr: the first of several parts is read" in said
    assert "lamp1.exr: EXIF says that viewers show it turned by 90 degrees clockwise. It is read as the sensor" in said
    assert off(fitter.load(tmp_path / "ball.npz"), ball_scene.satin()) < 0.02
    written.write_text(written.read_text().replace("[ball]\n", "[ball]\nmask = 'mask.png'\n"))
    ball_files.write_picture(tmp_path / "mask.png", np.ones((80, 80, 3)), Orientation=3)
    assert cli.main(["photographs", str(written), "-o", str(tmp_path / "ball.npz")]) == 1
    assert "mask.png: EXIF says that viewers show this mask turned" in capsys.readouterr().err


@pytest.mark.parametrize(("old", "new", "message"), [
    ("radius = 0.05", "radius = -1", r"setup.toml: ball.radius is -1, expected a number of 1e-09 to 1e\+09"),
    ("radius = 0.05\n", "", "ball.radius is missing"),
    ("position = ", "place = ", "camera.place is not known, expected one of position"),
    ("field_of_view = 4.2\n", "", "camera.field_of_view is missing"),
    ("[scale]", "[scale]\nalbedo = 0.5", "scale has albedo, card, expected one of"),
    ("lamp1.exr", "lamp7.exr", "lamp7.exr: cannot be read: no such file"),
    ("files = [\"lamp2.exr\"]", "files = []", "photograph 2.files is \\[\\], expected the name of a file"),
    ("files = [\"lamp2.exr\"]", "files = [\"lamp2.exr\", \"lamp1.exr\"]", "photograph 2.exposures is missing"),
    ("lamp = [", "lamb = [", "lamb is not known"),
    ("radius = 0.05", f"radius = {2 ** 64}", "ball.radius is 18446744073709551616, expected a number"),
    ("radius = 0.05", "radius = 1" + 4000 * "0", "ball.radius is 10"),
    ("files = [\"lamp2.exr\"]", "files = [\"lamp2.exr\"]\nexposures = [1e308]",
     r"exposures is \[1e\+308\], expected numbers"),
    ("files = [\"lamp2.exr\"]", "files = [\"lamp2.exr\"]\nexposures = [1e-308]", "exposures is .*expected numbers of"),
    ("name = ", "x = " + 2000 * "[" + 2000 * "]" + "\nname = ", "toml: (not TOML|tables within tables)"),
    ("name = ", "".join(f"[{'.'.join(20 * 'a')}.b{k}]\n" for k in range(9)) + "name = ", "tables within tables"),
    ("name = ", ".".join(200_000 * "a") + " = 1\nname = ", "setup.toml:1: 400,003 bytes in a line"),
    ("name = ", "name : ", "not TOML"),
    ("centre = \"outline\"", "centre = [0, 0]", "ball.centre is \\[0, 0\\], expected 3 numbers"),
    ("albedo = 0.18", "albedo = 18", "setup.toml: scale.card.albedo is 18, expected more than 0 and at most 1"),
    ("region = [", "region = [900, ", "scale.card.region is"),
    ("centre = \"outline\"", "centre = [0.5, 0, 0]", "no pixel sees the ball|not where it is said to be"),
    ("files = [\"lamp1.exr\"]", "files = [\"lamp1.exr\", \"small.exr\"]\nexposures = [1, 2]",
     r"lamp1.exr: exposures of several sizes found: \(4, 6, 3\), \(80, 80, 3\)"),
    ("[lamp]\n", "[lamp]\ndark = \"small.exr\"\n",
     r"lamp1.exr: the photograph with the lamp off has the size \(4, 6, 3\), expected \(80, 80, 3\)"),
    ("[lamp]\n", "[lamp]\nflat = \"small.exr\"\n", "lamp1.exr: the photograph of an even surface has the size"),
], ids=str)
def test_what_is_wrong_is_named_by_file_and_key(written, tmp_path, old, new, message):
    text = written.read_text()
    assert old in text
    for picture in written.parent.glob("*.exr"):
        os.link(picture, tmp_path / picture.name)
    ball_files.write_picture(tmp_path / "small.exr", np.ones((4, 6, 3)))
    (tmp_path / "setup.toml").write_text(text.replace(old, new))
    with pytest.raises(fitter.DatasetError, match=message):
        measure(tmp_path / "setup.toml")


def test_all_that_is_wrong_is_said_at_once(tmp_path):
    (tmp_path / "setup.toml").write_text(
        "pencil = 1\n[camera]\nposition = [0, 1]\n[ball]\nradius = -1\n[scale]\nalbedo = 1.01\n[[photograph]]\n"
        "files = 'a.exr'\nlamp = [0, 1, 2]\n[[photograph]]\nfiles = 'b.exr'\nexposures = [1, 2]\n"
        "lamp = [0, 0, 1]\n")
    with pytest.raises(fitter.DatasetError) as error:
        measure(tmp_path)
    assert str(error.value).count("setup.toml: ") == 1
    for line in ("pencil is not known", "camera.position is [0, 1], expected 3 numbers", "ball.radius is -1",
                 "scale.albedo is 1.01, expected more than 0 and at most 1",
                 "photograph 2.exposures is [1.0, 2.0], expected 1 numbers"):
        assert line in str(error.value)


def test_a_description_of_the_other_surface_is_refused(tmp_path):
    rest = ("[camera]\nposition = 'far'\n[scale]\nalbedo = 0.5\n[[photograph]]\nfiles = 'a.exr'\n"
            "direction = [0, 0, 1]\n")
    ball, sample = "[ball]\ncentre = 'outline'\n", "[sample]\nwidth = 1\nheight = 1\n"
    for text, message in (("", r"ball is missing, expected a table \[ball\], or \[sample\]"),
                          (ball + sample, "ball and sample are there, expected one of them"),
                          (sample, r"a flat sample is described, expected a table \[ball\]")):
        (tmp_path / "setup.toml").write_text(text + rest)
        with pytest.raises(fitter.DatasetError, match=message):
            parsing.read(tmp_path).need_ball()


@pytest.mark.parametrize("more", [
    {"scale": {"intensity": [3.0, 2.0, 1.0]}},
    {"scale": {"ball": {"file": "card.exr", "exposures": [1], "albedo": [0.9, 0.9, 0.9], "direction": [0, -1, 0.5]}}},
    {"chrome": {"centre": [0, 0, 0], "radius": 0.03}, "lamp": {"positions": "dome.lp"}, "scale": {"albedo": 0.5}}],
    ids=["far", "ball", "positions"])
def test_no_value_of_a_wrong_kind_is_more_than_an_error_of_its_key(written, scenes, more):
    """Of each key in turn: it is refused by a line that names the file, or it makes no difference."""
    (written.parent / "dome.lp").write_text("1\nlamp1.exr 0.3 -.2 .9\n")
    given = {**tomllib.loads(written.read_text("utf-8")), **more}
    shot = {"files": ["lamp1.exr"], "exposures": [1]}
    given["photograph"] = [shot if "lamp" in more else {**shot, "direction": [0.3, -0.9, 0.4]}]
    given["camera"] |= {"matrix": np.eye(3).tolist(), "encoding": "linear"}
    given["ball"]["centre"] = [float(x) for x in scenes[0].centre]
    resolve(parsing.parse(given, written))
    said = wrong_values.refusals(lambda described: resolve(parsing.parse(described, written)), given)
    assert len(said) > 200
    assert all(str(written.parent) in text for _, text in said), said


def test_lamps_far_away_are_as_those_at_a_great_distance(openimageio, tmp_path):
    """The truth is of lamps 200 m away, whose intensity is that of their irradiance there."""
    model, far = ball_scene.satin(), 200.0
    scenes = [ball_scene.at_phase(phase, 40.0 * k, far, intensity=(2 * far ** 2,) * 3, **SIZE)
              for k, phase in enumerate((30, 75, 120))]
    path = ball_files.write(tmp_path, model, scenes)
    text = path.read_text()
    for scene in scenes:
        place = [round(float(x), 6) for x in scene.lamp]
        assert f"lamp = {place}\n" in text
        text = text.replace(f"lamp = {place}\n", f"direction = {(np.array(scene.lamp) / 70).tolist()}\n")
    text = text.replace(text[text.index("card = "):text.index("}", text.index("card = ")) + 1], "intensity = 2.0")
    path.write_text(text)
    assert off(measure(path), model) < 0.02
    path.write_text(text.replace("direction = [", "lamp = [", 1))
    with pytest.raises(fitter.DatasetError, match="some lamps have a place, and some only a direction"):
        measure(path)


@pytest.mark.parametrize("lens", [True, False], ids=["of known lens", "of no known lens"])
def test_a_camera_of_unknown_distance(openimageio, tmp_path, lens):
    """Seen from 40 radii away; lamps by their directions in the pictures, the albedo is a guess."""
    model = ball_scene.satin()
    scenes = [ball_scene.at_phase(phase, 40.0 * k, 200.0, camera=(0.0, -2.0, 0.0), angle=3.2,
                                  intensity=(8e4, 8e4, 8e4), **SIZE)
              for k, phase in enumerate((30, 75, 120))]
    for number, scene in enumerate(scenes):
        ball_files.write_picture(tmp_path / f"{number}.exr", ball_scene.photograph(model, scene, noise=0.01))
    lines = [f"{number}.exr {x} {z} {-y}" for number, (x, y, z) in enumerate(
        np.array([scene.lamp for scene in scenes]) / 200)]
    (tmp_path / "dome.lp").write_text("\n".join(["3", *lines]))
    text = ("[camera]\nposition = 'far'\n" + "field_of_view = 3.2\n" * lens + "[ball]\ncentre = 'outline'\n[scale]\n"
            "albedo = 0.3\n[lamp]\npositions = 'dome.lp'\n")
    (tmp_path / "setup.toml").write_text(text)
    samples = measure(tmp_path)
    known = model.evaluate(*samples.directions)
    ratio = samples.values / known
    assert np.median(np.abs(ratio / np.median(ratio) - 1)) < (0.015 if lens else 0.025)
    if lens:
        said = next(note for note in samples.notes if note.startswith("The camera is"))
        # 2 m for a radius of 0.05 m
        assert float(said.split()[3]) == pytest.approx(measuring.RADIUS * 40, rel=0.01)


def test_photographs_of_a_dome_whose_lights_were_found_with_others(openimageio, scenes, written, tmp_path):
    """Names in the .lp file are of the chrome ball: what belongs together says the order, and a note."""
    for number in (1, 2, 3):
        os.link(written.parent / f"lamp{number}.exr", tmp_path / f"vase{number + 8}.exr")
    directions = [np.array(scene.lamp) / np.linalg.norm(scene.lamp) for scene in scenes]
    (tmp_path / "dome.lp").write_text("\n".join(["3", *(f"/home/x/chrome{k}.jpg {x} {z} {-y}"
                                                       for k, (x, y, z) in enumerate(directions))]))
    samples = measure(tmp_path)
    assert any("belong together by their order" in note for note in samples.notes)
    (tmp_path / "vase11.exr").unlink()
    with pytest.raises(fitter.DatasetError, match=r"chrome0.jpg: .* no such file, and 2 pictures beside it"):
        measure(tmp_path)
    (tmp_path / "other.lp").write_text("1\na.exr 0 0 1")
    with pytest.raises(fitter.DatasetError, match=r"several descriptions found, dome\.lp, other\.lp"):
        measure(tmp_path)
    with pytest.raises(fitter.DatasetError, match="a folder without a description"):
        measure(tmp_path.parent)


def test_a_chrome_ball_of_another_size_and_place(openimageio, scenes, tmp_path):
    """By its outline, which a mask says; the highlight is saturated."""
    chrome = ball_scene.truths.Truth("", "", ball_scene.truths._lobe(3000.0, 0.01, f0=0.9).evaluate)
    lines = []
    for number, scene in enumerate(scenes[:2]):
        other = dataclasses.replace(scene, centre=(0.02, 0.01, -0.01), radius=0.03, size=(240, 240))
        ball_files.write_picture(tmp_path / f"{number}.exr", ball_scene.photograph(ball_scene.satin(), other))
        ball_files.write_picture(tmp_path / f"c{number}.exr", ball_scene.photograph(chrome, other, points=3))
        distance = np.linalg.norm(np.subtract(scene.lamp, other.centre))
        lines.append(f'[[photograph]]\nfiles = ["{number}.exr"]\nchrome = "c{number}.exr"\ndistance = {distance}\n')
    away = other.rays() @ np.subtract(other.centre, scene.camera)
    miss = np.sqrt(np.sum(np.subtract(other.centre, scene.camera) ** 2) - away ** 2)
    ball_files.write_picture(tmp_path / "mask.png", (miss < other.radius)[..., None] * np.ones(3))
    text = (
        f"[camera]\nposition = {list(scene.camera)}\nfield_of_view = {scene.angle}\n[ball]\ncentre = [0, 0, 0]\n"
        f"radius = {scene.radius}\n[chrome]\nradius = 0.03\nmask = 'mask.png'\n[scale]\nalbedo = 0.5\n")
    (tmp_path / "setup.toml").write_text(text + "".join(lines))
    for shot, scene in zip(measuring.read_photographs(parsing.read(tmp_path))[0], scenes[:2], strict=True):
        angle = np.arccos(shot.lamp @ scene.lamp / np.linalg.norm(shot.lamp) / np.linalg.norm(scene.lamp))
        assert np.degrees(angle) < 1.0
