"""Flakes: how their normals are distributed, and that a material shows them."""

import math

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import node_group

import fitter
from support import stage

SPREAD, SIZE = 0.2, 0.1
SECTION = 1.458             # cells of a plane through Voronoi cells of random points, one in a unit of volume (Moller)


@pytest.fixture
def plane(blender):
    """A plane of 4 x 4 units, a pixel wide as a hundredth, and its material of felt."""
    scene = stage.black_scene(400, 400, 1, span=4)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    blender.ops.mesh.primitive_plane_add(size=4)
    theta = np.linspace(0, 1.4, 6)
    grey = fitter.Samples(*(each.ravel() for each in np.meshgrid(theta, [0.0], theta, [0.0, 1.5, 3.0], indexing="ij")),
                          np.full((108, 1), 0.1), ("grey",))
    material = blender.data.materials.new("grey")
    materials.use_nodes(material)
    material.node_tree.nodes.clear()
    materials.show(material, node_group.make(fitter.fit(grey, **fitter.PRESETS["Draft"])))
    bpy.context.object.data.materials.append(material)
    return scene, material, materials.surface_node(material)


def normals(scene, material, socket):
    """The normals of all pixels, (pixels, 3): what a socket gives, by an emission that shows it."""
    tree = material.node_tree
    emission, half = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeVectorMath")
    half.operation, half.inputs[1].default_value, half.inputs[2].default_value = "MULTIPLY_ADD", [0.5] * 3, [0.5] * 3
    tree.links.new(socket, half.inputs[0])
    tree.links.new(half.outputs[0], emission.inputs[0])
    output = tree.get_output_node("CYCLES")
    before = output.inputs[0].links[0].from_socket
    tree.links.new(emission.outputs[0], output.inputs[0])
    found = stage.render(scene)[..., :3].reshape(-1, 3) * 2 - 1
    tree.links.new(before, output.inputs[0])
    return found


def test_flakes_are_tilted_evenly_to_all_sides_and_as_large_as_is_said(plane):
    scene, material, node = plane
    assert bpy.ops.measured_brdf.add_flakes() == {"FINISHED"}
    flakes = node.inputs["Normal"].links[0].from_node
    flakes.inputs["Size"].default_value, flakes.inputs["Spread"].default_value = SIZE, SPREAD
    found = normals(scene, material, flakes.outputs["Normal"])
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-5)
    slopes = found[:, :2] / found[:, 2:]
    assert slopes.mean(axis=0) == pytest.approx([0, 0], abs=0.01)
    assert slopes.std(axis=0) == pytest.approx([math.tan(SPREAD) / math.sqrt(3)] * 2, rel=0.06)
    assert np.abs(slopes).max() <= math.tan(SPREAD) / (1 - math.tan(SPREAD)) + 1e-4
    cells = len(np.unique(np.round(found, 4), axis=0))
    assert cells == pytest.approx(SECTION * (4 / SIZE) ** 2, rel=0.25)
    assert not bpy.ops.measured_brdf.add_flakes.poll(), "there are some"


def test_flakes_lie_on_the_normal_map_that_was_connected(plane):
    scene, material, node = plane
    tilted = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
    for socket, value in zip(tilted.inputs, (0.6, 0, 0.8), strict=True):
        socket.default_value = value
    material.node_tree.links.new(tilted.outputs[0], node.inputs["Normal"])
    assert bpy.ops.measured_brdf.add_flakes() == {"FINISHED"}
    flakes = node.inputs["Normal"].links[0].from_node
    flakes.inputs["Spread"].default_value = 0
    found = normals(scene, material, flakes.outputs["Normal"])
    np.testing.assert_allclose(found, np.broadcast_to([0.6, 0, 0.8], found.shape), atol=1e-5)


@pytest.mark.parametrize("osl", [True, False])
def test_a_material_is_as_bright_as_the_tilt_of_its_flakes_makes_it(plane, osl):
    """A nearly Lambertian surface under a sun from 60 degrees: radiance follows the cosine to the flake's normal."""
    scene, material, node = plane
    scene.cycles.shading_system = osl
    angle = math.radians(60)
    stage.add_lamp("SUN", math.pi, rotation=(0, angle, 0), angle=0)
    flat = stage.render(scene)[..., :3].mean()
    assert bpy.ops.measured_brdf.add_flakes() == {"FINISHED"}
    flakes = node.inputs["Normal"].links[0].from_node
    flakes.inputs["Size"].default_value, flakes.inputs["Spread"].default_value = SIZE, SPREAD
    found = normals(scene, material, flakes.outputs["Normal"])
    ratio = stage.render(scene)[..., 1].ravel() / flat
    expected = found @ [math.sin(angle), 0, math.cos(angle)] / math.cos(angle)
    assert np.corrcoef(ratio, expected)[0, 1] > 0.99
    np.testing.assert_allclose(np.median(ratio / expected), 1, atol=0.05)
