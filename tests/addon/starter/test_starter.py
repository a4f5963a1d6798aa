"""The starter library: built into a folder, with placeholders that are baked by the ordinary operator."""

import json
import subprocess
import sys

import bpy
import numpy as np
import pytest

from support.blend_state import state
from support.cases import release
from support.checkout import ROOT
from support.stage import add_sphere, background, black_scene, render

pytestmark = release        # `make zip` makes the library


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The library, as `make zip` builds it."""
    out = tmp_path_factory.mktemp("starter") / "library"
    subprocess.run([sys.executable, ROOT, "starter", "-o", out], check=True, capture_output=True, timeout=600)
    return out


@pytest.fixture
def starter(extension, built, monkeypatch):
    from measured_brdf.addon.starter import starter

    monkeypatch.setattr(starter, "SHIPPED", built)
    return starter


def append(starter, name):
    with bpy.data.libraries.load(str(starter.SHIPPED / starter.FILE), link=False, assets_only=True) as (_, target):
        target.materials = [name]
    return target.materials[0]


def test_it_holds_100_assets_and_takes_less_than_two_megabytes(blender, starter):
    with bpy.data.libraries.load(str(starter.SHIPPED / starter.FILE), assets_only=True) as (source, _):
        assert len(source.materials) == 100
        assert "Chrome (published fit)" in source.materials
    assert sum(path.stat().st_size for path in starter.SHIPPED.iterdir()) < 1.5e6


def test_the_assets_are_cc0_and_hold_no_byte_code(blender, starter):
    bpy.ops.wm.open_mainfile(filepath=str(starter.SHIPPED / starter.FILE))
    assert {item.asset_data.license for item in bpy.data.materials if item.asset_data} == {"CC0-1.0"}
    trees = [*bpy.data.node_groups, *(item.node_tree for item in bpy.data.materials)]
    assert not [node for tree in trees for node in tree.nodes if node.type == "SCRIPT" and node.bytecode]


def test_each_asset_has_tags_a_picture_and_says_that_it_is_not_measured(blender, starter):
    from measured_brdf.fitter import published

    catalogues = (starter.SHIPPED / "blender_assets.cats.txt").read_text("utf-8")
    bpy.ops.wm.open_mainfile(filepath=str(starter.SHIPPED / starter.FILE))
    for wanted in published.materials().values():
        item = bpy.data.materials[wanted.title]
        data, settings = item.asset_data, item.measured_brdf
        assert {*wanted.tags, "published fit"} <= {tag.name for tag in data.tags}
        assert "not a measurement" in data.description
        assert "Low" in data.description
        assert f"{data.catalog_id}:Measured BRDF/Starter/" in catalogues
        assert (settings.filepath, settings.preset, settings.coefficients) == (wanted.path, "Standard", 0)
        assert tuple(item.preview.image_size) == (128, 128)
        pixels = np.empty(128 * 128 * 4, np.float32)
        item.preview.image_pixels_float.foreach_get(pixels)
        picture = pixels.reshape(128, 128, 4)
        assert picture[64, 64, 3] == 1
        assert picture[0, 0, 3] == 0
        assert picture[..., :3].max() > 0.02
    brass = bpy.data.materials["Brass (published fit)"].node_tree.nodes["Measured BRDF Export"].inputs["Base Color"]
    assert brass.default_value[0] > 1.5 * brass.default_value[2]


def test_a_placeholder_is_baked_by_the_ordinary_operator(blender, starter):
    from measured_brdf.addon.core import material
    from measured_brdf.addon.starter import placeholder

    bpy.ops.mesh.primitive_cube_add()
    item = append(starter, "Red fabric (published fit)")
    bpy.context.object.data.materials.append(item)
    assert placeholder.is_placeholder(item)
    assert not material.is_measured(item)
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    assert material.is_measured(item)
    assert not placeholder.is_placeholder(item)
    assert item.measured_brdf.name_of_data == "Red fabric (published fit)"
    outputs = {node.target: node.inputs["Surface"].links[0].from_node.type for node in item.node_tree.nodes
               if node.type == "OUTPUT_MATERIAL"}
    assert outputs == {"CYCLES": "GROUP", "EEVEE": "GROUP", "ALL": "BSDF_PRINCIPLED"}
    assert [node.type for node in item.node_tree.nodes].count("BSDF_PRINCIPLED") == 1


def test_a_placeholder_is_baked_once_when_an_object_begins_to_use_it(blender, starter):
    from measured_brdf.addon.core import material
    from measured_brdf.addon.starter import placeholders

    placeholders._on_load(None)
    item = append(starter, "Red fabric (published fit)")
    assert not placeholders.bake_next()                     # nothing uses it
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(item)
    assert placeholders.bake_next()
    assert material.is_measured(item)
    assert not placeholders.bake_next()
    item.measured_brdf.coefficients = 0                     # as after an undo
    before = state()
    assert not placeholders.bake_next()
    assert state() == before
    placeholders._on_load(None)                             # a file that was saved with it
    assert not placeholders.bake_next()


def test_what_an_object_uses_when_the_extension_is_enabled_is_left_to_the_fit_button(blender, starter, monkeypatch):
    from measured_brdf.addon.starter import placeholders

    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(append(starter, "Red fabric (published fit)"))
    placeholders.unregister()
    placeholders.register()
    assert bpy.app.timers.is_registered(placeholders._leave_all)
    placeholders._leave_all()                               # the timer, which Blender calls in its window
    assert not placeholders.bake_next()


def test_without_a_window_nothing_is_baked_by_itself(blender, starter):
    from measured_brdf.addon.starter import placeholders

    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(append(starter, "Red fabric (published fit)"))
    bpy.context.view_layer.update()
    assert placeholders._on_change in bpy.app.handlers.depsgraph_update_post
    assert not bpy.app.timers.is_registered(placeholders._tick)


def test_what_is_no_placeholder_is_left_alone(blender, starter, tmp_path):
    from measured_brdf.addon.starter import placeholder

    ordinary = bpy.data.materials.new("Ordinary")
    ordinary.measured_brdf.filepath = "published:chrome"
    assert not placeholder.is_placeholder(ordinary)
    item = append(starter, "Steel (published fit)")
    item.measured_brdf.filepath = str(tmp_path / "mine.astm")
    assert not placeholder.is_placeholder(item)
    with bpy.data.libraries.load(str(starter.SHIPPED / starter.FILE), link=True, assets_only=True) as (_, target):
        target.materials = ["Brass (published fit)"]
    assert not placeholder.is_placeholder(target.materials[0])


def test_a_library_of_a_newer_blender_or_another_revision_is_not_offered(blender, starter, monkeypatch, tmp_path):
    monkeypatch.setattr(starter, "own_folder", lambda: tmp_path / "nowhere")
    assert starter.folder() == starter.SHIPPED
    written = json.loads((starter.SHIPPED / "version.json").read_text("utf-8"))
    for change in ({"blender": [99, 0]}, {"revision": -1}):
        copy = tmp_path / "copy"
        copy.mkdir(exist_ok=True)
        (copy / starter.FILE).write_bytes(b"")
        (copy / "version.json").write_text(json.dumps(written | change))
        monkeypatch.setattr(starter, "SHIPPED", copy)
        assert starter.folder() is None
        (copy / "version.json").write_text("not JSON")
        assert starter.folder() is None


def test_the_library_is_added_to_the_asset_libraries_once(blender, starter):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    before = len(libraries)
    assert not starter.is_offered(bpy.context)
    for _ in range(2):
        assert bpy.ops.measured_brdf.add_starter_library() == {"FINISHED"}
        assert len(libraries) == before + 1
    assert libraries[starter.NAME].path == str(starter.SHIPPED)
    assert starter.is_offered(bpy.context)
    libraries[starter.NAME].path = "/somewhere/else"        # of an older installation
    assert not starter.is_offered(bpy.context)
    assert bpy.ops.measured_brdf.add_starter_library() == {"FINISHED"}
    assert libraries[starter.NAME].path == str(starter.SHIPPED)
    libraries.remove(libraries[starter.NAME])


def test_a_library_that_is_not_there_is_built_by_a_second_blender(blender, starter, monkeypatch, tmp_path):
    """The command is only looked at: the fixture has run it."""
    from measured_brdf.addon.starter import operators as library

    asked = []

    class Command:
        def __init__(self, *arguments):
            asked.append([*map(str, arguments)])

        def run(self):
            return {"path": asked[-1][-1]}

    monkeypatch.setattr(starter, "SHIPPED", tmp_path / "nothing")
    monkeypatch.setattr(starter, "own_folder", lambda: tmp_path / "own")
    monkeypatch.setattr(library, "Command", Command)
    before = state()
    assert bpy.ops.measured_brdf.add_starter_library() == {"FINISHED"}
    assert asked == [["starter", "-o", str(tmp_path / "own")]]
    assert state() == before
    libraries = bpy.context.preferences.filepaths.asset_libraries
    assert libraries[starter.NAME].path == str(tmp_path / "own")
    libraries.remove(libraries[starter.NAME])


def test_no_material_reflects_more_light_than_it_gets(blender, extension):
    """A sphere in a white furnace shows the directional albedo: in five rings of equal steps of the cosine."""
    size = 32
    y, x = (np.mgrid[:size, :size] + 0.5) / size * 2 - 1
    radius2 = x ** 2 + y ** 2
    rings = np.where(radius2 < 0.97, np.sqrt(np.maximum(1 - radius2, 0)) * 5 // 1, -1)
    most = {}
    for wanted in extension.fitter.published.materials().values():
        scene = black_scene(size, size, 64, span=2)
        scene.cycles.max_bounces = 0
        background(scene, 1)
        add_sphere()
        bpy.ops.measured_brdf.import_data(filepath=wanted.path, preset="Standard")
        for rendering in ("EXACT", "NODES"):
            extension.addon.materials.material.use_rendering(bpy.context.object.active_material, rendering)
            picture = render(scene)[..., :3]
            assert np.isfinite(picture).all(), wanted.name
            most[wanted.name, rendering] = max(picture[rings == ring].mean(axis=0).max() for ring in range(5))
    for rendering in ("EXACT", "NODES"):
        brightest = sorted((value, name) for (name, how), value in most.items() if how == rendering)[:-4:-1]
        print(f"{rendering}: {', '.join(f'{name} {value:.3f}' for value, name in brightest)}")
    assert len(most) == 200
    assert max(most.values()) < 1.01
