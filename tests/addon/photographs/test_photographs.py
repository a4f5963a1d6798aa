"""Photographs of a ball in Blender: a scene of them, ball and lamps in their places, the material, a comparison."""


import contextlib
import tomllib
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Vector

import fitter
from fitter.photographs.ball import measuring
from fitter.photographs.description import parsing
from support import ball_files, ball_scene, stage
from support.blend_state import state, whole_state
from support.cases import quick
from support.drawn import draw
from tests.addon.work.test_failing_operators import _Injection as Injection

SIZE = 64
PHASES = 30, 75, 120
PLACE = {"camera": (0.3, -1.4, 0.2), "target": (0.01, 0.02, -0.01), "centre": (0.012, 0.004, -0.006),
         "size": (SIZE, SIZE)}


@pytest.fixture(scope="module")
def scenes():
    return ball_scene.scenes(PHASES, **PLACE)


@pytest.fixture(scope="module")
def written(openimageio, scenes, tmp_path_factory):
    return ball_files.write(tmp_path_factory.mktemp("ball"), ball_scene.satin(), scenes)


@pytest.fixture(autouse=True)
def few_samples(extension, monkeypatch):
    """The place of the next lamp is found by few samples: `tests/fitter/photographs` has it in earnest."""
    monkeypatch.setattr(extension.fitter.photographs.ball.coverage, "_SAMPLES", 200)
    monkeypatch.setattr(extension.fitter.photographs.report, "_FITTED", 200)


@pytest.fixture
def opened(blender, written, tmp_path):
    """The settings of a scene that was made of the description."""
    bpy.ops.measured_brdf.measure_photographs(filepath=str(written))
    settings = bpy.context.scene.measured_brdf_photographs
    settings.preset, settings.samples = "Draft", str(tmp_path / "ball.npz")
    return settings


def describe():
    """The description that the open scene stands for."""
    from measured_brdf.addon.photographs import describing

    return describing.describe_scene(bpy.context.scene.measured_brdf_photographs)


def pixel(place):
    """Where the scene's camera shows a place: column and row in pixels, as `ball_scene.Scene.toward` counts them."""
    scene = bpy.context.scene
    # evaluated: up to Blender 4.5 without a window those of a scene that was just made have places only there
    camera = scene.camera.evaluated_get(bpy.context.evaluated_depsgraph_get())
    x, y, _ = world_to_camera_view(scene, camera, Vector(place))
    return x * scene.render.resolution_x, (1 - y) * scene.render.resolution_y


def refused(operator, message, **options):
    """An operator reports an error in one line, and changes nothing."""
    before = whole_state()
    with pytest.raises(RuntimeError, match=message) as error:
        operator(**options)
    assert len(str(error.value).strip().removeprefix("Error: ").splitlines()) == 1
    assert whole_state() == before


def fail_everywhere(run, step=1):
    """An error in any function that an operator calls, or in each so-many-th, changes nothing: where it was raised."""
    before, places = whole_state(), []
    for at in range(1, 200, step):
        injection, result = Injection(at), None
        with contextlib.suppress(RuntimeError), injection:
            result = run()
        if injection.where is None:
            break
        places.append(injection.where)
        assert whole_state() == before, injection.where
    assert result == {"FINISHED"}
    assert whole_state() != before
    return places


def remember(monkeypatch, module, names, known, key=repr):
    """Let functions of a module return what they have returned before for what has the same key."""
    def remembering(function):
        def once(*arguments):
            found = function.__name__, key(arguments)
            if found not in known:
                known[found] = function(*arguments)
            return known[found]
        return once

    for name in names:
        monkeypatch.setattr(module, name, remembering(getattr(module, name)))


def measured_fit(material):
    from measured_brdf.addon.core.shading import material as materials
    from measured_brdf.addon.core.shading import node_group

    return fitter.Fit.from_bytes(node_group.kept_fit(materials.group_node(material).node_tree))


def pairs():
    """Pairs of directions that the photographs cover, by the lamps' phase angles."""
    random = np.random.default_rng(4)
    theta_i, theta_o = np.radians(random.uniform(5, 60, (2, 400)))
    phi = random.uniform(0, 2 * np.pi, 400)
    cosine = np.cos(theta_i) * np.cos(theta_o) + np.sin(theta_i) * np.sin(theta_o) * np.cos(phi)
    near = np.min(np.abs(np.degrees(np.arccos(cosine))[:, None] - PHASES), axis=1) < 4
    return theta_i[near], np.zeros(near.sum()), theta_o[near], phi[near]


def test_a_description_becomes_a_scene_that_shows_what_was_photographed(opened, scenes):
    scene, first = bpy.context.scene, scenes[0]
    assert (scene.render.resolution_x, scene.render.resolution_y) == (SIZE, SIZE)
    assert [each.name for each in opened.photographs] == ["lamp1", "lamp2", "lamp3"]
    for shot, truth in zip(opened.photographs, scenes, strict=True):
        np.testing.assert_allclose(shot.lamp.location, truth.lamp, atol=1e-5)
    # through places of the picture, by the other renderer's rays
    for row, column in ((10.0, 20.0), (50.0, 31.0)):
        place = np.array(first.camera) + 1.3 * first.toward(row, column)
        assert pixel(place) == pytest.approx((column, row), abs=0.01)
    across = SIZE / (2 * np.tan(np.radians(first.angle / 2))) / np.linalg.norm(np.subtract(first.camera, first.centre))
    off = np.subtract(opened.ball.location, first.centre)
    away = np.subtract(first.camera, first.centre) / np.linalg.norm(np.subtract(first.camera, first.centre))
    assert np.linalg.norm(np.cross(off, away)) * across < 0.2          # of a pixel
    assert abs(off @ away) < 0.01                                      # by the size of its outline
    assert opened.radius == pytest.approx(first.radius)


def test_the_scene_is_described_as_the_file_is(opened, written):
    """In the single precision that Blender's objects have; the ball's centre is that of the outline."""
    told, found = tomllib.loads(written.read_text("utf-8")), describe()
    told["ball"]["centre"] = found["ball"]["centre"]
    for each in told["photograph"]:
        each["files"] = [str(written.parent / name) for name in each["files"]]
    told["scale"]["card"]["file"] = str(written.parent / told["scale"]["card"]["file"])
    toward = np.subtract(PLACE["target"], PLACE["camera"])
    np.testing.assert_allclose(found["camera"].pop("look_at"),
                               PLACE["camera"] + toward / np.linalg.norm(toward), atol=1e-6)
    found["camera"].pop("up")
    told["camera"].pop("look_at")
    assert rounded(found) == rounded(told)


def rounded(value):
    if isinstance(value, dict):
        return {key: rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [rounded(each) for each in value]
    return round(value, 4) if isinstance(value, float) else value


@pytest.mark.parametrize(("scale", "found"), [
    ('albedo = 0.3', {"albedo": 0.3}), ("intensity = 2.5", {"intensity": 2.5}),
    ("intensity = [2.5, 1.5, 0.5]", {"intensity": [2.5, 1.5, 0.5]}),
    ('ball = {file = "card.exr", exposures = [0.5], albedo = [0.7, 0.6, 0.5], lamp = [0.5, -1, 0.5]}',
     {"ball": {"file": "card.exr", "exposures": [0.5], "albedo": [0.7, 0.6, 0.5], "lamp": [0.5, -1.0, 0.5]}}),
], ids=str)
def test_each_scale_and_all_files_are_kept(blender, written, tmp_path, scenes, scale, found):
    files = [[f"lamp{number}.exr"] for number in (1, 2, 3)]
    text = ball_files.description(scenes, files, scale, scenes[0].centre, 'dark = "dark.exr"\nflat = "flat.exr"')
    matrix = [[0.5, 0.25, 0.25], [0.0, 1.0, 0.0], [0.0, 0.25, 0.75]]
    text = text.replace("[ball]\n", f'matrix = {matrix}\nencoding = "linear"\n[ball]\nmask = "mask.exr"\n', 1)
    for each in written.parent.glob("*.exr"):
        (tmp_path / each.name).write_bytes(each.read_bytes())
    for name in ("dark", "flat", "mask"):
        ball_files.write_picture(tmp_path / f"{name}.exr", np.full((SIZE, SIZE, 3), 0.9 * (name != "dark")))
    (tmp_path / "setup.toml").write_text(text)
    bpy.ops.measured_brdf.measure_photographs(filepath=str(tmp_path / "setup.toml"))
    kept = describe()
    if "ball" in found:
        found = {"ball": {**found["ball"], "file": str(tmp_path / "card.exr")}}
    assert rounded(kept["scale"]) == found
    assert kept["camera"]["matrix"] == matrix
    assert kept["camera"]["encoding"] == "linear"
    assert kept["lamp"] == {"dark": str(tmp_path / "dark.exr"), "flat": str(tmp_path / "flat.exr"),
                            "radius": pytest.approx(0.02)}
    assert kept["ball"]["mask"] == str(tmp_path / "mask.exr")


def test_the_outline_moves_the_ball_onto_its_picture(opened, scenes):
    truth = np.array(opened.ball.location)
    opened.ball.location, opened.known = (0, 0, 0), ""          # nothing else need be there yet
    assert bpy.ops.measured_brdf.fit_outline() == {"FINISHED"}
    np.testing.assert_allclose(opened.ball.location, truth, atol=1e-5)
    assert pixel(opened.ball.location) == pytest.approx(pixel(scenes[0].centre), abs=0.2)


def test_measuring_makes_the_material_of_the_ball(opened, written):
    """Its samples are those of the command line, and its fit is the paint; the lamp shines as it did."""
    opened.ball.location = np.add(opened.ball.location, (0.0003, 0, 0.0002))       # by hand, half a pixel off
    assert bpy.ops.measured_brdf.measure_ball() == {"FINISHED"}
    material = opened.ball.active_material
    assert material.measured_brdf.filepath == opened.samples
    samples, expected = fitter.load(opened.samples), measuring.measure_ball(parsing.read(written)).samples
    assert abs(len(samples) - len(expected)) < 0.01 * len(expected)
    values = measured_fit(material).evaluate(*pairs())
    off = np.abs(values / ball_scene.satin().evaluate(*pairs()) - 1)
    assert np.median(off) < 0.02
    assert np.quantile(off, 0.9) < 0.08
    light = opened.photographs[0].lamp.data
    assert light.energy == pytest.approx(4 * np.pi * 2, rel=0.01)
    assert tuple(light.color) == pytest.approx((1, 1, 1), abs=0.01)
    assert "Put the next lamp at" in opened.told
    assert "the rest is a guess" in opened.told


def test_measuring_again_gives_the_same_material_a_new_fit(opened):
    bpy.ops.measured_brdf.measure_ball()
    material, digest = opened.ball.active_material, opened.ball.active_material.measured_brdf.digest
    opened.photographs[2].used = False
    bpy.ops.measured_brdf.measure_ball()
    assert opened.ball.active_material == material
    assert material.measured_brdf.digest != digest
    assert opened.told.startswith("2 photographs of a ball, the lamp at 30 7")


def test_cycles_renders_the_ball_onto_its_photograph(opened, written, scenes):
    """In the scene as it is, pixel by pixel; and the operator finds the same difference in a Blender of its own."""
    bpy.ops.measured_brdf.measure_ball()
    opened.active = 1
    scene = bpy.context.scene
    scene.cycles.pixel_filter_type, scene.cycles.samples, scene.cycles.use_denoising = "BOX", 64, False
    picture = stage.render(scene)[..., :3]
    truth = ball_scene.photograph(ball_scene.satin(), scenes[1], points=4)
    lit = truth.sum(axis=2) > 0.05 * truth.sum(axis=2).max()
    assert np.mean(np.abs(picture - truth)[lit]) < 0.02 * np.mean(truth[lit])
    rows, columns = np.indices(lit.shape)
    for axis in (rows, columns):
        middle = [np.average(axis, weights=each.sum(axis=2)) for each in (picture, truth)]
        assert abs(middle[0] - middle[1]) < 0.03
    assert bpy.ops.measured_brdf.compare_photograph() == {"FINISHED"}
    shot = opened.photographs[1]
    assert shot.difference < 0.02
    side = shot.comparison.size[0] // 2
    pixels = np.empty(4 * (2 * side) ** 2, dtype=np.float32)
    shot.comparison.pixels.foreach_get(pixels)
    tiles = pixels.reshape(2, side, 2, side, 4)[::-1, ::-1, ..., :3]       # the top row first
    photograph, rendered, differing = tiles[0, :, 0], tiles[0, :, 1], tiles[1, :, 1]
    assert np.abs(photograph - rendered).mean() < 0.01
    np.testing.assert_allclose(differing[side // 2, side // 2],
                               4 * np.abs(photograph - rendered)[side // 2, side // 2], atol=0.02)


def test_a_guess_of_the_albedo_is_one_of_the_lamp(opened):
    """The ball renders as it was photographed, whatever is guessed."""
    opened.scale, opened.albedo = "albedo", 0.4
    bpy.ops.measured_brdf.measure_ball()
    dark = opened.photographs[0].lamp.data.energy
    assert "The scale is a guess: an albedo of 0.4 was given" in opened.told
    opened.albedo = 0.2
    bpy.ops.measured_brdf.measure_ball()
    assert opened.photographs[0].lamp.data.energy == pytest.approx(2 * dark, rel=1e-3)


def test_photographs_that_say_nothing_sure_are_warnings_and_marked_in_the_panel(opened, capfd):
    """A picture twice, and a ball that reflects far more than it gets."""
    from measured_brdf.addon.photographs import panel

    opened.scale, opened.intensity = "intensity", (1e-4,) * 3
    opened.photographs[2].files[0].filepath = opened.photographs[1].files[0].filepath
    opened.photographs[2].lamp.location = np.add(opened.photographs[1].lamp.location, (1e-3, 0, 0))
    capfd.readouterr()
    assert bpy.ops.measured_brdf.measure_ball() == {"FINISHED"}
    warned = [line for line in capfd.readouterr().out.splitlines() if line.startswith("Warning:")]
    assert any("1 of 3 photographs repeat the picture of another one, lamp2.exr" in line for line in warned)
    assert any("More light leaves than arrives" in line for line in warned)
    assert {line.removeprefix("Warning: ") for line in warned} >= set(opened.doubts.splitlines())
    assert set(opened.doubts.splitlines()) <= set(opened.told.splitlines())
    marked = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(panel, "draw_wrapped", lambda _layout, text, icon: marked.append((text, icon)))
        draw(panel.MEASUREDBRDF_PT_photographs_coverage)
    assert {text for text, icon in marked if icon == "ERROR"} == set(opened.doubts.splitlines())


def test_a_lamp_stands_where_a_chrome_ball_shows_it(opened, scenes, tmp_path):
    chrome = ball_scene.truths.Truth("chrome", "", ball_scene.truths._lobe(3000.0, 0.01, f0=0.9).evaluate)
    picture = np.minimum(ball_scene.photograph(chrome, scenes[1], points=3), 5.0)
    ball_files.write_picture(tmp_path / "chrome.exr", picture)
    opened.active = 1
    opened.photographs[1].lamp.location = (0, -2, 0)
    assert bpy.ops.measured_brdf.place_lamp(filepath=str(tmp_path / "chrome.exr"), distance=1.2) == {"FINISHED"}
    direction, truth = (np.subtract(place, scenes[1].centre)
                    for place in (opened.photographs[1].lamp.location, scenes[1].lamp))
    assert np.degrees(np.arccos(direction @ truth / np.linalg.norm(direction) / np.linalg.norm(truth))) < 4    # a pixel
    assert np.linalg.norm(direction) == pytest.approx(1.2, abs=0.01)


@pytest.fixture
def chosen(blender, written, tmp_path):
    """Pictures that were chosen in the file browser, without a description."""
    for shot in ("2", "10", "1"):
        for seconds in (0.5, 2.0):
            source = fitter.imaging.picture_files.read_picture(written.parent / "lamp1.exr").pixels
            ball_files.write_picture(tmp_path / f"ball{shot}_{seconds}.exr", source * seconds, ExposureTime=seconds,
                                     Exif__FocalLength=105.0, Exif__FocalLengthIn35mmFilm=210)
    return sorted(tmp_path.glob("*.exr"))


def choose(paths, **options):
    return bpy.ops.measured_brdf.measure_photographs(directory=str(paths[0].parent),
                                                     files=[{"name": path.name} for path in paths], **options)


def test_pictures_that_are_chosen_are_grouped_by_their_exposures(chosen):
    assert choose(chosen, radius=0.05, distance=1.25) == {"FINISHED"}
    settings = bpy.context.scene.measured_brdf_photographs
    assert [[bpy.path.basename(file.filepath) for file in shot.files] for shot in settings.photographs] == [
        [f"ball{number}_{seconds}.exr" for seconds in (0.5, 2.0)] for number in (1, 2, 10)]
    assert settings.radius == pytest.approx(0.05)
    assert settings.camera.location[:] == pytest.approx((0, -1.25, 0))
    assert settings.camera.data.lens == pytest.approx(105)
    assert settings.camera.data.angle_x == pytest.approx(2 * np.arctan(18 / 210), rel=1e-5)
    assert settings.scale == "albedo"
    ball_files.write_picture(chosen[0], np.ones((SIZE // 2, SIZE, 3)))
    refused(choose, "photographs of several sizes found: ball1_0.5.exr 64 x 64, ball10_0.5.exr 64 x 32", paths=chosen)


def test_lamps_that_nobody_has_placed_are_not_measured(chosen):
    choose(chosen)
    settings = bpy.context.scene.measured_brdf_photographs
    refused(bpy.ops.measured_brdf.measure_ball, "ball1_0.5: say where the lamp stood")
    settings.photographs[0].lamp.location = (1, -1, 0)
    refused(bpy.ops.measured_brdf.measure_ball, "ball2_0.5: say where the lamp stood")


@pytest.mark.parametrize("has_description", [False, True])
def test_a_folder_of_photographs_is_understood(chosen, written, tmp_path, has_description):
    """Its description, or else its pictures."""
    folder = written.parent if has_description else tmp_path
    assert bpy.ops.measured_brdf.measure_photographs(filepath=str(folder)) == {"FINISHED"}
    settings = bpy.context.scene.measured_brdf_photographs
    assert [each.name for each in settings.photographs] == (
        ["lamp1", "lamp2", "lamp3"] if has_description else ["ball1_0.5", "ball2_0.5", "ball10_0.5"])
    assert settings.camera.location[1] == pytest.approx(PLACE["camera"][1] if has_description else -1.5)


def test_photographs_are_added_to_a_scene(opened, chosen):
    assert choose(chosen[:2], exposures=2, to_scene=True) == {"FINISHED"}
    assert [each.name for each in opened.photographs] == ["lamp1", "lamp2", "lamp3", chosen[0].stem]
    assert opened.photographs[3].lamp.data == opened.photographs[0].lamp.data
    assert opened.active == 3
    refused(choose, "2 pictures found, expected a multiple of 3 exposures", paths=chosen[:2], exposures=3,
            to_scene=True)


def test_the_lamp_of_the_active_photograph_is_shown(opened):
    for number in (1, 2, 0):
        opened.active = number
        lamps = [each.lamp for each in opened.photographs]
        assert [lamp.hide_viewport or lamp.hide_render for lamp in lamps] == [k != number for k in range(3)]
        assert bpy.context.view_layer.objects.active == lamps[number]
        background, = opened.camera.data.background_images
        assert background.image == opened.photographs[number].picture
    opened.photographs[1].lamp.location.x += 0.25       # it is hidden, and its place counts all the same
    assert describe()["photograph"][1]["lamp"] == pytest.approx(opened.photographs[1].lamp.location[:])


def show(shots, path, pixels):
    """Write a picture, which is that of photographs."""
    ball_files.write_picture(path, pixels)
    for shot in shots:
        shot.files[0].filepath = str(path)


def dark(settings, folder):
    show(settings.photographs[:1], folder / "dark.exr", np.zeros((SIZE, SIZE, 3)))


def two_balls(settings, folder):
    wide = ball_scene.scenes(PHASES[:1], **PLACE | {"angle": 14.0})[0]
    picture = ball_scene.photograph(ball_scene.satin(), wide)
    settings.camera.data.lens *= 4.2 / 14
    show(settings.photographs, folder / "two.exr", np.roll(picture, -13, axis=1) + np.roll(picture, 13, axis=1))


def mixed_sizes(settings, folder):
    show(settings.photographs[1:2], folder / "small.exr", np.ones((SIZE // 2, SIZE, 3)))


def behind(settings, _folder):
    camera = np.array(settings.camera.location)
    settings.photographs[0].lamp.location = camera + 0.5 * (camera - PLACE["centre"])


def moved_camera(settings, _folder):
    settings.camera.location.x += 0.03


def deleted(settings, _folder):
    bpy.data.objects.remove(settings.photographs[1].lamp)


def no_folder(settings, folder):
    settings.samples = str(folder / "not there" / "ball.npz")


@pytest.mark.parametrize(("spoil", "message"), [
    (dark, "dark.exr: a black photograph"),
    (mixed_sizes, "photographs of several sizes found: lamp1.exr 64 x 64, small.exr 64 x 32"),
    (behind, "lamp1.exr: the lamp is behind the camera, whose shadow falls on the ball"),
    (moved_camera, "the ball's outline is not where it is said to be"),
    (deleted, "The lamp of lamp2 has been deleted"), (no_folder, "Save As: .*not there: not a folder"),
    (lambda settings, folder: setattr(settings, "matrix", "[[1, 0], 2]"), "Camera Matrix is .*expected three rows"),
    (lambda settings, folder: setattr(settings, "known", ""), "Scale: choose the photograph of the card"),
    (lambda settings, folder: [setattr(each, "used", False) for each in settings.photographs],
     "No photograph of this scene is used")],
    ids=lambda value: getattr(value, "__name__", value))
def test_what_is_wrong_is_said_in_one_line_and_nothing_changes(opened, tmp_path, spoil, message):
    spoil(opened, tmp_path)
    refused(bpy.ops.measured_brdf.measure_ball, message)


@pytest.mark.parametrize(("spoil", "message"), [(two_balls, "two bright things found, expected one ball"),
                                                (mixed_sizes, "photographs of several sizes")])
def test_no_outline_of_one_ball_moves_nothing(opened, tmp_path, spoil, message):
    spoil(opened, tmp_path)
    refused(bpy.ops.measured_brdf.fit_outline, message)


def test_a_description_that_is_wrong_makes_no_scene(blender, written, tmp_path):
    refused(bpy.ops.measured_brdf.measure_photographs, "The path is empty: choose the photographs")
    refused(bpy.ops.measured_brdf.measure_photographs, "a folder without photographs", filepath=str(tmp_path))
    refused(bpy.ops.measured_brdf.measure_photographs, "none.toml: cannot be read",
            filepath=str(tmp_path / "none.toml"))
    text = written.read_text().replace("radius = 0.05", "radius = -1")
    (written.parent / "wrong.toml").write_text(text)
    refused(bpy.ops.measured_brdf.measure_photographs, "wrong.toml: ball.radius is -1",
            filepath=str(written.parent / "wrong.toml"))
    two = written.read_text().replace('file = "card.exr"', 'file = ["card.exr", "card.exr"], exposures = [1, 2]')
    (written.parent / "two.toml").write_text(two)
    refused(bpy.ops.measured_brdf.measure_photographs, "2 files found, expected one", filepath=str(
        written.parent / "two.toml"))


@pytest.mark.parametrize("removed", ["ball", "scene"])
def test_what_is_deleted_while_it_is_measured_is_not_missed(opened, monkeypatch, removed):
    from measured_brdf.addon.photographs import work

    measured = work.measure_ball

    def meanwhile(*arguments, **options):
        result = measured(*arguments, **options)
        if removed == "ball":
            bpy.data.objects.remove(opened.ball)
        else:
            bpy.data.scenes.remove(bpy.context.scene)
        return result

    monkeypatch.setattr(work, "measure_ball", meanwhile)
    before = sorted(item.name for item in bpy.data.materials)
    with pytest.raises(RuntimeError, match="The scene of the photographs has been removed meanwhile"):
        bpy.ops.measured_brdf.measure_ball()
    assert sorted(item.name for item in bpy.data.materials) == before


@pytest.fixture
def once(extension, monkeypatch):
    """What the workers measure, worked out once: the lines of it are not those that fail here."""
    remember(monkeypatch, extension.addon.photographs.work, ("find_scene", "find_places", "measure_ball"), {})


@pytest.mark.parametrize("name", quick(["measure_photographs", "fit_outline", "measure_ball", "measure_ball again"],
                                       "measure_photographs", "fit_outline"))
def test_an_error_anywhere_leaves_the_blend_as_it_was(opened, once, written, name, capfd):
    name, _, again = name.partition(" ")
    opened.ball.location = (0.012, 0.004, -0.006)
    options = {"filepath": str(written)} if name == "measure_photographs" else {}
    if again:
        bpy.ops.measured_brdf.measure_ball()
        opened.photographs[2].used = False
    assert len(fail_everywhere(lambda: getattr(bpy.ops.measured_brdf, name)(**options))) > 5
    capfd.readouterr()


def test_it_is_all_in_the_file(opened, tmp_path):
    bpy.ops.measured_brdf.measure_ball()
    bpy.ops.measured_brdf.compare_photograph()
    opened.active = 2
    before, shown, told = whole_state(), opened.photographs[0].comparison.pixels[:400], opened.told
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "ball.blend"))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "ball.blend"))
    settings = bpy.context.scene.measured_brdf_photographs
    for part in {*before} - {*state(), "photographs"}:          # paths of files are relative now
        assert whole_state()[part] == before[part], part
    assert settings.active == 2
    assert settings.photographs[0].comparison.pixels[:400] == shown
    assert bpy.ops.measured_brdf.measure_ball() == {"FINISHED"}
    assert settings.told.splitlines()[-1] == told.splitlines()[-1]


def test_its_paths_are_relative_where_it_is_saved_and_may_be_forgotten(opened, written, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "ball.blend"), compress=False)
    files = [file.filepath for shot in opened.photographs for file in shot.files]
    assert {path[:2] for path in (*files, opened.samples)} == {"//"}
    assert bpy.ops.measured_brdf.measure_ball() == {"FINISHED"}
    folder, opened.mask = written.parent.name.encode(), str(written.with_name("mask.png"))
    for is_forgotten in (False, True):
        if is_forgotten:
            assert bpy.ops.measured_brdf.forget_paths() == {"FINISHED"}
        bpy.ops.wm.save_mainfile(compress=False)
        assert (folder in (tmp_path / "ball.blend").read_bytes()) != is_forgotten


def test_undo_takes_it_back(opened):
    bpy.ops.ed.undo_push(message="opened")
    before = whole_state()
    bpy.ops.measured_brdf.measure_ball()
    bpy.ops.ed.undo_push(message="measured")
    assert whole_state() != before
    bpy.ops.ed.undo()
    assert whole_state() == before
    bpy.ops.ed.redo()
    assert bpy.context.scene.measured_brdf_photographs.told


def test_the_panel_says_what_is_a_guess_and_where_the_next_lamp_goes(opened, chosen):
    from measured_brdf.addon.photographs import panel

    assert "guess" not in draw(panel.MEASUREDBRDF_PT_photographs).texts
    opened.scale, opened.albedo = "albedo", 0.4
    assert "The scale is a guess" in draw(panel.MEASUREDBRDF_PT_photographs).texts
    assert not panel.MEASUREDBRDF_PT_photographs_coverage.poll(bpy.context)
    bpy.ops.measured_brdf.measure_ball()
    coverage = draw(panel.MEASUREDBRDF_PT_photographs_coverage).texts
    assert "the rest is a guess" in coverage
    assert "Without lamp2.exr, that photograph is predicted within" in coverage
    assert "Put the next lamp at" in coverage
    assert draw(panel.MEASUREDBRDF_PT_photographs_comparison).kinds == ["button"]
    bpy.ops.measured_brdf.compare_photograph()
    shown = draw(panel.MEASUREDBRDF_PT_photographs_comparison)
    assert "picture" in shown.kinds
    assert f"the render differs by {opened.photographs[0].difference:.1%}: excellent" in shown.texts
    opened.photographs[0].difference = 0.4
    assert "the render differs by 40.0%: poor" in draw(panel.MEASUREDBRDF_PT_photographs_comparison).texts
    for scale, field in (("card", "region"), ("ball", "known_albedo"), ("intensity", "intensity"),
                         ("albedo", "albedo")):
        opened.scale = scale
        assert field in draw(panel.MEASUREDBRDF_PT_photographs_scale).fields
    assert {"lens", "radius", "flat"} <= set(draw(panel.MEASUREDBRDF_PT_photographs_stage).fields)
    choose(chosen)
    item = bpy.context.scene.measured_brdf_photographs
    layout = SimpleNamespace(**{"row": lambda: layout, "prop": lambda *_, **__: None,
                                "label": lambda **what: told.append(what["text"])})
    told = []
    panel.MEASUREDBRDF_UL_photographs.draw_item(None, None, layout, item, item.photographs[0], 0, item, "active")
    panel.MEASUREDBRDF_UL_photographs.draw_item(None, None, layout, opened, opened.photographs[1], 0, opened, "active")
    assert told == ["ball1_0.5", "not placed", "lamp2", "75°"]
    opened.photographs[1].name = "Loewenkopf_klein_0121"         # which the list has no room for
    panel.MEASUREDBRDF_UL_photographs.draw_item(None, None, layout, opened, opened.photographs[1], 0, opened, "active")
    assert told[4] == "…f_klein_0121"


def test_without_photographs_there_is_no_panel(blender):
    from measured_brdf.addon.photographs import panel

    assert not panel.MEASUREDBRDF_PT_photographs.poll(bpy.context)
    with pytest.raises(RuntimeError, match="This scene has no photographs to measure"):
        bpy.ops.measured_brdf.measure_ball()
