"""Presets that are fitted with one click, a pinned material, pictures in a large view, and renders to look at."""

import json

import bpy
import pytest
from measured_brdf.addon.compare import operators
from measured_brdf.addon.core.shading import comparison, look

from fitter import PRESETS
from support.blend_state import state

CHEAP = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}


@pytest.fixture
def files(tmp_path, glossy, write_astm):
    return [write_astm(tmp_path / f"{name}.astm", glossy, name) for name in ("one", "two")]


@pytest.fixture
def cubes(blender, quick, files):
    """Two cubes with a measured material each; the first is active."""
    for path in reversed(files):
        blender.ops.mesh.primitive_cube_add()
        blender.ops.measured_brdf.import_data(filepath=str(path), **CHEAP)
    return blender.context.object


@pytest.fixture
def one(cubes):
    return bpy.data.materials["one"]


@pytest.fixture
def two(cubes):
    return bpy.data.materials["two"]


def test_a_preset_is_fitted_in_one_step(one):
    settings = one.measured_brdf
    assert bpy.ops.measured_brdf.fit(preset="Paper") == {"FINISHED"}
    expected = PRESETS["Paper"]
    assert (settings.preset, settings.diffuse_level, settings.specular_level, settings.fitted_levels) == (
        "Paper", expected["diffuse_level"], expected["specular_level"], "(4,6,95)")
    assert settings.compression == pytest.approx(expected["compression"])
    assert bpy.data.materials["two"].measured_brdf.diffuse_level == CHEAP["diffuse_level"]


def test_a_pinned_material_survives_renaming_and_other_active_materials(cubes, one, two):
    scene = bpy.context.scene
    cubes.active_material = two
    assert bpy.ops.measured_brdf.pin() == {"FINISHED"}
    two.name = "renamed"
    cubes.active_material = one
    assert comparison.find_pinned(scene, one) == two
    assert comparison.find_pinned(scene, two) is None, "it is not compared with itself"


def test_a_pinned_material_that_is_deleted_or_loses_its_shader_is_not_compared(cubes, one, two):
    scene = bpy.context.scene
    comparison.get(scene).pinned = two
    node = next(node for node in two.node_tree.nodes if node.type == "GROUP")
    two.node_tree.nodes.remove(node)
    assert comparison.find_pinned(scene, one) is None
    bpy.data.materials.remove(two)
    assert comparison.get(scene).pinned is None
    assert comparison.find_pinned(scene, one) is None


def test_a_linked_material_can_be_pinned_and_a_linked_scene_refuses(cubes, one, tmp_path):
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    name = bpy.context.scene.name
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_, target):
        target.materials, target.scenes = ["one"], [name]
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(target.materials[0])
    assert bpy.ops.measured_brdf.pin() == {"FINISHED"}
    assert comparison.get(bpy.context.scene).pinned == target.materials[0]
    linked = next(scene for scene in bpy.data.scenes if scene.library is not None)
    with bpy.context.temp_override(scene=linked):
        assert not bpy.ops.measured_brdf.pin.poll()


def test_without_a_measured_material_nothing_is_offered(blender):
    blender.ops.mesh.primitive_cube_add()
    blender.context.object.data.materials.append(blender.data.materials.new("plain"))
    for operator in (bpy.ops.measured_brdf.pin, bpy.ops.measured_brdf.render_look):
        assert not operator.poll()


@pytest.fixture
def small(monkeypatch):
    """Renders of a few pixels."""
    monkeypatch.setattr(operators, "SIZE", 24)
    monkeypatch.setattr(operators, "_SAMPLES", 4)


def test_a_test_render_is_shown_as_it_was_made_until_it_is_made_again(cubes, one, two, small):
    scene = bpy.context.scene
    comparison.get(scene).pinned = two
    before = state()
    assert bpy.ops.measured_brdf.render_look() == {"FINISHED"}
    assert state() == before
    keys = [operators.render_key(scene, each) for each in (one, two)]
    for key in keys:
        picture, _ = operators.renders[key]
        assert picture.shape == (24, 24, 4)
        assert picture[..., :3].max() > 0.1
    comparison.get(scene).divide = 0.3
    assert operators.render_key(scene, one) == keys[0]
    comparison.get(scene).lighting = "SKY"
    assert operators.renders.get(operators.render_key(scene, one)) is None
    comparison.get(scene).lighting = "STUDIO"
    node = next(node for node in one.node_tree.nodes if node.type == "GROUP")
    node.inputs["Strength"].default_value = 0.5
    before = [operators.renders[key] for key in keys]
    assert bpy.ops.measured_brdf.render_look() == {"FINISHED"}
    after = [operators.renders[key] for key in keys]
    assert not {number for _, number in after} & {number for _, number in before}
    brightness = [picture[8:16, 8:16, :3].mean() for picture, _ in (before[0], after[0])]
    assert brightness[1] < 0.9 * brightness[0]


def test_the_scenes_world_gives_the_light(one, small):
    scene = bpy.context.scene
    comparison.get(scene).lighting = "WORLD"
    comparison.get(scene).shape = "SPHERE"
    with pytest.raises(RuntimeError, match="no world"):
        bpy.ops.measured_brdf.render_look()
    scene.world = bpy.data.worlds.new("red")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1, 0, 0, 1)
    before = state()
    assert bpy.ops.measured_brdf.render_look() == {"FINISHED"}
    assert state() == before
    picture = operators.renders[operators.render_key(scene, one)][0]
    assert picture[..., 0].mean() > 3 * picture[..., 1].mean()


def test_a_render_that_cannot_be_written_leaves_the_file_as_it_was(one, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(look, "write_request", full)
    before = state()
    with pytest.raises(RuntimeError, match="No space left"):
        bpy.ops.measured_brdf.render_look()
    assert state() == before


def test_a_render_that_fails_is_told(one, small, monkeypatch):
    monkeypatch.setattr(look, "write_request", lambda folder, request: (folder / "request.json").write_text(
        json.dumps(request._asdict() | {"shape": "SPHERE", "materials": ["gone"]}), "utf-8"))
    before = state()
    with pytest.raises(RuntimeError, match="gone"):
        bpy.ops.measured_brdf.render_look()
    assert state() == before


def test_a_linked_material_is_rendered(cubes, small, from_library):
    linked = from_library("one")
    before = state()
    assert bpy.ops.measured_brdf.render_look() == {"FINISHED"}
    assert state() == before
    picture = operators.renders[operators.render_key(bpy.context.scene, linked)][0]
    plain = picture[12, 12, :3]
    assert plain.max() > 0.02, "the shader has been found"
