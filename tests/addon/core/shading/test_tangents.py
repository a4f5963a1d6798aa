"""The check of where the direction of an anisotropic material comes from, and its fix."""

import pytest
from measured_brdf.addon.core import checks
from measured_brdf.addon.core.shading import tangents
from measured_brdf.addon.core.shading.material import tangent_input

import fitter
from support.anisotropic import brushed_fit
from support.stage import black_scene, material_for


@pytest.fixture
def material(blender):
    black_scene(8, 8, 1, 1)
    return material_for(brushed_fit())


def show(blender, shape, material, **options):
    getattr(blender.ops.mesh, f"primitive_{shape}_add")(**options)
    blender.context.object.data.materials.append(material)
    return blender.context.object


def findings(blender):
    return [finding for finding in checks.check(blender.context.scene) if finding.key.startswith("tangent:")]


def tangent(material):
    return tangent_input(material)


@pytest.mark.parametrize(("shape", "turned"), [
    ("uv_sphere", True), ("cylinder", True), ("cone", True), ("torus", True), ("circle", True), ("ico_sphere", True),
    ("plane", False), ("grid", False), ("cube", False), ("monkey", False)])
def test_the_direction_around_the_axis_suits_turned_parts_only(blender, material, shape, turned):
    item = show(blender, shape, material, **({"fill_type": "NGON"} if shape == "circle" else {}))
    assert len(findings(blender)) == (not turned)
    item.location, item.rotation_euler, item.scale = (3, 2, 1), (1, 2, 3), (0.2, 0.2, 5)
    blender.context.view_layer.update()
    assert len(findings(blender)) == (not turned)


def test_the_fix_takes_the_tangent_of_the_uv_map_and_then_there_is_nothing_to_fix(blender, material):
    show(blender, "monkey", material)
    finding, = findings(blender)
    assert finding.change == "Use the UV map's tangent"
    assert blender.ops.measured_brdf.fix_setting(key=finding.key) == {"FINISHED"}
    node = tangent(material).links[0].from_node
    assert (node.type, node.direction_type, node.uv_map) == ("TANGENT", "UV_MAP", "")
    assert findings(blender) == []


def test_without_a_uv_map_of_any_area_there_is_a_hint_and_no_fix(blender, material):
    mesh = show(blender, "cube", material).data
    for corner in mesh.uv_layers[0].uv:
        corner.vector = (0.5, 0.5)
    finding, = findings(blender)
    assert (finding.fix, "has no area: unwrap it" in finding.message) == (None, True)
    mesh.uv_layers.remove(mesh.uv_layers[0])
    finding, = findings(blender)
    assert (finding.fix, "is missing: unwrap it" in finding.message) == (None, True)


@pytest.mark.parametrize("name", ["", "Another"])
def test_a_tangent_node_of_a_uv_map_that_is_not_there_is_found(blender, material, name):
    mesh = show(blender, "uv_sphere", material).data
    tangents.take_from_uv(material)
    node = tangent(material).links[0].from_node
    node.uv_map = name
    if not name:
        assert findings(blender) == []
        mesh.uv_layers.remove(mesh.uv_layers[0])
    finding, = findings(blender)
    assert finding.change == "Use the tangent around the Z axis"
    assert blender.ops.measured_brdf.fix_setting(key=finding.key) == {"FINISHED"}
    assert not tangent(material).is_linked
    assert findings(blender) == []


def test_a_direction_from_elsewhere_is_left_to_who_made_it(blender, material):
    show(blender, "cube", material)
    node = material.node_tree.nodes.new("ShaderNodeCombineXYZ")
    material.node_tree.links.new(node.outputs[0], tangent(material))
    assert findings(blender) == []


def test_meshes_that_modifiers_make_or_that_are_edited_are_not_judged(blender, material):
    item = show(blender, "cube", material)
    modifier = item.modifiers.new("Lathe", "SCREW")
    assert findings(blender) == []
    item.modifiers.remove(modifier)
    assert len(findings(blender)) == 1
    blender.ops.object.mode_set(mode="EDIT")
    assert findings(blender) == []
    blender.ops.object.mode_set(mode="OBJECT")


def test_isotropic_materials_have_no_direction_to_check(blender, glossy):
    black_scene(8, 8, 1, 1)
    material = material_for(fitter.fit(glossy, 2, None))
    show(blender, "cube", material)
    assert tangent(material) is None
    assert findings(blender) == []
