"""Mixed measured materials, as Cycles renders them, against integrals of `Mix.evaluate`."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import node_group
from measured_brdf.addon.mix import mix_group
from measured_brdf.addon.work import queries

import fitter
from support.cases import quick, release
from support.stage import add_sphere, black_scene, render
from tests.osl.test_rendering import LIGHTS, SIZE


@pytest.fixture(scope="module")
def fits(curet, cornell):
    return {"felt": fitter.fit(curet("felt"), **fitter.PRESETS["Draft"]),
            "krylon": fitter.fit(cornell("krylon_blue_RGB"), **fitter.PRESETS["Draft"]),
            "leather": fitter.fit(curet("leather"), **fitter.PRESETS["Draft"])}


def measured(name, fit):
    made = bpy.data.materials.new(name)
    if not made.node_tree:
        made.use_nodes = True
    made.node_tree.nodes.clear()
    materials.show(made, node_group.make(fit))
    return made


def mixed(first, second, factor, mask=""):
    assert bpy.ops.measured_brdf.mix(first=first, second=second, factor=factor, mask=mask) == {"FINISHED"}
    return bpy.data.materials[f"{first} + {second}"]


@pytest.fixture
def sphere(blender, fits):
    def make(samples, osl=True, names=("felt", "krylon")):
        scene = black_scene(SIZE, SIZE, samples, span=2)
        scene.cycles.max_bounces = 0
        scene.cycles.shading_system = osl
        for name in names:
            measured(name, fits[name])
        add_sphere()
        return scene
    return make


@pytest.mark.parametrize(("light", "osl", "samples"), quick(
    [("sun", True, 64), ("world", True, 192), ("area lamp", True, 400), ("world", False, 64)],
    ("sun", True, 64), ("world", False, 64)))
def test_a_mix_has_the_light_of_both(sphere, fits, light, osl, samples):
    set_up, integrate, _, tolerance = LIGHTS[light]
    scene = sphere(samples, osl)
    mixed("felt", "krylon", 0.3)
    set_up()
    expected = integrate(fitter.Mix(fits["felt"], fits["krylon"], 0.3))
    ratio = render(scene)[..., :3].mean(axis=(0, 1)) / expected
    assert ratio == pytest.approx([1, 1, 1], abs=tolerance if osl else 0.03)


@release
def test_a_mix_of_a_mix_has_the_light_of_all(sphere, fits):
    set_up, integrate, _, tolerance = LIGHTS["sun"]
    scene = sphere(144, names=fits)
    inner = mixed("felt", "krylon", 0.8)
    next(node for node in inner.node_tree.nodes if node.type == "GROUP").inputs["Factor"].default_value = 0.3
    mixed("leather", "felt + krylon", 0.6)
    set_up()
    expected = integrate(fitter.Mix(fits["leather"], fitter.Mix(fits["felt"], fits["krylon"], 0.3), 0.6))
    ratio = render(scene)[..., :3].mean(axis=(0, 1)) / expected
    assert ratio == pytest.approx([1, 1, 1], abs=tolerance)


@pytest.mark.parametrize(("count", "frugal", "one_at_a_time"), [
    (2, False, False), (2, True, True), (3, False, True)])
def test_one_at_a_time_where_there_is_no_room_for_both(sphere, extension, monkeypatch, count, frugal, one_at_a_time):
    """A sample of one of two, taken at random, is off by half their difference; one of both is not."""
    monkeypatch.setattr(extension.addon.core.lamps, "renders_on_gpu", lambda scene: frugal)
    samples = 16
    scene = sphere(samples, names=("felt", "krylon", "leather")[:count])
    parts = "felt", "krylon"
    if count == 3:
        mixed(*parts, 0.5)
        parts = "leather", "felt + krylon"
    made = mixed(*parts, 0.5)
    LIGHTS["sun"][0]()
    pictures = []
    for material in (made, *(bpy.data.materials[name] for name in parts)):
        bpy.context.object.material_slots[0].material = material
        pictures.append(render(scene)[..., :3])
    both, first, second = pictures
    error = np.sqrt(np.mean((both - (first + second) / 2) ** 2))
    expected = np.sqrt(np.mean((first - second) ** 2)) / 2 / np.sqrt(samples)
    assert error == pytest.approx(expected, rel=0.25) if one_at_a_time else error < expected / 5


@pytest.mark.parametrize("osl", quick([True, False], True))
def test_a_mask_tells_where_each_is_seen(sphere, fits, osl):
    """Black left of the middle, white right of it, in the coordinates of the sphere's map."""
    scene = sphere(16, osl)
    mask = bpy.data.images.new("mask", 2, 1)
    mask.pixels = [0, 0, 0, 1, 1, 1, 1, 1]
    made = mixed("felt", "krylon", 0.5, "mask")
    picture = next(node for node in made.node_tree.nodes if node.type == "TEX_IMAGE")
    picture.interpolation, picture.extension = "Closest", "EXTEND"
    position = made.node_tree.nodes.new("ShaderNodeNewGeometry")
    made.node_tree.links.new(position.outputs["Position"], picture.inputs["Vector"])
    LIGHTS["world"][0]()
    halves = []
    for material in (made, bpy.data.materials["felt"], bpy.data.materials["krylon"]):
        bpy.context.object.material_slots[0].material = material
        halves.append(render(scene)[..., :3])
    middle = SIZE // 4 * 3
    both, felt, krylon = halves
    # the position's x is negative in the left half, which the texture's edge extends, and below 1/2 up to the middle
    np.testing.assert_allclose(both[:, :SIZE // 2].mean(axis=(0, 1)), felt[:, :SIZE // 2].mean(axis=(0, 1)), rtol=0.02)
    np.testing.assert_allclose(both[:, middle + 1:].mean(axis=(0, 1)), krylon[:, middle + 1:].mean(axis=(0, 1)),
                               rtol=0.03)


@pytest.mark.parametrize(("osl", "factor", "alone"), quick(
    [(osl, *case) for osl in (True, False) for case in ((2.5, "krylon"), (-1.5, "felt"))], (True, 2.5, "krylon")))
def test_a_mask_beyond_black_and_white_shows_one_material_as_it_is(sphere, fits, osl, factor, alone):
    scene = sphere(16, osl)
    made = mixed("felt", "krylon", 0.5)
    mask = made.node_tree.nodes.new("ShaderNodeValue")
    mask.outputs[0].default_value = factor
    node = next(node for node in made.node_tree.nodes if node.type == "GROUP")
    made.node_tree.links.new(mask.outputs[0], node.inputs["Factor"])
    set_up, integrate, _, tolerance = LIGHTS["sun"]
    set_up()
    ratio = render(scene)[..., :3].mean(axis=(0, 1)) / integrate(fits[alone])
    assert ratio == pytest.approx([1, 1, 1], abs=tolerance if osl else 0.06)


def test_a_mix_follows_its_materials(sphere, fits):
    sphere(4)
    made = mixed("felt", "krylon", 0.3)
    felt = bpy.data.materials["felt"]
    felt.measured_brdf.coefficients = 1             # as an import leaves it
    felt.measured_brdf_adjustments.diffuse_gain = 0.5
    with bpy.context.temp_override(material=felt):
        assert bpy.ops.measured_brdf.adjust() == {"FINISHED"}
    inner = materials.mix_node(made).node_tree
    assert inner.nodes["First"].node_tree == materials.group_node(felt).node_tree
    assert all(socket.is_linked for socket in inner.nodes["First"].inputs)
    assert len([tree for tree in bpy.data.node_groups if "fit" in tree]) == 2, "the former shader of felt is gone"


def test_a_layer_of_a_mix_of_a_mix_has_the_share_that_its_slider_says(sphere, fits):
    set_up, integrate, _, _ = LIGHTS["world"]
    scene = sphere(64, False, ("felt", "krylon", "leather"))
    mixed("felt", "krylon", 0.5)
    made = mixed("felt + krylon", "leather", 0.3)
    leather, krylon, felt = mix_group.layers(materials.mix_node(made))
    assert [layer.material.name for layer in (leather, krylon, felt)] == ["leather", "krylon", "felt"]
    assert felt.share is None
    krylon.share.default_value = 0.9
    set_up()
    inner = fitter.Mix(fits["felt"], fits["krylon"], 0.9)
    ratio = render(scene)[..., :3].mean(axis=(0, 1)) / integrate(fitter.Mix(inner, fits["leather"], 0.3))
    assert ratio == pytest.approx([1, 1, 1], abs=0.03)
    assert queries.shown_fits(made).first.share == pytest.approx(0.9), "of the picture too"


def test_what_is_set_at_the_nodes_of_both_is_told_to_stay_there(sphere, capfd):
    sphere(4)
    felt, krylon = (bpy.data.materials[name] for name in ("felt", "krylon"))
    nodes = [next(node for node in item.node_tree.nodes if node.type == "GROUP") for item in (felt, krylon)]
    mixed("felt", "krylon", 0.5)
    assert "stays there" not in capfd.readouterr().out
    nodes[0].inputs["Tint"].default_value = (1, 0, 0, 1)
    bump = krylon.node_tree.nodes.new("ShaderNodeBump")
    krylon.node_tree.links.new(bump.outputs[0], nodes[1].inputs["Normal"])
    bpy.ops.measured_brdf.mix(first="felt", second="krylon")
    told = capfd.readouterr().out
    assert "Tint of the node of felt stays there" in told
    assert "Normal of the node of krylon stays there" in told


def test_what_cannot_be_mixed_is_refused(sphere):
    sphere(4)
    before = len(bpy.data.materials), len(bpy.data.node_groups), len(bpy.data.texts)
    for wrong in ({"first": "felt", "second": "nowhere"}, {"first": "felt", "second": "krylon", "mask": "none"}):
        with pytest.raises(RuntimeError, match="is not a"):
            bpy.ops.measured_brdf.mix(**wrong)
    assert before == (len(bpy.data.materials), len(bpy.data.node_groups), len(bpy.data.texts))


@pytest.mark.parametrize(("given", "active", "proposed"), [
    (("", ""), "felt", ("felt", "krylon")), (("", ""), "krylon", ("krylon", "felt")),
    (("", ""), "plain", ("felt", "krylon")), (("krylon", "krylon"), "felt", ("krylon", "felt")),
    (("felt", "gone"), "krylon", ("felt", "krylon"))])
def test_the_dialog_proposes_two_materials_of_which_one_is_active(sphere, extension, given, active, proposed):
    sphere(1)
    bpy.data.materials.new("plain")
    window = SimpleNamespace(invoke_props_dialog=lambda *_, **__: {"RUNNING_MODAL"})
    context = SimpleNamespace(window_manager=window, material=bpy.data.materials[active], object=None)
    dialog = SimpleNamespace(first=given[0], second=given[1])
    assert extension.addon.mix.operators.MEASUREDBRDF_OT_mix.invoke(dialog, context, None) == {"RUNNING_MODAL"}
    assert (dialog.first, dialog.second) == proposed


def test_two_materials_of_one_name_are_not_offered_to_be_mixed(sphere, tmp_path):
    """A linked one may have the name of another."""
    sphere(1, names=("felt",))
    bpy.data.libraries.write(str(tmp_path / "library.blend"), {bpy.data.materials["felt"]})
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, target):
        target.materials = ["felt"]
    assert [item.name for item in bpy.data.materials if item.name == "felt"] == ["felt"] * 2
    assert not bpy.ops.measured_brdf.mix.poll()
