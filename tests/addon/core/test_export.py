"""What other programs get of a measured material: exported, and imported again or read as text."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from fitter.cycles.principled_bsdf import Principled
from support.cases import release

CLOTH = Principled(np.array([0.6, 0.3, 0.1]), 0.45, 0.0, 0.3, np.array([0.5, 0.25, 0.125]), 0.4)
CAR = Principled(np.array([0.8, 0.5, 0.2]), 0.55, 1.0, 0.5, coat_weight=0.7, coat_roughness=0.15)
FIT = {"cloth": CLOTH, "car": CAR}
EXACT = 1e-6


def outcome(close, colours="Rec.709"):
    return SimpleNamespace(principled=close, colours=colours)


@pytest.fixture
def material(blender):
    """A material with a group on an output for Cycles and on one for EEVEE, on a plane."""
    blender.ops.mesh.primitive_plane_add()
    material = blender.data.materials.new("measured")
    if blender.app.version < (5, 0, 0):
        material.use_nodes = True
    blender.context.object.data.materials.append(material)
    tree = material.node_tree
    tree.nodes.clear()
    inside = blender.data.node_groups.new("Measured BRDF", "ShaderNodeTree")
    inside.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    diffuse, end = inside.nodes.new("ShaderNodeBsdfDiffuse"), inside.nodes.new("NodeGroupOutput")
    inside.links.new(diffuse.outputs[0], end.inputs[0])
    group = tree.nodes.new("ShaderNodeGroup")
    group.node_tree = inside
    for target in ("CYCLES", "EEVEE"):
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        output.target = target
        tree.links.new(group.outputs[0], output.inputs["Surface"])
    return material


def update(material, close, **options):
    from measured_brdf.addon.core import export_surface

    export_surface.update(material, outcome(close, **options))


def outputs(material):
    return [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]


def imported(blender, importer, path):
    """The inputs of the Principled BSDF that an importer makes of a file."""
    blender.ops.wm.read_factory_settings(use_empty=True)
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
    assert surface["Base Color"] == pytest.approx(close.base_color, abs=EXACT)
    assert surface["Metallic"] == pytest.approx(close.metallic, abs=EXACT)
    assert surface["Roughness"] == pytest.approx(close.roughness, abs=EXACT)
    assert surface["Specular IOR Level"] == pytest.approx(close.specular_level, abs=EXACT)
    assert surface["Sheen Weight"] == close.sheen_weight
    if close.sheen_weight:
        assert surface["Sheen Tint"] == pytest.approx(close.sheen_tint, abs=EXACT)
        assert surface["Sheen Roughness"] == pytest.approx(close.sheen_roughness, abs=EXACT)
    assert surface["Coat Weight"] == pytest.approx(close.coat_weight, abs=EXACT)
    if close.coat_weight:
        assert surface["Coat Roughness"] == pytest.approx(close.coat_roughness, abs=EXACT)


def test_gltf_is_as_other_programs_read_it(blender, gltf, material, tmp_path):
    update(material, CLOTH)
    blender.ops.export_scene.gltf(filepath=str(tmp_path / "a.gltf"), export_format="GLTF_SEPARATE")
    written, = json.loads((tmp_path / "a.gltf").read_text())["materials"]
    assert written["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx([0.6, 0.3, 0.1, 1], abs=EXACT)
    assert written["pbrMetallicRoughness"]["metallicFactor"] == 0
    # the format has no weight of sheen: the tint has to be scaled by it
    sheen = written["extensions"]["KHR_materials_sheen"]
    assert sheen["sheenColorFactor"] == pytest.approx(CLOTH.sheen_tint, abs=EXACT)


@pytest.mark.parametrize("name", FIT)
def test_usd_has_the_fitted_preview_surface(blender, material, tmp_path, name):
    close = FIT[name]
    update(material, close)
    blender.ops.wm.usd_export(filepath=str(tmp_path / "a.usda"))
    assert 'info:id = "UsdPreviewSurface"' in (tmp_path / "a.usda").read_text()
    surface = imported(blender, blender.ops.wm.usd_import, tmp_path / "a.usda")
    assert surface["Base Color"] == pytest.approx(close.base_color, abs=EXACT)
    assert surface["Metallic"] == pytest.approx(close.metallic, abs=EXACT)
    assert surface["Roughness"] == pytest.approx(close.roughness, abs=EXACT)
    assert surface["Coat Weight"] == pytest.approx(close.coat_weight, abs=EXACT)
    if close.coat_weight:
        assert surface["Coat Roughness"] == pytest.approx(close.coat_roughness, abs=EXACT)


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

    def number(*names):
        return float(next(match[1] for name in names if (match := re.search(rf"inputs:{name} = ([-.\de]+)\n", text))))

    def color(name):
        return [float(part) for part in re.search(rf"color3f inputs:{name} = \((.*)\)", text)[1].split(",")]

    assert color("base_color") == pytest.approx(close.base_color, abs=EXACT)
    assert number("base_metalness") == pytest.approx(close.metallic, abs=EXACT)
    assert number("specular_roughness") == pytest.approx(close.roughness, abs=EXACT)
    assert number("coat_weight") == pytest.approx(close.coat_weight, abs=EXACT)
    assert number("fuzz_weight") == close.sheen_weight
    assert number("geometry_opacity") == 1
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
    from measured_brdf.addon.core.reading import scene_colours

    from fitter.colours import DEFAULT, conversion

    update(material, CLOTH, colours="ACEScg")
    node, = (node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    expected = conversion("ACEScg", scene_colours() or DEFAULT) @ CLOTH.base_color
    assert tuple(node.inputs["Base Color"].default_value)[:3] == pytest.approx(np.clip(expected, 0, 1), abs=EXACT)


def test_what_a_user_has_changed_outlives_another_fit(material):
    from measured_brdf.addon.core import export_surface

    update(material, CLOTH)
    node = material.node_tree.nodes[export_surface.NAME]
    node.inputs["Roughness"].default_value = 0.9
    for close in (CAR, CLOTH, CAR):
        update(material, close)
        assert node.inputs["Roughness"].default_value == pytest.approx(0.9)
        assert node.inputs["Coat Weight"].default_value == pytest.approx(close.coat_weight)


def test_an_imported_measurement_is_exported(blender, gltf, write_astm, glossy, tmp_path):
    """The whole way, from a file of measurements to a file for other programs."""
    write_astm(tmp_path / "glossy.astm", glossy)
    blender.ops.mesh.primitive_plane_add()
    assert blender.ops.measured_brdf.import_data(filepath=str(tmp_path / "glossy.astm"), preset="Draft") == {"FINISHED"}
    from measured_brdf.addon.core import export_surface

    made = blender.context.object.active_material.node_tree.nodes[export_surface.NAME]
    expected = {name: made.inputs[name].default_value for name in ("Metallic", "Roughness")}
    color = list(made.inputs["Base Color"].default_value)
    assert max(color[:3]) > 0.05
    blender.ops.export_scene.gltf(filepath=str(tmp_path / "made.glb"))
    surface = imported(blender, blender.ops.import_scene.gltf, tmp_path / "made.glb")
    for name, value in expected.items():
        assert surface[name] == pytest.approx(value, abs=1e-5)
    assert surface["Base Color"] == pytest.approx(color[:3], abs=1e-5)
