"""What other programs get of a measured material: exported, and imported again or read as text."""

import json
import re
from types import SimpleNamespace
from urllib.parse import unquote

import bpy
import measured_brdf
import numpy as np
import pytest
from measured_brdf.addon.core.shading import export_surface
from measured_brdf.addon.core.storage.reading import scene_colours
from measured_brdf.addon.panel.fixes import MEASUREDBRDF_PT_export as Panel

from fitter.colours import DEFAULT_COLOURS, conversion, decode_srgb
from fitter.cycles.principled_bsdf import Principled
from support.cases import release
from support.drawn import draw
from support.stage import add_eevee_output, blank_material, group_node

CLOTH = Principled(np.array([0.6, 0.3, 0.1]), 0.45, 0.0, 0.3, np.array([0.5, 0.25, 0.125]), 0.4)
CAR = Principled(np.array([0.8, 0.5, 0.2]), 0.55, 1.0, 0.5, coat_weight=0.7, coat_roughness=0.15)
FIT = {"cloth": CLOTH, "car": CAR}
EXACT = 1e-6
EXPORT_NAME = "Measured BRDF Export"
ALBEDO = np.array([0.5, 0.25, 0.125])


def outcome(close, colours="Rec.709"):
    return SimpleNamespace(principled=close, colours=colours, albedo=ALBEDO)


@pytest.fixture
def material(blender):
    """A material with a group on an output for Cycles and on one for EEVEE, on a plane."""
    blender.ops.mesh.primitive_plane_add()
    material, group, surface = blank_material("measured", "ShaderNodeGroup")
    blender.context.object.data.materials.append(material)
    inside = blender.data.node_groups.new("Measured BRDF", "ShaderNodeTree")
    for name in ("BSDF", "EEVEE"):
        inside.interface.new_socket(name, in_out="OUTPUT", socket_type="NodeSocketShader")
    for name, kind, value in (("Tint", "Color", (1, 1, 1, 1)), ("Strength", "Float", 1), ("Normal", "Vector", None)):
        socket = inside.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
        if value is not None:
            socket.default_value = value
    diffuse, end = inside.nodes.new("ShaderNodeBsdfDiffuse"), inside.nodes.new("NodeGroupOutput")
    inside.links.new(diffuse.outputs[0], end.inputs[0])
    group.node_tree = inside
    material.node_tree.links.new(group.outputs["BSDF"], surface)
    add_eevee_output(material)
    return material


def update(material, close, **options):
    export_surface.update(material, group_node(material), outcome(close, **options))


def follow(material):
    export_surface.follow(material, group_node(material))


def exported_node(material):
    return material.node_tree.nodes[EXPORT_NAME]


def outputs(material):
    return [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]


def highlight(index, level=0.5):
    """The reflectance at normal incidence of a Principled BSDF."""
    return ((index - 1) / (index + 1)) ** 2 * 2 * level


def assert_fitted(surface, close):
    """The base and the coat that an importer made are those of a Principled BSDF."""
    for name, value in (("Base Color", close.base_color), ("Metallic", close.metallic),
                        ("Roughness", close.roughness), ("Coat Weight", close.coat_weight)):
        assert surface[name] == pytest.approx(value, abs=EXACT), name
    if close.coat_weight:
        assert surface["Coat Roughness"] == pytest.approx(close.coat_roughness, abs=EXACT)


def imported(blender, importer, path):
    """The inputs of the Principled BSDF that an importer makes of a file."""
    blender.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    importer(filepath=str(path))
    material, = (each for each in blender.data.materials if each.node_tree is not None)
    node, = (node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    return {socket.name: np.array(socket.default_value)[:3] if socket.type == "RGBA" else socket.default_value
            for socket in node.inputs if hasattr(socket, "default_value")}


@pytest.fixture
def gltf(blender):
    import addon_utils

    addon_utils.enable("io_scene_gltf2")
    yield
    addon_utils.disable("io_scene_gltf2")


@pytest.mark.parametrize("name", FIT)
def test_gltf_has_the_fitted_principled(blender, gltf, material, tmp_path, name):
    close = FIT[name]
    update(material, close)
    blender.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"))
    surface = imported(blender, blender.ops.import_scene.gltf, tmp_path / "a.glb")
    assert_fitted(surface, close)
    assert highlight(surface["IOR"], surface["Specular IOR Level"]) == pytest.approx(0.08 * close.specular_level,
                                                                                     abs=EXACT)
    assert surface["Sheen Weight"] == close.sheen_weight
    if close.sheen_weight:
        assert surface["Sheen Tint"] == pytest.approx(close.sheen_tint, abs=EXACT)
        assert surface["Sheen Roughness"] == pytest.approx(close.sheen_roughness, abs=EXACT)


@pytest.mark.parametrize("name", FIT)
def test_usd_has_the_fitted_preview_surface(blender, material, tmp_path, name):
    close = FIT[name]
    update(material, close)
    blender.ops.wm.usd_export(filepath=str(tmp_path / "a.usda"))
    text = (tmp_path / "a.usda").read_text()
    assert 'info:id = "UsdPreviewSurface"' in text
    # the specification has no level of highlights beside the index
    assert highlight(float(re.search(r"float inputs:ior = (.*)", text)[1])) == pytest.approx(
        0.08 * close.specular_level, abs=EXACT)
    assert_fitted(imported(blender, blender.ops.wm.usd_import, tmp_path / "a.usda"), close)


@pytest.mark.parametrize("name", FIT)
def test_materialx_has_the_fitted_surface(blender, material, tmp_path, name):
    if "generate_materialx_network" not in blender.ops.wm.usd_export.get_rna_type().properties:
        pytest.skip("this Blender does not write MaterialX")
    close = FIT[name]
    update(material, close)
    blender.ops.wm.usd_export(filepath=str(tmp_path / "a.usda"), generate_materialx_network=True)
    text = (tmp_path / "a.usda").read_text()
    if "ND_" not in text:
        pytest.skip("this Blender offers MaterialX and writes none: 4.2 as a Python module")
    assert 'info:id = "ND_open_pbr_surface_surfaceshader"' in text

    def number(name, shader=""):
        """The value of an input, worked out of the nodes that Blender 4.5 writes for it."""
        inputs = text[text.index(f'def Shader "{shader}"'):] if shader else text
        value = re.search(rf"inputs:{name}(?: = ([-.\de]+)|.connect = .*[/:](\w+?)(?:_out>|.outputs:out>))\n", inputs)
        if value[1] is not None:
            return float(value[1])
        kind = re.search(r'info:id = "ND_(\w+)_float"', text[text.index(f'def Shader "{value[2]}"'):])[1]
        return {"constant": lambda node: number("value", node),
                "multiply": lambda node: number("in1", node) * number("in2", node)}[kind](value[2])

    def color(name):
        return [float(part) for part in re.search(rf"color3f inputs:{name} = \((.*)\)", text)[1].split(",")]

    assert color("base_color") == pytest.approx(close.base_color, abs=EXACT)
    assert number("base_metalness") == pytest.approx(close.metallic, abs=EXACT)
    assert number("specular_roughness") == pytest.approx(close.roughness, abs=EXACT)
    assert number("coat_weight") == pytest.approx(close.coat_weight, abs=EXACT)
    assert number("fuzz_weight") == close.sheen_weight
    assert number("geometry_opacity") == 1
    assert number("specular_weight") == pytest.approx(2 * close.specular_level, abs=EXACT)
    assert number("specular_ior") == 1.5
    if close.sheen_weight:
        assert color("fuzz_color") == pytest.approx(close.sheen_tint, abs=EXACT)


def test_obj_and_fbx_have_the_fitted_color(blender, material, tmp_path):
    from bpy_extras.node_shader_utils import PrincipledBSDFWrapper

    update(material, CLOTH)
    blender.ops.wm.obj_export(filepath=str(tmp_path / "a.obj"))
    assert "Kd 0.600000 0.300000 0.100000" in (tmp_path / "a.mtl").read_text()
    assert tuple(PrincipledBSDFWrapper(material).base_color) == pytest.approx(CLOTH.base_color, abs=EXACT)


@release
def test_a_mix_is_exported_between_its_materials_and_follows_them(blender, gltf, quick, tmp_path):
    blender.ops.mesh.primitive_plane_add()
    for name in ("red-fabric", "chrome"):
        blender.ops.measured_brdf.import_data(filepath=f"published:{name}", preset="Draft")
    first, second = (blender.data.materials[name] for name in ("Red fabric", "Chrome"))
    blender.ops.measured_brdf.mix(first=first.name, second=second.name, factor=0.25)

    def exported(material):
        blender.context.object.material_slots[0].material = material
        path = tmp_path / "a.gltf"
        blender.ops.export_scene.gltf(filepath=str(path), export_format="GLTF_SEPARATE")
        written = json.loads(path.read_text())["materials"][0]["pbrMetallicRoughness"]
        return np.array([*written.get("baseColorFactor", (1, 1, 1, 1)), written.get("metallicFactor", 1),
                         written.get("roughnessFactor", 1)])

    mixed = blender.data.materials[f"{first.name} + {second.name}"]
    before = exported(mixed)
    np.testing.assert_allclose(before, 0.75 * exported(first) + 0.25 * exported(second), atol=1e-5)
    first.measured_brdf_adjustments.diffuse_tint = (0, 0, 1)
    with blender.context.temp_override(material=first):
        blender.ops.measured_brdf.adjust()
    after = exported(mixed)
    assert abs(after - before).max() > 0.05
    np.testing.assert_allclose(after, 0.75 * exported(first) + 0.25 * exported(second), atol=1e-5)


def test_renderers_keep_their_outputs(blender, material):
    before = {target: material.node_tree.get_output_node(target).name for target in ("CYCLES", "EEVEE")}
    update(material, CLOTH)
    assert {target: material.node_tree.get_output_node(target).name for target in before} == before
    assert len(outputs(material)) == 3


def test_a_level_that_a_user_has_set_or_disconnected_stays(blender, material):
    update(material, CLOTH)
    tree = material.node_tree
    tree.nodes[f"{EXPORT_NAME} Specular IOR Level"].outputs[0].default_value = 0.2
    update(material, CAR)
    assert tree.nodes[f"{EXPORT_NAME} Specular IOR Level"].outputs[0].default_value == pytest.approx(0.2)
    level = exported_node(material).inputs["Specular IOR Level"]
    assert highlight(exported_node(material).inputs["IOR"].default_value) == pytest.approx(0.08 * 0.2)
    tree.links.remove(level.links[0])
    level.default_value = 0.7
    update(material, CLOTH)
    assert not level.is_linked
    assert level.default_value == pytest.approx(0.7)


def test_another_fit_changes_the_same_nodes(blender, material):
    update(material, CLOTH)
    names = sorted(node.name for node in material.node_tree.nodes)
    update(material, CAR)
    assert sorted(node.name for node in material.node_tree.nodes) == names
    node, = (node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    assert (node.inputs["Metallic"].default_value, node.inputs["Sheen Weight"].default_value) == (1, 0)


def test_an_output_that_the_user_has_made_for_all_renderers_is_kept(blender, material):
    tree = material.node_tree
    mine, output = tree.nodes.new("ShaderNodeBsdfGlass"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(mine.outputs[0], output.inputs["Surface"])
    names = sorted(node.name for node in tree.nodes)
    update(material, CLOTH)
    assert sorted(node.name for node in tree.nodes) == names


def test_colors_are_those_of_the_open_file(blender, material):
    update(material, CLOTH, colours="ACEScg")
    node, = (node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    expected = conversion("ACEScg", scene_colours() or DEFAULT_COLOURS) @ CLOTH.base_color
    assert tuple(node.inputs["Base Color"].default_value)[:3] == pytest.approx(np.clip(expected, 0, 1), abs=EXACT)


def test_what_a_user_has_changed_outlives_another_fit(material):
    update(material, CLOTH)
    node = exported_node(material)
    node.inputs["Roughness"].default_value = 0.9
    for close in (CAR, CLOTH, CAR):
        update(material, close)
        assert node.inputs["Roughness"].default_value == pytest.approx(0.9)
        assert node.inputs["Coat Weight"].default_value == pytest.approx(close.coat_weight)


TINT, STRENGTH = np.array([0.25, 1.0, 0.5]), 0.5


def gltf_written(blender, path):
    """The first material of an exported scene, and the linear colours of a texture of it."""
    blender.ops.export_scene.gltf(filepath=str(path), export_format="GLTF_SEPARATE")
    content = json.loads(path.read_text())

    def texels(texture, is_data=False):
        name = content["images"][content["textures"][texture["index"]]["source"]]["uri"]
        return stored(blender, path.parent / unquote(name), is_data)

    return content["materials"][0], texels


def stored(blender, path, is_data=False):
    """The linear values of a file, (height, width, 3), the bottom row first."""
    image = blender.data.images.load(str(path))
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, -1)[..., :3]
    return pixels if is_data else decode_srgb(pixels)


def image_node(blender, material, name, pixels, is_data=False):
    """An Image Texture node in the material, of (height, width, 3) as it is stored."""
    image = blender.data.images.new(name, *pixels.shape[1::-1], is_data=is_data)
    image.pixels.foreach_set(np.insert(pixels, 3, 1, axis=2).astype(np.float32).ravel())
    image.pack()
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def add_normal_map(blender, material):
    tree = material.node_tree
    texture, normal = image_node(blender, material, "bumps", MASK, is_data=True), tree.nodes.new("ShaderNodeNormalMap")
    normal.inputs["Strength"].default_value = 0.75
    tree.links.new(texture.outputs["Color"], normal.inputs["Color"])
    tree.links.new(normal.outputs["Normal"], group_node(material).inputs["Normal"])


def connect_checker(blender, material):
    """Have an image in the tint: its node, and the link."""
    texture = image_node(blender, material, "checker", CHECKER)
    return texture, material.node_tree.links.new(texture.outputs["Color"], group_node(material).inputs["Tint"])


CHECKER = np.kron(np.array([[1.0, 0.2], [0.4, 0.8]]), np.ones((4, 4)))[..., None] * np.array([1.0, 0.5, 0.25])
MASK = np.kron(np.array([[0.0, 1.0], [0.5, 0.25]]), np.ones((4, 4)))[..., None] * np.ones(3)
# of USD's own surface, and of MaterialX's, which Blender 4.2 as a Python module does not write
USD_COLORS = ("diffuseColor", "base_color")[:1 if bpy.app.version < (4, 5, 0) else 2]
EIGHT_BITS = 0.006          # of linear values that were stored in 8 bits of sRGB, and again in those of a file


def test_a_plain_tint_and_strength_are_exported(blender, gltf, material, tmp_path):
    update(material, CLOTH)
    node = group_node(material)
    node.inputs["Tint"].default_value, node.inputs["Strength"].default_value = (*TINT, 1), STRENGTH
    follow(material)
    expected = CLOTH.base_color * TINT * STRENGTH
    written, _ = gltf_written(blender, tmp_path / "a.gltf")
    assert written["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx([*expected, 1], abs=EXACT)
    assert written["pbrMetallicRoughness"]["metallicFactor"] == 0
    extensions = written["extensions"]
    specular = extensions["KHR_materials_specular"]
    reflected = specular["specularFactor"] * np.array(specular["specularColorFactor"])
    assert reflected == pytest.approx(2 * CLOTH.specular_level * TINT * STRENGTH, abs=EXACT)
    # the format has no weight of sheen: the tint has to be scaled by it
    assert extensions["KHR_materials_sheen"]["sheenColorFactor"] == pytest.approx(CLOTH.sheen_tint * TINT * STRENGTH,
                                                                                  abs=EXACT)
    blender.ops.wm.obj_export(filepath=str(tmp_path / "a.obj"))
    assert "Kd " + " ".join(f"{value:.6f}" for value in expected) in (tmp_path / "a.mtl").read_text()
    blender.ops.wm.usd_export(filepath=str(tmp_path / "a.usda"), generate_materialx_network=True)
    text = (tmp_path / "a.usda").read_text()
    # formats without a colour of highlights have how bright they are
    indices = [float(re.search(f"{mark}(.*)", form)[1]) for mark, form in (
        ("float inputs:ior = ", text), ("Ni ", (tmp_path / "a.mtl").read_text()))]
    assert highlight(np.array(indices)) == pytest.approx(0.08 * CLOTH.specular_level * STRENGTH * TINT.max(), abs=EXACT)
    for name in USD_COLORS:
        color = re.search(rf"color3f inputs:{name} = \((.*)\)", text)
        assert [float(part) for part in color[1].split(",")] == pytest.approx(expected, abs=EXACT)
    assert material.diffuse_color[:3] == pytest.approx(ALBEDO * TINT * STRENGTH, abs=EXACT)


def test_an_image_in_tint_times_the_base_color_is_a_texture_everywhere(blender, gltf, material, tmp_path):
    update(material, CLOTH)
    node = group_node(material)
    connect_checker(blender, material)[0].extension = "EXTEND"
    node.inputs["Strength"].default_value = STRENGTH
    follow(material)
    expected = decode_srgb(np.round(CHECKER * 255) / 255) * CLOTH.base_color * STRENGTH
    written, texels = gltf_written(blender, tmp_path / "a.gltf")
    surface = written["pbrMetallicRoughness"]
    seen = texels(surface["baseColorTexture"]) * np.array(surface.get("baseColorFactor", [1, 1, 1, 1]))[:3]
    np.testing.assert_allclose(seen, expected, atol=EIGHT_BITS)
    blender.ops.wm.usd_export(filepath=str(tmp_path / "a.usda"), generate_materialx_network=True)
    text = (tmp_path / "a.usda").read_text()
    files = set(re.findall(r"asset inputs:file = @(.*?)@", text))
    np.testing.assert_allclose(stored(blender, tmp_path / files.pop()), expected, atol=EIGHT_BITS)
    assert not files
    assert all(f"color3f inputs:{name}.connect" in text for name in USD_COLORS)
    assert 'wrapS = "clamp"' in text
    blender.ops.wm.obj_export(filepath=str(tmp_path / "a.obj"), path_mode="COPY")
    lines = (tmp_path / "a.mtl").read_text().splitlines()
    assert [line for line in lines if "Kd" in line] == ["map_Kd measured_base_color.png"], "nothing multiplies it"
    mean = (decode_srgb(np.round(CHECKER * 255) / 255)).mean(axis=(0, 1)) * ALBEDO * STRENGTH
    assert material.diffuse_color[:3] == pytest.approx(mean, abs=EIGHT_BITS)


def test_a_tinted_metal_keeps_its_edge(blender, material):
    update(material, CAR)
    node, export = group_node(material), exported_node(material)
    node.inputs["Tint"].default_value, node.inputs["Strength"].default_value = (*TINT, 1), STRENGTH
    follow(material)
    assert export.inputs["Specular Tint"].default_value[:3] == pytest.approx(TINT * STRENGTH, abs=EXACT)
    assert highlight(export.inputs["IOR"].default_value) == pytest.approx(0.08 * CAR.specular_level)
    level = material.node_tree.nodes[f"{EXPORT_NAME} Specular IOR Level"].outputs[0]
    assert level.default_value == pytest.approx(CAR.specular_level)
    node.inputs["Strength"].default_value = 0
    follow(material)
    assert export.inputs["Specular Tint"].default_value[:3] == pytest.approx((0, 0, 0), abs=EXACT)


@pytest.mark.parametrize(("strength", "reflected"), [(-1, 0), (-1e30, 0), (1000, 1), (1e30, 1)])
def test_an_impossible_strength_is_exported_black_or_white(material, strength, reflected):
    update(material, CLOTH)
    node, export = group_node(material), exported_node(material)
    node.inputs["Strength"].default_value = strength
    follow(material)
    assert highlight(export.inputs["IOR"].default_value) == pytest.approx(reflected, abs=5e-3)
    assert [*export.inputs["Base Color"].default_value, *material.diffuse_color[:3]] == [
        *[reflected] * 3, 1, *[reflected] * 3]


def test_what_some_formats_have_not_is_told_and_not_by_gltf(blender, gltf, material, tmp_path, capfd):
    update(material, CLOTH)
    node = group_node(material)
    node.inputs["Tint"].default_value = (0.5, 0.5, 0.5, 1)
    follow(material)
    assert [line.split(" as ")[0] for line in export_surface.losses(material)] == ["In FBX highlights are"]
    node.inputs["Tint"].default_value = (*TINT, 1)
    add_normal_map(blender, material)
    follow(material)
    told = export_surface.losses(material)
    assert [line.split(":")[0] for line in told] == ["In USD the normal map has a Strength of 1",
                                                     "In USD, OBJ and FBX highlights are white"]
    added = blender.context.preferences.addons.new()
    added.module = measured_brdf.__name__
    gltf_written(blender, tmp_path / "a.gltf")
    blender.context.preferences.addons.remove(added)
    assert "WARNING: measured" not in capfd.readouterr().out


def test_an_image_that_is_taken_away_leaves_nothing(blender, material):
    update(material, CLOTH)
    before = {node.name for node in material.node_tree.nodes}
    texture, link = connect_checker(blender, material)
    follow(material)
    assert len(blender.data.images) == 2
    material.node_tree.links.remove(link)
    material.node_tree.nodes.remove(texture)
    follow(material)
    assert {node.name for node in material.node_tree.nodes} == before
    assert [image.name for image in blender.data.images] == ["checker"]
    export = exported_node(material)
    assert export.inputs["Base Color"].default_value[:3] == pytest.approx(CLOTH.base_color, abs=EXACT)


def test_brightness_beside_a_constant_in_strength_is_in_the_texture(blender, gltf, material, tmp_path):
    """As a measured flat sample of one material has it."""
    update(material, CLOTH)
    tree, node = material.node_tree, group_node(material)
    texture, times = image_node(blender, material, "brightness", MASK, is_data=True), tree.nodes.new("ShaderNodeMath")
    times.operation, times.inputs[1].default_value = "MULTIPLY", 1.5
    tree.links.new(texture.outputs["Color"], times.inputs[0])
    tree.links.new(times.outputs[0], node.inputs["Strength"])
    follow(material)
    written, texels = gltf_written(blender, tmp_path / "a.gltf")
    seen = texels(written["pbrMetallicRoughness"]["baseColorTexture"])
    stored_mask = np.round(MASK * 255) / 255
    np.testing.assert_allclose(seen, np.minimum(stored_mask * 1.5 * CLOTH.base_color, 1), atol=EIGHT_BITS)


def test_a_normal_map_is_exported(blender, gltf, material, tmp_path):
    update(material, CLOTH)
    tree, node = material.node_tree, group_node(material)
    add_normal_map(blender, material)
    follow(material)
    written, texels = gltf_written(blender, tmp_path / "a.gltf")
    assert written["normalTexture"]["scale"] == pytest.approx(0.75)
    np.testing.assert_allclose(texels(written["normalTexture"], is_data=True), MASK, atol=0.003)
    tree.links.remove(node.inputs["Normal"].links[0])
    follow(material)
    written, _ = gltf_written(blender, tmp_path / "b.gltf")
    assert "normalTexture" not in written


def test_what_cannot_be_exported_is_told_at_the_export_and_in_the_panel(blender, gltf, material, tmp_path, capfd,
                                                                        monkeypatch):
    update(material, CLOTH)
    monkeypatch.setattr("measured_brdf.addon.core.shading.material.surface_node", group_node)
    assert export_surface.losses(material) == []
    blender.ops.measured_brdf.check_export()
    assert "Warning" not in capfd.readouterr().out
    tree, node = material.node_tree, group_node(material)
    for kind, name in (("Noise", "Tint"), ("Noise", "Strength")):
        made = tree.nodes.new(f"ShaderNodeTex{kind}")
        tree.links.new(made.outputs[0], node.inputs[name])
    bump = tree.nodes.new("ShaderNodeBump")
    tree.links.new(bump.outputs[0], node.inputs["Normal"])
    follow(material)
    told = export_surface.losses(material)
    assert [line.split(":")[0] for line in told] == ["Tint", "Strength", "Normal"]
    blender.ops.measured_brdf.check_export()
    seen = capfd.readouterr().out
    assert all(f"Warning: {material.name}: {line}" in seen for line in told)
    of_dialog = SimpleNamespace(active_operator=SimpleNamespace(bl_idname="WM_OT_usd_export"))
    assert Panel.poll(SimpleNamespace(space_data=of_dialog))
    shown = draw(Panel, space_data=of_dialog).texts
    assert all(f"{material.name}: {line}" in shown for line in told)
    added = blender.context.preferences.addons.new()
    added.module = measured_brdf.__name__
    blender.ops.export_scene.gltf(filepath=str(tmp_path / "a.gltf"), export_format="GLTF_SEPARATE")
    seen = capfd.readouterr().out
    blender.context.preferences.addons.remove(added)
    assert all(f"WARNING: {material.name}: {line}" in seen for line in told)


def test_a_group_is_told_by_the_name_that_the_editor_shows(blender, material):
    update(material, CLOTH)
    tree, inside = material.node_tree, blender.data.node_groups.new("Flakes", "ShaderNodeTree")
    inside.interface.new_socket("Normal", in_out="OUTPUT", socket_type="NodeSocketVector")
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = inside
    for name in ("Tint", "Normal"):
        tree.links.new(node.outputs[0], group_node(material).inputs[name])
    follow(material)
    assert [line.split()[-2:] for line in export_surface.losses(material)] == [["Flakes", "makes"], ["not", "Flakes"]]


def test_packed_textures_are_told_until_they_are_written_and_then_obj_has_them(blender, material, tmp_path):
    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    update(material, CLOTH)
    connect_checker(blender, material)
    follow(material)

    def written(name):
        blender.ops.wm.obj_export(filepath=str(tmp_path / "out" / f"{name}.obj"), path_mode="COPY")
        named = re.search(r"map_Kd (.*)", (tmp_path / "out" / f"{name}.mtl").read_text())[1]
        return (tmp_path / "out" / named).is_file()

    (tmp_path / "out").mkdir()
    told = [line for line in export_surface.losses(material) if "Unpack Resources" in line]
    assert (len(told), written("packed")) == (1, False)
    blender.ops.file.unpack_all(method="USE_LOCAL")
    assert not any("Unpack Resources" in line for line in export_surface.losses(material))
    assert written("unpacked")


def test_it_is_told_where_another_output_is_exported(blender, material):
    update(material, CLOTH)
    mine = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    mine.name, mine.is_active_output = "Mine", True
    assert export_surface.losses(material) == ["What other programs get is the surface at the output Mine"]


def test_the_solid_colour_follows_and_a_metal_is_not_black_there(blender, material):
    update(material, CAR)
    assert material.metallic == 0
    group_node(material).inputs["Strength"].default_value = STRENGTH
    follow(material)
    assert material.diffuse_color[:3] == pytest.approx(ALBEDO * STRENGTH, abs=EXACT)
    material.diffuse_color = (1, 0, 1, 1)
    group_node(material).inputs["Strength"].default_value = 1
    follow(material)
    assert material.diffuse_color[:3] == pytest.approx((1, 0, 1)), "the user's"


def test_a_change_is_followed_without_being_asked(blender, gltf, quick, tmp_path):
    """The whole way: the library, an input of the node, a file; and undo."""
    blender.ops.mesh.primitive_plane_add()
    blender.ops.measured_brdf.import_data(filepath="published:red-plastic", preset="Draft")
    material = blender.context.object.active_material
    plain, _ = gltf_written(blender, tmp_path / "a.gltf")
    group_node(material).inputs["Tint"].default_value = (*TINT, 1)
    blender.context.view_layer.update()
    tinted, _ = gltf_written(blender, tmp_path / "b.gltf")
    before, after = (np.array(each["pbrMetallicRoughness"]["baseColorFactor"][:3]) for each in (plain, tinted))
    np.testing.assert_allclose(after, before * TINT, atol=EXACT)


def test_a_mask_of_a_mix_is_baked(blender, gltf, quick, tmp_path):
    blender.ops.mesh.primitive_plane_add()
    parts = []
    for name in ("red-fabric", "chrome"):
        blender.ops.measured_brdf.import_data(filepath=f"published:{name}", preset="Draft")
        written, _ = gltf_written(blender, tmp_path / f"{name}.gltf")
        parts.append(written["pbrMetallicRoughness"])
    material = blender.context.object.active_material
    image = image_node(blender, material, "mask", MASK, is_data=True).image
    blender.ops.measured_brdf.mix(first="Red fabric", second="Chrome", mask=image.name)
    mixed = blender.data.materials["Red fabric + Chrome"]
    blender.context.object.material_slots[0].material = mixed
    surface, texels = gltf_written(blender, tmp_path / "mixed.gltf")
    surface = surface["pbrMetallicRoughness"]
    share = np.round(MASK * 255) / 255

    def expected(name, default):
        below, above = (np.atleast_1d(part.get(name, default)) for part in parts)
        return (1 - share) * below[..., :3] + share * above[..., :3]

    np.testing.assert_allclose(texels(surface["baseColorTexture"]), expected("baseColorFactor", [1, 1, 1, 1]),
                               atol=EIGHT_BITS)
    packed = texels(surface["metallicRoughnessTexture"], is_data=True)
    for channel, name in ((1, "roughnessFactor"), (2, "metallicFactor")):
        seen = packed[..., channel] * surface.get(name, 1)
        np.testing.assert_allclose(seen, expected(name, [1.0])[..., 0], atol=0.004)
    # a stroke of the brush
    image.pixels.foreach_set(np.ones(4 * image.size[0] * image.size[1], dtype=np.float32))
    image.update_tag()
    blender.context.view_layer.update()
    again, texels = gltf_written(blender, tmp_path / "painted.gltf")
    seen = again["pbrMetallicRoughness"]
    np.testing.assert_allclose(texels(seen["baseColorTexture"]), np.ones((8, 8, 1)) * parts[1]["baseColorFactor"][:3],
                               atol=EIGHT_BITS)


def test_displacement_at_the_highlighted_output_is_that_of_the_renderers(blender, material):
    update(material, CLOTH)
    tree = material.node_tree
    highlighted, = (node for node in outputs(material) if node.is_active_output)
    displacement = tree.nodes.new("ShaderNodeDisplacement")
    link = tree.links.new(displacement.outputs[0], highlighted.inputs["Displacement"])
    follow(material)
    others = [node.inputs["Displacement"] for node in outputs(material) if node != highlighted]
    assert [socket.links[0].from_node for socket in others] == [displacement, displacement]
    tree.links.remove(link)
    follow(material)
    assert not any(socket.is_linked for socket in others)
    tree.links.new(displacement.outputs[0], others[0])
    follow(material)
    assert [socket.is_linked for socket in others] == [True, False], "the user's own"
