"""Match a Photograph: the nearest materials of the library, in a row above it."""

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import node_group
from measured_brdf.addon.core.storage import edits
from measured_brdf.addon.starter import panel, shelf

from fitter import Fit, edited
from fitter.imaging import studio
from fitter.imaging.pictures import sphere
from fitter.model import published
from support.ball_files import write_picture
from support.blend_state import state
from support.drawn import draw


@pytest.fixture
def photograph(openimageio, tmp_path):
    """A green latex ball in the studio of thumbnails, as a file of linear values."""
    normal, inside, _ = sphere(100)
    picture = np.full((100, 100, 3), 0.05, np.float32)
    picture[inside] = 0.3 * studio.on_sphere(published.find("green-latex").model, normal)
    pixels = picture[::-1][2:98, 2:98]                  # the outline touches the edges
    path = tmp_path / "ball.exr"
    import OpenImageIO

    file = OpenImageIO.ImageOutput.create(str(path))
    file.open(str(path), OpenImageIO.ImageSpec(96, 96, 3, "float"))
    file.write_image(np.ascontiguousarray(pixels))
    file.close()
    return path


def test_the_nearest_materials_appear_in_a_row_and_are_told(extension, photograph, capfd):
    assert bpy.ops.measured_brdf.match_photograph(filepath=str(photograph), window="LEFT") == {"FINISHED"}
    assert shelf.nearest[0].material.name == "green-latex"
    assert "Green latex: difference" in capfd.readouterr().out
    choices = bpy.context.window_manager.measured_brdf_shelf
    choices.search = "unobtainium"
    shown = draw(panel.MEASUREDBRDF_PT_library)
    assert shown.kinds.count("picture") == 5
    first = next(vars(entry[4]) for entry in shown.drawn if entry[0] == "button" and "diffuse" in vars(entry[4]))
    assert first["name"] == "green-latex"
    assert first["note"].startswith("Green latex: difference")
    choices.property_unset("search")
    shelf.nearest.clear()


def test_none_is_near_to_noise_and_nothing_changes(extension, photograph, random, capfd):
    path, before = photograph.with_name("noise.exr"), state()
    write_picture(path, random.random((96, 96, 3)))
    shelf.nearest.clear()
    with pytest.raises(RuntimeError, match=r"noise\.exr: none is near: no outline of a ball"):
        bpy.ops.measured_brdf.match_photograph(filepath=str(path))
    assert shelf.nearest == []
    assert state() == before


def test_one_click_applies_a_material_and_its_adjustment(blender, quick):
    bpy.ops.mesh.primitive_cube_add()
    diffuse, highlight = (0.5, 1.25, 2.0), (0.75, 0.75, 0.75)
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    plain = bpy.context.object.active_material
    assert bpy.ops.measured_brdf.use_published(name="red-plastic", diffuse=diffuse, highlight=highlight) == {"FINISHED"}
    item = bpy.context.object.active_material
    assert item != plain
    assert edits.is_as_wanted(item), "sliders and shader are one"
    settings = item.measured_brdf_adjustments
    assert np.array(settings.diffuse_tint) * settings.diffuse_gain == pytest.approx(diffuse)
    assert settings.highlight_gain == pytest.approx(0.75)
    fits = [Fit.from_bytes(node_group.kept_fit(materials.group_node(each).node_tree)) for each in (plain, item)]
    at = np.full(20, 0.5), np.zeros(20), np.linspace(0, 1.3, 20), np.full(20, 3.0)
    wanted = edited(fits[0], diffuse=diffuse, highlight=0.75).evaluate(*at)
    np.testing.assert_allclose(fits[1].evaluate(*at), wanted, rtol=1e-4, atol=1e-6)


def test_a_file_that_is_no_picture_is_refused_and_nothing_changes(extension, openimageio, tmp_path):
    path = tmp_path / "no.png"
    path.write_bytes(b"no picture")
    before = state()
    with pytest.raises(RuntimeError, match=r"no\.png"):
        bpy.ops.measured_brdf.match_photograph(filepath=str(path))
    assert state() == before
