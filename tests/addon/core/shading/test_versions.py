"""A file that this version saved opens, renders, is told to be older by the versions to come, and is brought up to date
from the fit that it carries, without the measurements.

`support.saved_blend` made it. Until there is another version of the shader, the tests call that of the file older.
"""

import math

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core import checks, versions
from measured_brdf.addon.core.shading import material, node_group
from measured_brdf.addon.core.shading.material import group_node
from measured_brdf.addon.core.shading.node_group import kept_fit
from measured_brdf.addon.panel import main

import fitter
from fitter.cycles.bake import SHADER_VERSION
from support.blend_state import state
from support.drawn import draw
from support.saved_blend import INPUTS, NAME, PATH
from support.spheres import normals, reflected
from support.stage import add_lamp, add_sphere, black_scene, render

SUN = math.radians(60)
# the kept fit, at five directions
VALUES = [[0.15432953, 0.12560953, 0.11683817], [0.10985432, 0.08121413, 0.07349601],
          [0.23526509, 0.20966122, 0.19955988], [0.07434572, 0.04769204, 0.0411607],
          [0.12480273, 0.09586104, 0.0877395]]

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="this Blender does not open files of 5.0")


@pytest.fixture
def saved(blender):
    """The material of the file, appended and made older, on a sphere under a sun."""
    black_scene(32, 32, 64, span=2)
    add_lamp("SUN", 1, rotation=(0, -SUN, 0))
    with bpy.data.libraries.load(str(PATH)) as (_, wanted):
        wanted.materials = [NAME]
    material = bpy.data.materials[NAME]
    add_sphere().data.materials.append(material)
    group(material)["shader_version"] = SHADER_VERSION - 1
    bpy.context.view_layer.update()
    return material


def group(material):
    return group_node(material).node_tree


def kept(material):
    return fitter.Fit.from_bytes(kept_fit(group(material)))


def inputs(material):
    """Values and links of the node that users have, without those of renderings."""
    return {socket.name: socket.links[0].from_node.name if socket.is_linked else tuple(socket.default_value)
            if socket.type == "RGBA" else socket.default_value
            for socket in group_node(material).inputs if socket.name not in {"Nodes", "Exact Everywhere"}}


def mean_under_sun(fit):
    """What a picture of the sphere has in the mean: (3,)."""
    n = normals(200)
    toward = np.array([-math.sin(SUN), 0, math.cos(SUN)])
    seen = reflected(fit, n, np.broadcast_to(toward, n.shape)).sum(axis=0) / 200 ** 2
    return seen * INPUTS["Strength"] * INPUTS["Tint"][:3]


def assert_shows(fit, tolerance):
    ratio = render(bpy.context.scene)[..., :3].mean(axis=(0, 1)) / mean_under_sun(fit)
    assert ratio == pytest.approx([1, 1, 1], abs=tolerance)


def findings():
    return {finding.key for finding in checks.check(bpy.context.scene)}


def test_a_file_that_this_version_saved_opens(blender):
    bpy.ops.wm.open_mainfile(filepath=str(PATH))
    material = bpy.data.materials[NAME]
    settings = material.measured_brdf
    assert (settings.version, settings.filepath, settings.name_of_data) == ("0.3.0", "published:pink-felt", NAME)
    assert inputs(material) == INPUTS | {"Normal": "Mine"}
    fit = kept(material)
    directions = np.random.default_rng(3).random((4, 5)) * [[1.5], [6], [1.5], [6]]
    np.testing.assert_allclose(fit.evaluate(*directions), VALUES, atol=1e-8)
    assert (fit.notation, fit.coefficient_count) == (settings.fitted_levels, settings.coefficients)


def test_it_renders_as_it_did_and_is_told_apart(saved):
    assert material.is_outdated(saved)
    saved.measured_brdf.version = "0.0.0"
    assert "version" in findings()
    bpy.context.scene.cycles.shading_system = False
    assert_shows(kept(saved), 0.03)
    assert f"Made by version 0.0.0; this is {versions.CURRENT}" in draw(main.MEASUREDBRDF_PT_material,
                                                                        material=saved).texts


def test_an_update_renders_the_fit_that_the_file_carries(saved):
    before, fit, users = group(saved), kept(saved), inputs(saved)
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert group(saved).name == NAME
    assert before not in list(bpy.data.node_groups)
    assert sum(item.name.startswith("Measured BRDF Lamps") for item in bpy.data.node_groups) == 1
    assert not material.is_outdated(saved)
    assert node_group.version(group(saved)) == SHADER_VERSION
    assert (saved.measured_brdf.version, inputs(saved)) == (versions.CURRENT, users)
    assert "version" not in findings()
    assert kept(saved).to_bytes() == fit.to_bytes()
    assert_shows(fit, 0.01)
    with pytest.raises(RuntimeError, match="are up to date"):
        bpy.ops.measured_brdf.update_materials()


def test_copies_that_share_a_shader_go_on_sharing_it_and_mixes_follow(saved):
    copy = saved.copy()
    assert bpy.ops.measured_brdf.mix(first=saved.name, second=copy.name) == {"FINISHED"}
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert group(copy) == group(saved)
    assert not material.is_outdated(copy)
    mix = material.mix_node(bpy.data.materials[f"{saved.name} + {copy.name}"]).node_tree
    for name in ("First", "Second"):
        assert mix.nodes[name].node_tree == group(saved)
        given = {socket.name: socket.links[0].from_socket.name for socket in mix.nodes[name].inputs if socket.is_linked}
        assert (given["Nodes"], given["Exact Everywhere"]) == ("Nodes", "Exact Everywhere")


def test_a_damaged_fit_is_named_and_its_material_left_alone(saved):
    group(saved)["fit"] = group(saved)["fit"][:-1]
    before = state()
    with pytest.raises(RuntimeError, match=rf"{NAME}: not a fit saved by Measured BRDF.*Refit"):
        bpy.ops.measured_brdf.update_materials()
    assert state() == before
