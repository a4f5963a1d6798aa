"""Images of measured materials for programs that know no measurements: against what made them, and against Cycles."""

import re

import bpy
import numpy as np
import pytest
from measured_brdf.addon.baking import operators

import fitter
from fitter.colours import decode_srgb
from fitter.cycles.principled_bsdf import Principled
from support.stage import black_scene, render

METAL = Principled(np.array([0.8, 0.5, 0.2]), 0.4, 1.0, 0.5)
KINDS = ("Base_Color", "Roughness", "Metallic", "Normal")
MASK = np.kron(np.array([[0.0, 1.0], [0.5, 0.25]]), np.ones((4, 4)))[..., None] * np.ones(3)
EIGHT_BITS = 0.006          # of linear values that were stored in 8 bits of sRGB


@pytest.fixture
def baked(blender, quick, capfd):
    """Bakes the active material: its pictures by kind, linear, the bottom row first; and what was said."""
    def bake(**options):
        capfd.readouterr()
        assert bpy.ops.measured_brdf.bake_pbr(**options) == {"FINISHED"}
        name = bpy.path.clean_name(bpy.context.object.active_material.name)
        return {kind: texels(bpy.data.images[f"{name}_{kind}"]) for kind in KINDS}, capfd.readouterr().out

    bpy.ops.mesh.primitive_plane_add()
    return bake


def texels(image):
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, 4)[..., :3]
    return decode_srgb(pixels) if image.colorspace_settings.name == "sRGB" else pixels


def measured(model, path, write_astm):
    """A material of samples of a model."""
    theta_i, theta_o, phi = (grid.ravel() for grid in np.meshgrid(
        np.radians(np.arange(0, 81, 10)), np.radians(np.arange(0, 81, 5)), np.radians(np.arange(0, 181, 10))))
    values = model.evaluate(theta_i, 0 * phi, theta_o, phi)
    samples = fitter.Samples(theta_i, 0 * phi, theta_o, phi, values, ("R", "G", "B"), "made")
    bpy.ops.measured_brdf.import_data(filepath=str(write_astm(path, samples)), preset="Standard")
    return bpy.context.object.active_material


def find_tangent_node(material):
    return next(node for node in material.node_tree.nodes if node.type == "GROUP")


def image_node(tree, pixels):
    image = bpy.data.images.new("picture", *pixels.shape[1::-1], is_data=True)
    image.pixels.foreach_set(np.insert(pixels, 3, 1, axis=2).astype(np.float32).ravel())
    image.pack()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def steps(said):
    """What is told of the distance from the measurement: the mean, and the most."""
    numbers = [float(number) for number in re.findall(r"\d+\.\d", said[said.index("On a sphere"):].split(":")[0])]
    return numbers[0], numbers[-1]


def test_a_metal_comes_back_as_it_was_made_and_a_second_bake_takes_the_place_of_the_first(baked, tmp_path, write_astm):
    material = measured(METAL, tmp_path / "metal.astm", write_astm)
    pictures, said = baked(size=8)
    assert {picture.shape for picture in pictures.values()} == {(8, 8, 3)}
    np.testing.assert_allclose(pictures["Base_Color"], np.broadcast_to(METAL.base_color, (8, 8, 3)), atol=0.03)
    np.testing.assert_allclose(pictures["Roughness"], METAL.roughness, atol=0.03)
    np.testing.assert_allclose(pictures["Metallic"], 1, atol=0.03)
    np.testing.assert_allclose(pictures["Normal"], np.broadcast_to([0.5, 0.5, 1], (8, 8, 3)), atol=0.003)
    assert steps(said)[0] < 1.5
    assert "WARNING" not in said.upper()
    images = {image.name for image in bpy.data.images}
    used = material.node_tree.nodes.new("ShaderNodeTexImage")
    used.image = bpy.data.images["made_Roughness"]
    baked(size=4)
    assert {image.name for image in bpy.data.images} == images
    assert used.image.name == "made_Roughness"
    assert tuple(used.image.size) == (4, 4)
    assert used.image.packed_file is not None


def test_what_images_cannot_hold_is_told_as_a_distance(baked, tmp_path, write_astm):
    """A velvet, whose sheen no image has."""
    velvet = Principled(np.array([0.02, 0.01, 0.01]), 0.9, 0.0, 0.0, np.array([0.9, 0.3, 0.3]), 0.4)
    measured(velvet, tmp_path / "velvet.astm", write_astm)
    _, said = baked(size=1)
    assert steps(said)[0] > 2
    assert ": excellent" not in said


def test_tint_and_the_mask_of_a_mix_vary_over_the_images(baked):
    parts = []
    for name in ("red-fabric", "chrome"):
        bpy.ops.measured_brdf.use_published(name=name)
        parts.append(baked(size=1))
    mask = image_node(bpy.context.object.active_material.node_tree, MASK).image
    bpy.ops.measured_brdf.mix(first="Red fabric", second="Chrome", mask=mask.name)
    mixed = bpy.data.materials["Red fabric + Chrome"]
    bpy.context.object.material_slots[0].material = mixed
    find_tangent_node(mixed).inputs["Tint"].default_value = (1.0, 0.5, 0.25, 1.0)
    pictures, said = baked(size=16)
    share = np.kron(MASK, np.ones((2, 2, 1)))
    for kind, factor in (("Base_Color", [1.0, 0.5, 0.25]), ("Roughness", 1.0), ("Metallic", 1.0)):
        below, above = (each[kind][0, 0] for each, _ in parts)
        np.testing.assert_allclose(pictures[kind], ((1 - share) * below + share * above) * factor, atol=2 * EIGHT_BITS)
    mean, most = steps(said)
    assert mean < most
    # where the mask is black or white there is one of both materials
    assert most >= max(steps(alone)[0] for _, alone in parts) * 0.5


def test_the_normals_are_those_that_cycles_makes_of_the_normal_map_and_its_strength(baked, tmp_path, write_astm):
    material = measured(METAL, tmp_path / "metal.astm", write_astm)
    tree, random = material.node_tree, np.random.default_rng(5)
    bumps = np.kron(0.5 + 0.5 * np.concatenate([random.uniform(-0.5, 0.5, (4, 4, 2)), np.full((4, 4, 1), 0.8)], axis=2),
                    np.ones((4, 4, 1)))
    source, normal = image_node(tree, bumps), tree.nodes.new("ShaderNodeNormalMap")
    normal.inputs["Strength"].default_value = 0.6
    tree.links.new(source.outputs["Color"], normal.inputs["Color"])
    tree.links.new(normal.outputs["Normal"], find_tangent_node(material).inputs["Normal"])
    pictures, _ = baked(size=16)

    def rendered(image, strength):
        """What Cycles shows of the normal as a colour, on a plane."""
        scene = black_scene(16, 16, samples=4, span=2)
        bpy.ops.mesh.primitive_plane_add()
        made = bpy.data.materials.new("normals")
        if bpy.app.version < (5, 0, 0):
            made.use_nodes = True
        nodes, links = made.node_tree.nodes, made.node_tree.links
        nodes.clear()
        there, glow, end = image_node(made.node_tree, image), nodes.new("ShaderNodeEmission"), nodes.new(
            "ShaderNodeOutputMaterial")
        bump, scaled = nodes.new("ShaderNodeNormalMap"), nodes.new("ShaderNodeVectorMath")
        there.interpolation = "Closest"
        bump.inputs["Strength"].default_value = strength
        scaled.operation, scaled.inputs[1].default_value, scaled.inputs[2].default_value = (
            "MULTIPLY_ADD", (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
        for one, other in ((there.outputs["Color"], bump.inputs["Color"]), (bump.outputs[0], scaled.inputs[0]),
                           (scaled.outputs[0], glow.inputs["Color"]), (glow.outputs[0], end.inputs["Surface"])):
            links.new(one, other)
        bpy.context.object.data.materials.append(made)
        return render(scene)[..., :3]

    expected = rendered(bumps, 0.6)
    assert np.ptp(expected[..., 0]) > 0.1
    np.testing.assert_allclose(rendered(pictures["Normal"], 1.0), expected, atol=0.006)


def test_images_are_written_into_a_folder_all_or_none(baked, tmp_path, write_astm):
    measured(METAL, tmp_path / "metal.astm", write_astm)
    before = {image.name for image in bpy.data.images}
    with pytest.raises(RuntimeError, match="no such folder"):
        bpy.ops.measured_brdf.bake_pbr(size=4, directory=str(tmp_path / "nowhere"))
    assert {image.name for image in bpy.data.images} == before
    (tmp_path / "images").mkdir()
    pictures, said = baked(size=4, directory=str(tmp_path / "images"))
    assert {path.name for path in (tmp_path / "images").iterdir()} == {f"made_{kind}.png" for kind in KINDS}
    for kind in KINDS:
        image = bpy.data.images.load(str(tmp_path / "images" / f"made_{kind}.png"))
        image.colorspace_settings.name = "sRGB" if kind == "Base_Color" else "Non-Color"
        np.testing.assert_allclose(texels(image), pictures[kind], atol=1e-6)
        assert f"made_{kind}.png" in said


def test_a_failure_while_writing_leaves_nothing(baked, tmp_path, write_astm, monkeypatch):
    measured(METAL, tmp_path / "metal.astm", write_astm)
    (folder := tmp_path / "images").mkdir()
    names = {image.name for image in bpy.data.images}

    def full(*_paths):
        raise OSError("no space left")

    monkeypatch.setattr(operators.os, "replace", full)
    with pytest.raises(RuntimeError, match="no space left"):
        bpy.ops.measured_brdf.bake_pbr(size=4, directory=str(folder))
    assert list(folder.iterdir()) == []
    assert {image.name for image in bpy.data.images} == names


def test_what_is_lost_is_told_and_what_is_not_measured_cannot_be_baked(baked, tmp_path, write_astm):
    material = measured(METAL, tmp_path / "metal.astm", write_astm)
    noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
    material.node_tree.links.new(noise.outputs[0], find_tangent_node(material).inputs["Tint"])
    _, said = baked(size=2)
    assert "made: Tint: a constant, an image or their product" in said
    material.node_tree.nodes.remove(material.node_tree.nodes["Measured BRDF Export"])
    with pytest.raises(RuntimeError, match="has no exported surface"):
        bpy.ops.measured_brdf.bake_pbr(size=2)
    bpy.context.object.active_material = bpy.data.materials.new("plain")
    assert not bpy.ops.measured_brdf.bake_pbr.poll()
