"""How a material is rendered, and what is said of it, by engine, device and choice."""

import subprocess
import sys

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core import checks
from measured_brdf.addon.core.blender import device as devices
from measured_brdf.addon.core.blender import osl_support
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import rendered
from measured_brdf.addon.core.shading.rendered import Rendered, rendering_words, sentence

from support.cases import quick, release
from support.checkout import ROOT
from support.stage import EEVEE, add_sphere, background, black_scene, group_node, render


@pytest.fixture
def scene(blender):
    scene = black_scene(24, 24, 16, span=2.1)
    background(scene, 1)
    return scene


@pytest.fixture
def imported(scene, write_astm, glossy, tmp_path):
    """Import the glossy measurement onto a sphere with a choice of rendering: its material."""
    path = tmp_path / "glossy.astm"
    write_astm(path, glossy)

    def make(rendering=None):
        add_sphere()
        given = {} if rendering is None else {"rendering": rendering}
        assert bpy.ops.measured_brdf.import_data(filepath=str(path), preset="Draft", **given) == {"FINISHED"}
        return bpy.context.object.active_material
    return make


def how(material):
    return rendered.scene_rendering(material, bpy.context.scene)


def findings():
    return {finding.key: finding for finding in checks.check(bpy.context.scene)}


def mean():
    return float(render(bpy.context.scene)[..., :3].mean())


def test_automatic_is_exact_with_osl_and_nodes_without(scene, imported):
    material = imported()
    assert material.measured_brdf.rendering == "AUTO"
    assert how(material)[:3] == ("EXACT", 0.0, 0.0)
    exact = mean()
    scene.cycles.shading_system = False
    found = how(material)
    assert found.how == "NODES"
    assert found.why == "OSL is off"
    assert found.can_enable
    assert mean() == pytest.approx(exact, rel=0.03), "nothing else had to be changed, and the light is the same"
    assert "osl" not in findings(), "that is what was chosen"


def test_what_needs_osl_is_told_where_it_is_off_and_has_a_fix(scene, imported):
    material = imported("EXACT")
    assert how(material).how == "EXACT"
    assert "osl" not in findings()
    scene.cycles.shading_system = False
    assert how(material).how == "NODES"
    assert "OSL is off" in findings()["osl"].message
    assert bpy.ops.measured_brdf.fix_setting(key="osl") == {"FINISHED"}
    assert how(material).how == "EXACT"


def test_nodes_are_shown_with_osl_too_where_they_are_chosen(scene, imported):
    material = imported("NODES")
    found = how(material)
    assert found.how == "NODES"
    assert found.why == ""
    assert 0 < found.error <= found.worst
    with_osl = render(scene)
    scene.cycles.shading_system = False
    np.testing.assert_allclose(render(scene), with_osl, atol=0.02)


@pytest.mark.parametrize("choice", quick(["AUTO", "EXACT", "NODES"], "EXACT", "NODES"))
def test_a_choice_can_be_changed_and_outlives_a_refit(scene, imported, choice):
    material = imported("EXACT" if choice == "NODES" else "NODES")
    assert bpy.ops.measured_brdf.use_method(method=choice) == {"FINISHED"}
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    assert materials.get_rendering(material) == choice


@pytest.mark.parametrize("device", quick(["HIP", "METAL", "ONEAPI", "CUDA"], "METAL"))
def test_a_device_without_osl_is_named_and_rendered_by_nodes(scene, imported, monkeypatch, device):
    material = imported("EXACT")
    monkeypatch.setattr(devices, "effective_device", lambda scene: "CPU" if scene.cycles.device == "CPU" else device)
    scene.cycles.device = "GPU"
    found = how(material)
    assert found.how == "NODES"
    assert device in found.why
    assert not found.can_enable
    assert device in findings()["osl"].message
    assert bpy.ops.measured_brdf.fix_setting(key="osl") == {"FINISHED"}
    assert scene.cycles.device == "CPU"
    assert how(material).how == "EXACT"


def test_osl_on_optix_is_told_to_be_untested(scene, imported, monkeypatch):
    material = imported()
    monkeypatch.setattr(devices, "effective_device", lambda scene: "OPTIX")
    assert how(material).how == "EXACT"
    assert "not been tested" in findings()["optix"].message
    assert bpy.ops.measured_brdf.fix_setting(key="optix") == {"FINISHED"}
    assert how(material).how == "NODES"
    assert "optix" not in findings()


def test_eevee_has_its_own_nodes_and_error(scene, imported):
    material = imported()
    scene.render.engine = EEVEE
    found = how(material)
    assert found.how == "NODES"
    assert found.why == "the engine is EEVEE"
    tree = group_node(material).node_tree
    assert (found.error, found.worst) == (tree["eevee_error"], tree["eevee_worst"])
    output = material.node_tree.get_output_node("EEVEE")
    assert output.inputs["Surface"].links[0].from_socket.name == "EEVEE"
    assert material.node_tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_socket.name == "BSDF"


def test_a_surface_that_the_user_mixes_keeps_one_output_for_all(scene, imported):
    material = imported()
    tree = material.node_tree
    for node in [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL"]:
        tree.nodes.remove(node)
    mix, output = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(group_node(material).outputs["BSDF"], mix.inputs[1])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    assert [node.target for node in tree.nodes if node.type == "OUTPUT_MATERIAL"] == ["ALL"]
    assert output.inputs["Surface"].links[0].from_node == mix


def test_an_output_that_shows_something_else_is_reported(scene, imported):
    material = imported()
    output = material.node_tree.get_output_node("CYCLES")
    assert how(material).how == "EXACT"
    output.target = "ALL"                   # so that the exported surface may be the one that is rendered
    shown = material.node_tree.get_output_node("CYCLES")
    if shown != output:
        assert how(material).how == "OTHER"
        assert any(key.startswith("output:") for key in findings())
        shown.is_active_output, output.is_active_output = False, True
    assert how(material).how == "EXACT"
    output.target = "CYCLES"
    material.node_tree.links.remove(output.inputs["Surface"].links[0])
    assert how(material).how == "OTHER"
    assert any(key.startswith("output:") for key in findings())


def test_a_render_without_a_window_says_what_it_used(scene, imported, capfd):
    imported()
    render(scene)
    assert "Measured BRDF: 1 exact (Cycles on CPU, with OSL)" in capfd.readouterr().out
    scene.cycles.shading_system = False
    render(scene)
    assert "Measured BRDF: 1 by closure nodes (Cycles on CPU; OSL is off)" in capfd.readouterr().out


def test_the_sentence_names_what_was_chosen_and_why_it_is_not_shown():
    found = Rendered("NODES", 0.05, 0.1, "OSL is off", True)
    assert sentence(found, "EXACT") == (
        "Rendered by nodes instead of Exact, because OSL is off. Highlight Error 5.0% of the light, up to 10.0% at the "
        "worst viewing angle")
    assert sentence(found._replace(why=""), "NODES").startswith("Rendered by nodes. Highlight Error 5.0%")


@pytest.mark.parametrize(("how", "error", "why", "can_enable", "words"), [
    ("EXACT", 0.0, "", False, "Exact"), ("NODES", 0.0051, "", False, "Nodes: within 1 % of the light"),
    ("NODES", 0.0849, "the engine is EEVEE", True, "Nodes: within 9 % of the light"),
    ("NODES", 0.01, "OSL is off", True, "Nodes: OSL is off"),
    ("NODES", 0.01, "its shader is not compiled yet", False, "Nodes: not compiled yet"),
    ("NODES", 0.01, "this Blender was built without OSL", False, "Nodes: no OSL here"),
    ("NODES", 0.01, "Cycles has no OSL on CUDA devices", False, "Nodes: no OSL here"),
    ("OTHER", 1.0, "", False, "Not connected to the output")])
def test_the_rendering_in_four_words(how, error, why, can_enable, words):
    found = Rendered(how, error, error, why, can_enable)
    assert rendering_words(found) == words
    assert rendering_words(found, is_previewed=True) == ("Exact on final renders" if how == "EXACT" else words)


IN_EEVEE = f"""
import sys
sys.path.insert(0, {str(ROOT)!r})
import bpy
import fitter
from support import checkout, stage
checkout.extension().register()
scene = stage.black_scene(48, 48, 16, span=2.1)
stage.background(scene, 1)
stage.add_sphere()
bpy.ops.measured_brdf.import_data(filepath=sys.argv[1], preset="Draft")
scene.cycles.shading_system = False
scene.eevee.taa_render_samples = 16
means = []


def render_in_both():
    for engine in ("CYCLES", {EEVEE!r}):
        scene.render.engine = engine
        means.append(stage.render(scene)[..., :3].mean())


render_in_both()
names = [bpy.context.object.active_material.name]
bpy.ops.measured_brdf.import_data(filepath="published:red-fabric", preset="Draft")
names.append(bpy.context.object.active_material.name)
render_in_both()
bpy.ops.measured_brdf.mix(first=names[0], second=names[1], factor=0.25)
assert bpy.context.object.active_material.name == " + ".join(names)
render_in_both()
print("MEANS", *means)
"""


@release
def test_eevee_shows_about_as_much_light_as_cycles(write_astm, glossy, tmp_path):
    """In a process of its own, which Blender ends where there is no OpenGL."""
    path = tmp_path / "glossy.astm"
    write_astm(path, glossy)
    found = subprocess.run([sys.executable, "-c", IN_EEVEE, str(path)], capture_output=True, text=True, timeout=300,
                           check=False)
    if "MEANS" not in found.stdout and "context" in found.stderr:
        pytest.skip("EEVEE needs OpenGL; on Debian, libegl-mesa0 and libgl1-mesa-dri have it in software")
    assert found.returncode == 0, found.stderr
    cycles, eevee, cycles_of_other, eevee_of_other, mixed_in_cycles, mixed_in_eevee = map(
        float, found.stdout.split("MEANS")[1].split()[:6])
    assert cycles > 0.01
    assert eevee == pytest.approx(cycles, rel=0.1)
    assert abs(cycles_of_other / cycles - 1) > 0.2
    assert mixed_in_cycles == pytest.approx(0.75 * cycles + 0.25 * cycles_of_other, rel=0.02)
    assert mixed_in_eevee == pytest.approx(0.75 * eevee + 0.25 * eevee_of_other, rel=0.02)


def test_an_import_says_in_words_what_it_is_worth_and_how_it_is_rendered(scene, imported, monkeypatch, capfd):
    def told():
        capfd.readouterr()
        imported()
        return next(line for line in capfd.readouterr().out.splitlines() if line.startswith("Info: "))

    exact = told()
    assert "Matches the measurements: " in exact
    assert "coefficients" not in exact
    assert "endered" not in exact, "as was chosen"
    scene.cycles.shading_system = False
    assert told().endswith("Rendered by nodes, because OSL is off, an approximation. Enable OSL in its panel renders "
                           "it exactly")
    scene.render.engine = EEVEE
    assert "Rendered by nodes, because the engine is EEVEE, an approximation. Enable OSL in its panel" in told()
    scene.render.engine = "CYCLES"
    with monkeypatch.context() as patch:
        patch.setattr(devices, "effective_device", lambda scene: "CUDA")
        assert told().endswith("because Cycles has no OSL on CUDA devices, an approximation. The CPU, with OSL on, "
                               "renders it exactly")
    monkeypatch.setattr(osl_support, "reason_unavailable", lambda: "no OSL")
    assert told().endswith("because this Blender was built without OSL, an approximation")


def test_a_choice_is_for_all_groups_of_a_material_and_for_those_inside_of_others(scene, imported):
    assert not bpy.ops.measured_brdf.use_method.poll()
    material = imported()
    tree, first = material.node_tree, group_node(material)
    assert not first.inputs["Nodes"].default_value
    second = tree.nodes.new("ShaderNodeGroup")
    second.node_tree = first.node_tree
    outer = bpy.data.node_groups.new("mine", "ShaderNodeTree")
    inner = outer.nodes.new("ShaderNodeGroup")
    inner.node_tree = first.node_tree
    tree.nodes.new("ShaderNodeGroup").node_tree = outer
    tree.nodes.new("ShaderNodeGroup")           # of no tree
    for choice, nodes in (("NODES", True), ("EXACT", False)):
        assert bpy.ops.measured_brdf.use_method(method=choice) == {"FINISHED"}
        assert [node.inputs["Nodes"].default_value for node in (first, second, inner)] == [nodes] * 3


def test_a_script_that_names_fast_gets_nodes(scene, imported):
    material = imported("FAST")
    assert material.measured_brdf.rendering == materials.get_rendering(material) == "NODES"
    assert material.measured_brdf.bl_rna.properties["rendering"].enum_items["FAST"].value > 2, "the others keep theirs"


def test_exact_everywhere_is_off_until_somebody_validates(scene, imported):
    material = imported()
    node = group_node(material)
    assert not node.inputs["Exact Everywhere"].default_value
    script = node.node_tree.nodes["Measured BRDF Shader"]
    assert script.inputs["Everywhere"].links[0].from_socket.name == "Exact Everywhere"
    node.inputs["Exact Everywhere"].default_value = True
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    assert node.inputs["Exact Everywhere"].default_value
