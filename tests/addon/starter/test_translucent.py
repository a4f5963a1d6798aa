"""Translucent materials in Blender: from the library, mixed, adjusted, exported, and what panels say of them."""

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import export_surface, mixing, rendered
from measured_brdf.addon.panel import rendering
from measured_brdf.addon.starter import shelf

from fitter import Fit
from fitter.model import published
from support.drawn import draw

pytestmark = pytest.mark.usefixtures("quick")


@pytest.fixture
def skin(cube):
    assert bpy.ops.measured_brdf.use_published(name="skin-1") == {"FINISHED"}
    return cube.active_material


def group(material):
    node, = (each for each in material.node_tree.nodes if each.type == "GROUP")
    return node


def shown_reflectance(material):
    return Fit.from_bytes(group(material).node_tree["fit"])


def walks(tree):
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeSubsurfaceScattering"]


def test_a_translucent_material_of_the_library_has_a_walk_for_cycles_and_one_for_eevee(skin):
    below = published.find("skin-1").model.subsurface
    assert skin.name == "Skin 1"
    in_cycles, in_eevee = walks(group(skin).node_tree)
    assert tuple(in_cycles.inputs["Radius"].default_value) == pytest.approx(below.walk.radius)
    assert tuple(in_eevee.inputs["Radius"].default_value) == pytest.approx(below.walk.radius)
    assert group(skin).inputs["Scale"].default_value == 1
    assert skin.diffuse_color[0] > 1.7 * skin.diffuse_color[1]
    bpy.ops.mesh.primitive_cube_add()
    assert bpy.ops.measured_brdf.use_published(name="skin-1") == {"FINISHED"}
    assert bpy.context.object.active_material == skin


def test_what_is_typed_is_a_material_that_can_be_fitted_again(cube):
    name = "translucent; albedo .8 .5 .2; path 2 1 .5; index 1.4; name Wax"
    assert bpy.ops.measured_brdf.use_published(name=name) == {"FINISHED"}
    item = cube.active_material
    assert (item.name, item.measured_brdf.filepath) == ("Wax", f"published:{name}")
    assert len(walks(group(item).node_tree)) == 2
    with pytest.raises(RuntimeError, match="expected scattering and absorption"):
        bpy.ops.measured_brdf.use_published(name="translucent; albedo .8")


def test_coefficients_are_typed_in_a_dialog(cube):
    assert bpy.ops.measured_brdf.translucent_material(label="My marble", index=1.5) == {"FINISHED"}
    marble = published.find("marble").model.subsurface
    fit = shown_reflectance(cube.active_material)
    assert fit.subsurface.albedo == pytest.approx(marble.albedo, rel=1e-4)
    assert cube.active_material.name == "My marble"
    assert bpy.ops.measured_brdf.translucent_material(given="ALBEDO", albedo=(0.5, 0.4, 0.3)) == {"FINISHED"}
    fit = shown_reflectance(cube.active_material)
    assert fit.subsurface.albedo == pytest.approx([0.5, 0.4, 0.3], rel=1e-4)


def test_adjustments_change_what_comes_from_below(skin):
    skin.measured_brdf_adjustments.diffuse_tint = (0.5, 1, 1)
    assert bpy.ops.measured_brdf.adjust() == {"FINISHED"}
    fit = shown_reflectance(skin)
    assert fit.edited_subsurface.albedo == pytest.approx(fit.subsurface.albedo * (0.5, 1, 1))
    assert len(walks(group(skin).node_tree)) == 2


def test_a_mix_has_the_walk_and_its_scale(skin):
    assert bpy.ops.measured_brdf.use_published(name="red-plastic") == {"FINISHED"}
    other = bpy.context.object.active_material
    mixed = mixing.mixes.mix(skin, other, 0.3, None, bpy.context)
    node = group(mixed)
    assert "Scale" in node.inputs
    inside = node.node_tree.nodes["First"]
    assert inside.inputs["Scale"].is_linked
    assert len(walks(inside.node_tree)) == 2


def test_other_programs_get_a_diffuse_surface_and_the_panel_says_so(skin):
    assert "Light below the surface is exported as a diffuse surface of the same albedo" in export_surface.losses(skin)
    base = skin.node_tree.nodes["Measured BRDF Export"].inputs["Base Color"].default_value
    assert np.array(base[:3]) == pytest.approx([0.458, 0.227, 0.125], abs=0.04)
    scene = bpy.context.scene
    for engine, said in (("CYCLES", "a random walk"), ("BLENDER_WORKBENCH", "a diffuse surface of the same albedo")):
        scene.render.engine = engine
        assert said in rendered.subsurface_message(skin, scene)
    scene.render.engine = "CYCLES"
    shown = draw(rendering.MEASUREDBRDF_PT_rendering, material=skin)
    assert "a random walk" in shown.texts
    assert "default_value" in shown.fields


def test_the_library_lists_them_as_a_kind(extension):
    assert "translucent" in shelf.tags()
    assert len(shelf.find_offered("", "translucent")) == 25
    assert [each.name for each in shelf.find_offered("milk skim", shelf.ALL)] == ["skim-milk"]
