"""A spot's normal and tangent, against what Cycles renders there."""

import math

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading.material import tangent_input
from measured_brdf.addon.inspect import surface

from support.anisotropic import brushed_fit
from support.stage import black_scene, material_for, render, set_input


@pytest.fixture
def material(blender):
    scene = black_scene(12, 12, samples=1, span=1)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.camera.data.type, scene.camera.data.lens = "PERSP", 130
    return material_for(brushed_fit())


def show(material, shape, modifier=None, **options):
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(**options)
    item = bpy.context.object
    item.data.materials.append(material)
    bpy.ops.object.shade_smooth()
    item.rotation_euler, item.scale, item.location = (0.9, 0.5, 2.0), (1.1, 0.7, 0.9), (0.1, -0.2, 0.3)
    if modifier:
        added = item.modifiers.new("modifier", modifier)
        if modifier == "SUBSURF":
            added.levels = added.render_levels
    bpy.context.view_layer.update()
    return item


def tangent_node(material, **settings):
    node = material.node_tree.nodes.new("ShaderNodeTangent")
    for name, value in settings.items():
        setattr(node, name, value)
    material.node_tree.links.new(node.outputs["Tangent"], tangent_input(material))


def rendered(material, output):
    """What Cycles has for the output of a node, at the pixels of the object: (12, 12, 3), and whether they are."""
    tree = material.node_tree
    emission = tree.nodes.new("ShaderNodeEmission")
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.125, 0.125, 0.125)
    half.inputs[2].default_value = (0.5, 0.5, 0.5)
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    tree.links.new(output, half.inputs[0])
    tree.links.new(half.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], surface)
    picture = render(bpy.context.scene)
    return (picture[..., :3].astype(float) - 0.5) * 8, picture[..., 3] > 0.5


def compare(item, material, most_degrees, tangent_output=None):
    nodes = material.node_tree.nodes
    geometry = nodes.new("ShaderNodeNewGeometry")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    eye = np.array(bpy.context.scene.camera.location)
    places, there = rendered(material, geometry.outputs["Position"])
    normals, _ = rendered(material, geometry.outputs["Normal"])
    along, _ = rendered(material, tangent_output or geometry.outputs["Tangent"])
    depsgraph = bpy.context.evaluated_depsgraph_get()
    assert there.sum() > 15
    off = []
    for place, normal, tangent in zip(places[there], normals[there], along[there], strict=True):
        toward = (eye - place) / np.linalg.norm(eye - place)
        spot = surface.find_spot(item, depsgraph, eye, -toward)
        assert spot is not None
        assert (spot.item, spot.material) == (item.session_uid, material.session_uid)
        frame = spot.frame(item.matrix_world)
        np.testing.assert_allclose(frame[:3, 3], place, atol=2e-3)
        np.testing.assert_allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3), atol=1e-6)
        np.testing.assert_allclose(frame[:3, 2], normal, atol=5e-3)
        np.testing.assert_allclose(np.cross(frame[:3, 0], frame[:3, 1]), frame[:3, 2], atol=1e-6)
        off.append(np.degrees(np.arccos(np.clip(frame[:3, 0] @ tangent, -1, 1))))
    assert np.max(off) < most_degrees
    return spot


@pytest.mark.parametrize(("shape", "modifier"), [("uv_sphere", None), ("ico_sphere", None), ("cube", "SUBSURF"),
                                                 ("plane", None), ("monkey", "TRIANGULATE")])
def test_the_tangent_around_the_axis_is_that_of_cycles(material, shape, modifier):
    spot = compare(show(material, shape, modifier), material, most_degrees=1)
    assert spot.origin == "around Z"


@pytest.mark.parametrize("axis", "XYZ")
def test_the_tangent_around_another_axis_is_that_of_cycles(material, axis):
    tangent_node(material, direction_type="RADIAL", axis=axis)
    node = next(node for node in material.node_tree.nodes if node.type == "TANGENT")
    spot = compare(show(material, "uv_sphere"), material, 1, node.outputs["Tangent"])
    assert spot.origin == f"around {axis}"


@pytest.mark.parametrize(("shape", "modifier", "most"), [
    ("uv_sphere", None, 1), ("cube", None, 1), ("monkey", "TRIANGULATE", 1),
    ("monkey", None, 15)])      # Blender averages over quads at a vertex, Cycles over triangles
def test_the_tangent_of_a_uv_map_is_that_of_cycles(material, shape, modifier, most):
    tangent_node(material, direction_type="UV_MAP")
    node = next(node for node in material.node_tree.nodes if node.type == "TANGENT")
    spot = compare(show(material, shape, modifier), material, most, node.outputs["Tangent"])
    assert spot.origin == "of the UV map"


def first(item, depsgraph=None):
    return surface.nearest(item, depsgraph or bpy.context.evaluated_depsgraph_get(), (0, 0, 9), np.array([0, 0, 1.0]))


def test_rotation_turns_the_tangent_about_the_normal(material):
    bpy.ops.mesh.primitive_uv_sphere_add()
    item = bpy.context.object
    item.data.materials.append(material)
    frames = []
    for rotation in (0, 0.25):
        set_input(material, "Rotation", rotation)
        frames.append(first(item).frame(item.matrix_world))
    np.testing.assert_allclose(frames[1][:3, 0], frames[0][:3, 1], atol=1e-6)
    np.testing.assert_allclose(frames[1][:3, 2], frames[0][:3, 2], atol=1e-6)


def test_a_face_of_five_corners_has_the_gradient_of_its_uv_map(material):
    tangent_node(material, direction_type="UV_MAP")
    mesh = bpy.data.meshes.new("pentagon")
    corners = [(math.cos(turn), math.sin(turn), 0) for turn in np.arange(5) * 2 * math.pi / 5]
    mesh.from_pydata(corners, [], [range(5)])
    layer = mesh.uv_layers.new(name="turned")
    for loop in range(5):
        x, y, _ = corners[loop]
        layer.uv[loop].vector = (0.6 * x + 0.8 * y, -0.8 * x + 0.6 * y)
    item = bpy.data.objects.new("pentagon", mesh)
    bpy.context.scene.collection.objects.link(item)
    mesh.materials.append(material)
    bpy.context.view_layer.update()
    frame = first(item).frame(item.matrix_world)
    np.testing.assert_allclose(frame[:3, 0], (0.6, 0.8, 0), atol=1e-5)


def test_the_back_of_a_surface_has_its_normal_toward_the_viewer(material):
    bpy.ops.mesh.primitive_plane_add(rotation=(0.3, 0, 0))
    item = bpy.context.object
    item.data.materials.append(material)
    bpy.context.view_layer.update()
    below = surface.find_spot(item, bpy.context.evaluated_depsgraph_get(), np.array([0, 0, -5.0]),
                              np.array([0, 0, 1.0]))
    np.testing.assert_allclose(below.frame(item.matrix_world)[:3, 2], (0, math.sin(0.3), -math.cos(0.3)), atol=1e-6)


def test_the_material_is_that_of_the_face_if_it_is_measured(material):
    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.object
    item.data.materials.append(bpy.data.materials.new("plain"))
    item.data.materials.append(material)
    other = material.copy()
    item.data.materials.append(other)
    item.active_material_index = 1
    for polygon in item.data.polygons:
        polygon.material_index = 2 if polygon.normal.z > 0.5 else 0
    bpy.context.view_layer.update()
    assert first(item).material == other.session_uid
    for polygon in item.data.polygons:
        polygon.material_index = 0
    item.data.update()
    assert first(item).material == material.session_uid


def test_a_scale_of_nothing_is_survived(material):
    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.object
    item.data.materials.append(material)
    spot = first(item)
    assert np.isfinite(spot.frame(np.zeros((4, 4)))).all()
