"""Photographs of a flat sample in Blender: a scene of them, its outline and lamps, the material, a comparison."""

import re

import bpy
import numpy as np
import pytest
from mathutils import Vector

import fitter
from support import ball_files, flat_files, flat_scene, stage
from support.checkout import ROOT
from support.drawn import draw
from tests.addon.photographs.test_photographs import describe, pixel, refused
from tests.fitter.photographs.test_flat_setup import even

HEIGHT, WIDTH = flat_files.SIZE
LAMPS = flat_scene.lamps(10)


@pytest.fixture(scope="module")
def sample(cornell, curet):
    fits = tuple(fitter.fit(samples, **fitter.PRESETS["Draft"])
                 for samples in (cornell("garnet_red_RGB"), curet("leather")))
    return flat_scene.Sample(fits, flat_scene.smooth_weights(2), flat_scene.bumps)


@pytest.fixture(scope="module")
def written(openimageio, sample, tmp_path_factory):
    return flat_files.write(tmp_path_factory.mktemp("sample"), sample, LAMPS, top="texels = 24")


def open_scene(path=None, **options):
    """The settings of the scene that is made."""
    given = options if path is None else {"filepath": str(path), **options}
    assert bpy.ops.measured_brdf.measure_sample_photographs(**given) == {"FINISHED"}
    return bpy.context.scene.measured_brdf_photographs


@pytest.fixture
def opened(blender, written):
    return open_scene(written)


def corner_pixel(item, corner):
    """Where Blender's camera shows a vertex of an object: column and row."""
    evaluated = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return pixel(evaluated.matrix_world @ item.data.vertices[corner].co)


def names(folder):
    return {"directory": str(folder), "files": [{"name": path.name} for path in sorted(folder.glob("lamp*.exr"))]}


def test_a_description_becomes_a_scene_with_the_outline_where_the_corners_are(opened):
    scene = bpy.context.scene
    for item in (opened.sample, bpy.data.objects["Outline"]):
        for number, place in enumerate(flat_files.corners()):
            np.testing.assert_allclose(corner_pixel(item, number), place, atol=0.1)
    assert [(each.name, each.used) for each in opened.photographs] == [(f"lamp{k}", True) for k in range(1, 11)]
    for shot, lamp in zip(opened.photographs, LAMPS, strict=True):
        np.testing.assert_allclose(shot.lamp.location, lamp, atol=1e-5)
    assert (scene.render.resolution_x, scene.render.resolution_y) == (WIDTH, HEIGHT)
    assert (opened.width, opened.height, opened.texels) == pytest.approx((0.1, 0.08, 24))


def test_pictures_that_are_chosen_at_once_are_of_a_sample_that_fills_them(blender, written):
    settings = open_scene(width=0.2, **names(written.parent))
    assert [each.name for each in settings.photographs] == [f"lamp{k}" for k in range(1, 11)]
    assert (settings.width, settings.height) == pytest.approx((0.2, 0.2 * HEIGHT / WIDTH))
    assert settings.is_far
    for number, place in enumerate([[0, HEIGHT], [WIDTH, HEIGHT], [WIDTH, 0], [0, 0]]):
        np.testing.assert_allclose(corner_pixel(settings.sample, number), place, atol=0.3)


def positions(folder, name, is_project):
    toward = LAMPS / np.linalg.norm(LAMPS, axis=1, keepdims=True)
    toward[3] = 0
    path = folder / name
    path.write_text(f'{{"lights": {toward.ravel().tolist()}}}' if is_project else "10\n" + "".join(
        f"lamp{k}.exr {x} {y} {z}\n" for k, (x, y, z) in enumerate(toward, start=1)), "utf-8")
    return path


@pytest.mark.parametrize("name", ["dome.lp", "info.json"])
def test_light_positions_make_the_scene_or_place_its_lamps(blender, written, name, tmp_path):
    """One of the lights was not found: that photograph is not there, or its lamp stays."""
    for path in written.parent.glob("lamp*.exr"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    path = positions(tmp_path, name, name.endswith("json"))
    settings = open_scene(path)
    assert [each.name for each in settings.photographs] == [f"lamp{k}" for k in (1, 2, 3, *range(5, 11))]
    toward = np.array(settings.photographs[0].lamp.location)
    np.testing.assert_allclose(toward / np.linalg.norm(toward), LAMPS[0] / np.linalg.norm(LAMPS[0]), atol=1e-5)
    settings = open_scene(**names(tmp_path))
    before = tuple(settings.photographs[3].lamp.location)
    bpy.ops.measured_brdf.place_lamp(filepath=str(path), distance=0.5)
    for number, shot in enumerate(settings.photographs):
        if number != 3:
            place = 0.5 * LAMPS[number] / np.linalg.norm(LAMPS[number])
            np.testing.assert_allclose(shot.lamp.location, place, atol=1e-5)
    assert tuple(settings.photographs[3].lamp.location) == before


def test_chrome_pictures_that_are_chosen_at_once_place_all_lamps(opened, tmp_path):
    """A chrome ball beside the sample, in its plane, of pictures as large as the photographs; found by its mask."""
    ball, distance = np.array([0.056, 0.005, 0.005]), np.linalg.norm(LAMPS[0])
    for number, lamp in enumerate(LAMPS, start=1):
        picture, hit = even(lamp, (HEIGHT * 6, WIDTH * 6), ball, 0.005)
        ball_files.write_picture(tmp_path / f"lamp{number}.exr", picture)
        ball_files.write_picture(tmp_path / "ball.png", hit[..., None].astype(float))
    settings, size = opened, (HEIGHT * 6, WIDTH * 6)
    for number, shot in enumerate(settings.photographs, start=1):
        shot.files[0].filepath = str(tmp_path / f"lamp{number}.exr")
        shot.lamp.location = -0.6, -0.8, 0.7
    settings.corners, settings.chrome_mask = np.ravel(flat_files.corners(size)).tolist(), str(tmp_path / "ball.png")
    few = [{"name": f"lamp{number}.exr"} for number in range(1, 10)]
    with pytest.raises(RuntimeError, match="9 pictures of a chrome ball found, expected 10, one for each photograph"):
        bpy.ops.measured_brdf.place_lamp(directory=str(tmp_path), files=few, distance=distance)
    bpy.ops.measured_brdf.place_lamp(distance=distance, **names(tmp_path))
    for shot, lamp in zip(settings.photographs, LAMPS, strict=True):
        assert Vector(shot.lamp.location).angle(Vector(lamp)) < np.radians(2.5), shot.name


def test_measuring_makes_the_material_and_a_lamp_that_was_left_out_is_predicted(opened, sample, extension):
    """The report is in the panel, beside it what its lines are about."""
    from measured_brdf.addon.photographs import panel

    for name, fit in zip(("first", "second"), sample.fits, strict=True):
        setattr(opened, name, stage.material_for(fit))
    opened.photographs[4].used = False
    opened.camera.location.x += 0.1          # measuring puts it back
    assert bpy.ops.measured_brdf.measure_sample() == {"FINISHED"}
    assert np.linalg.norm(np.subtract(opened.camera.location, flat_scene.CAMERA)) < 2e-3
    assert opened.told.startswith("lamp") or "9 photographs" in opened.told
    light = opened.photographs[0].lamp.data
    np.testing.assert_allclose(np.array(light.color) * light.energy / (4 * np.pi), flat_scene.INTENSITY, rtol=1e-3)
    opened.active = 4
    assert bpy.ops.measured_brdf.compare_photograph() == {"FINISHED"}
    print(opened.photographs[4].difference)
    assert opened.photographs[4].difference < 0.06
    opened.photographs[4].lamp.location = LAMPS[0]       # a wrong lamp is noticed
    bpy.ops.measured_brdf.compare_photograph()
    assert opened.photographs[4].difference > 0.12
    opened.told += "\na.png: sRGB, which was made linear: where these are linear, set Values to Linear"
    report = draw(panel.MEASUREDBRDF_PT_photographs_coverage)
    assert "encoding" in report.fields
    assert "materials" in report.texts


def draw_mask(name, places):
    mask = bpy.data.masks.new(name)
    points = mask.layers.new().splines.new().points
    points.add(len(places) - len(points))
    for point, (x, y) in zip(points, places, strict=True):
        point.co = 0.5 + (x - WIDTH / 2) / WIDTH, 0.5 - (y - HEIGHT / 2) / WIDTH
        point.handle_left_type = point.handle_right_type = "FREE"
        point.handle_left = point.handle_right = point.co        # straight to the next
    return mask


def test_corners_and_masks_are_drawn_in_the_image_editor(opened):
    places = np.array(flat_files.corners())
    opened.drawn_corners = draw_mask("corners", (places + [3, -2])[[2, 0, 1, 3]])
    opened.drawn_outline = draw_mask("triangle", [[10, 10], [90, 10], [50, 80]])
    drawn = describe()["sample"]
    np.testing.assert_allclose(drawn["corners"], places + [3, -2], atol=1e-3)
    x, y = np.transpose(drawn["outline"])
    assert (x.min(), x.max(), y.min(), y.max()) == pytest.approx((10, 90, 10, 80), abs=0.5)
    assert bpy.ops.measured_brdf.fit_outline() == {"FINISHED"}
    for number, place in enumerate(places + [3, -2]):
        np.testing.assert_allclose(corner_pixel(opened.sample, number), place, atol=1.0)
    opened.drawn_outline = draw_mask("line", [[10, 10], [90, 10]])
    refused(bpy.ops.measured_brdf.measure_sample,
            "Drawn Mask: 'line' is not a mask of one spline with three points or more")


def test_what_a_description_says_of_outline_and_brightness_is_in_the_scene(blender, written):
    path, places = written.with_name("outlined.toml"), [[10.0, 10.0], [90.0, 12.0], [50.0, 80.0]]
    numbers = [1 + 0.1 * number for number in range(10)]
    path.write_text(written.read_text("utf-8").replace("[sample]", f"[lamp]\nbrightness = {numbers}\n[sample]\n"
                                                                   f"outline = {places}"), "utf-8")
    settings = open_scene(path)
    assert describe()["lamp"]["brightness"] == pytest.approx(numbers)
    x, y = np.transpose(describe()["sample"]["outline"])
    assert (x.min(), x.max(), y.min(), y.max()) == pytest.approx((10, 90, 10, 80), abs=1e-4)
    settings.photographs[2].used = False
    assert describe()["lamp"]["brightness"] == pytest.approx(numbers[:2] + numbers[3:])
    path.write_text(path.read_text("utf-8").replace(str(numbers), str(numbers[:4])), "utf-8")
    refused(bpy.ops.measured_brdf.measure_sample_photographs, r"lamp.brightness is .*, expected 10 numbers",
            filepath=str(path))


@pytest.mark.parametrize(("spoil", "message"), [
    (lambda settings: setattr(settings, "height", 0.03), r": Corners is .*a rectangle of 0.1 x 0.03 m"),
    (lambda settings: setattr(settings, "matrix", "5"), r": Camera Matrix is 5"),
    (lambda settings: setattr(settings, "scale", "ball"), "Scale: choose the photograph of the card"),
    (lambda settings: setattr(settings.photographs[0].lamp, "location", (0, 0, -1)), "the lamp is behind the sample"),
    (lambda settings: bpy.data.objects.remove(settings.sample), "The sample has been deleted"),
])
def test_what_is_wrong_is_said_in_the_words_of_the_panel_and_changes_nothing(opened, spoil, message):
    spoil(opened)
    refused(bpy.ops.measured_brdf.measure_sample, message)


def test_what_the_panel_says_otherwise_is_said_by_the_fitter(extension):
    """Each key of the table is in a message, or is a key of a description."""
    from measured_brdf.addon.photographs import work

    sources = re.sub(r'"\n\s*f?"', "", "".join(path.read_text("utf-8") for room in ("imaging", "photographs")
                                          for path in (ROOT / "fitter" / room).rglob("*.py")))   # texts of two lines
    assert "set Values to Linear" in work.translate_keys(fitter.imaging.picture_files.BENT)
    for key in work._IN_PANEL:
        parts = key.split(".") if key.startswith(("camera", "sample", "scale", "chrome")) else [key.replace('"', '\\"')]
        assert all(part in sources for part in parts), key


def test_the_panel_of_a_sample_has_its_fields(opened):
    from measured_brdf.addon.photographs import panel

    fields = draw(panel.MEASUREDBRDF_PT_photographs_sample).fields
    assert {"width", "height", "drawn_corners", "corners", "mask", "drawn_outline", "texels", "tile", "count",
            "first"} <= {*fields}
    assert "finds_brightness" in draw(panel.MEASUREDBRDF_PT_photographs_stage).fields
    assert "normal" not in draw(panel.MEASUREDBRDF_PT_photographs_scale).fields
    draw(panel.MEASUREDBRDF_PT_photographs)
    opened.drawn_corners = draw_mask("corners", flat_files.corners())
    assert "corners" not in draw(panel.MEASUREDBRDF_PT_photographs_sample).fields
    opened.first = stage.material_for(fitter.fit(fitter.load_published("pvc"), **fitter.PRESETS["Draft"]))
    assert "second" in draw(panel.MEASUREDBRDF_PT_photographs_sample).fields


def test_photographs_are_measured_in_the_colours_of_the_open_file(extension, random):
    """What they show under a white lamp, pixel by pixel; what does not count still does not."""
    fitter, work = extension.fitter, extension.addon.photographs.work
    shown, mask = random.uniform(0.1, 1, (4, 5, 3)), random.random((4, 5)) < 0.7
    shot = fitter.FlatPhotograph(shown, flat_scene.rays((4, 5)), flat_scene.CAMERA, LAMPS[0], flat_scene.INTENSITY,
                                 0.01 * shown, mask)
    found, matrix = work._convert_colours(shot, "Rec.2020"), fitter.colours.conversion("Rec.709", "Rec.2020")
    np.testing.assert_array_equal(found.mask, mask)
    white = shown[2, 3] / flat_scene.INTENSITY
    np.testing.assert_allclose(found.radiance[2, 3], [sum(row * white) for row in matrix])
    np.testing.assert_allclose(found.noise[2, 3], [0.01 * np.hypot.reduce(row * white) for row in matrix])
    assert found.intensity.tolist() == [1, 1, 1]
