"""The scenes in which materials are looked at: shapes, light and progress."""

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import look, tangents
from measured_brdf.fitter import progress

import fitter
from fitter.quality.physics import directional_albedo


def closed(mesh):
    """Whether each edge of a mesh has two faces."""
    import bmesh  # which is there once bpy is

    shape = bmesh.new()
    shape.from_mesh(mesh)
    is_closed = all(len(edge.link_faces) == 2 for edge in shape.edges)
    shape.free()
    return is_closed


def places(mesh):
    return np.array([vertex.co for vertex in mesh.vertices])


def test_the_ball_has_a_groove_and_is_turned_about_its_axis(blender):
    mesh = look._lathe(look._ball_profile())
    at = places(mesh)
    radius, polar = np.linalg.norm(at, axis=1), np.degrees(np.arccos(at[:, 2] / np.linalg.norm(at, axis=1)))
    assert radius[np.abs(polar - 58) < 0.6].mean() == pytest.approx(0.94, abs=0.002)
    assert np.abs(radius[(polar < 50) | (polar > 66)] - 1).max() < 1e-6
    assert closed(mesh)
    assert tangents.is_turned(mesh)
    assert tangents.has_uv(mesh)


def test_the_stand_is_on_the_floor_and_reaches_into_the_ball(blender):
    at = places(look._lathe(look._stand_profile()))
    assert at[:, 2].min() == 0
    top = at[np.argmax(at[:, 2])]
    assert np.linalg.norm(top - (0, 0, look._BALL_AT)) < 1


@pytest.mark.parametrize(("shape", "lighting", "meshes", "lamps"), [
    ("SPHERE", "STUDIO", 2, 3), ("BALL", "STUDIO", 3, 3), ("BALL", "SKY", 3, 0), ("SPHERE", "WORLD", 1, 0)])
def test_each_scene_has_its_parts(blender, shape, lighting, meshes, lamps):
    scene = look.scene_for(shape, lighting, bpy.data.worlds.new("mine"), 32, 4)
    kinds = [item.type for item in scene.objects]
    assert (kinds.count("MESH"), kinds.count("LIGHT"), kinds.count("CAMERA")) == (meshes, lamps, 1)
    assert (scene.world.name == "mine") == (lighting == "WORLD")
    tree = scene.world.node_tree            # none in Blender 4.2 where nobody has asked for it
    sky = [node for node in tree.nodes if node.type == "TEX_SKY"] if tree else []
    assert len(sky) == (lighting == "SKY")


def test_in_even_light_a_surface_seen_head_on_shows_its_albedo(blender, quick, glossy, write_astm, tmp_path):
    """A furnace: the picture comes from Cycles, the albedo from an integral over the fit."""
    path = write_astm(tmp_path / "glossy.astm", glossy)
    bpy.ops.measured_brdf.import_data(filepath=str(path), diffuse_level=3, specular_level=5, compression=80)
    world = bpy.data.worlds.new("even")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    scene, reports = look.scene_for("SPHERE", "WORLD", world, 33, 256), []
    scene.view_settings.view_transform = "Standard"
    with progress.listen(lambda fraction, doing: reports.append(fraction)):
        picture = look.render(scene, bpy.data.materials["glossy"], tmp_path / "picture.png")
    encoded = picture[12:20, 14:19, :3].mean(axis=(0, 1))
    shown = np.where(encoded > 0.04045, ((encoded + 0.055) / 1.055) ** 2.4, encoded / 12.92)
    fit = fitter.fit(fitter.load(path), 3, 5, 80.0, method="mba")
    np.testing.assert_allclose(shown, directional_albedo(fit, [np.radians(10)])[0], rtol=0.06)
    assert picture[0, 0, :3].min() > 0.99, "the world is seen beside the sphere"
    assert reports[0] == 0 < reports[-1] <= 1
    assert not [image for image in bpy.data.images if image.name == "picture.png"]
