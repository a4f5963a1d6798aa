"""The starter library: built into a folder, with materials that render anywhere and are compiled when they are used."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.blender import osl_support
from measured_brdf.addon.core.shading import material, node_group, rendered
from measured_brdf.addon.starter import operators as library
from measured_brdf.fitter.model import published

from fitter.imaging.pictures import thumbnail
from fitter.library import ready
from support.blend_state import state
from support.cases import release
from support.checkout import ROOT
from support.stage import add_sphere, background, black_scene, render

pytestmark = release


@pytest.fixture
def built():
    """The folder of the library, as `make zip` builds it, and `make test-all` before it runs this."""
    out = ROOT / "starter_library"
    if not (out / "starter.blend").is_file():
        pytest.skip("`make zip` makes the library")
    return out


@pytest.fixture
def starter(extension, built, monkeypatch):
    from measured_brdf.addon.starter import starter

    monkeypatch.setattr(starter, "SHIPPED", built)
    return starter


@pytest.fixture
def compiling(extension):
    """The module that compiles."""
    from measured_brdf.addon.starter import compiling

    compiling._failed.clear()
    yield compiling
    compiling._failed.clear()


def append(starter, name, link=False):
    with bpy.data.libraries.load(str(starter.SHIPPED / starter.FILE), link=link, assets_only=True) as (_, target):
        target.materials = [name]
    return target.materials[0]


def test_it_holds_an_asset_of_each_material_that_is_offered_and_takes_seventy_kilobytes_for_each(blender, starter):
    from measured_brdf.fitter.library import ready

    with bpy.data.libraries.load(str(starter.SHIPPED / starter.FILE), assets_only=True) as (source, _):
        assert sorted(source.materials) == sorted(each.label for each in published.list_offered())
    assert all(ready.is_there(each.name) for each in published.list_offered())
    assert sum(path.stat().st_size for path in starter.SHIPPED.iterdir()) < 0.07e6 * len(published.list_offered())


def test_the_assets_are_cc0_and_hold_no_byte_code(blender, starter):
    bpy.ops.wm.open_mainfile(filepath=str(starter.SHIPPED / starter.FILE))
    assert {item.asset_data.license for item in bpy.data.materials if item.asset_data} == {"CC0-1.0"}
    trees = [*bpy.data.node_groups, *(item.node_tree for item in bpy.data.materials)]
    assert not [node for tree in trees for node in tree.nodes if node.type == "SCRIPT" and node.bytecode]


def test_each_asset_has_tags_a_picture_and_says_that_it_is_not_measured(blender, starter):
    catalogues = (starter.SHIPPED / "blender_assets.cats.txt").read_text("utf-8")
    bpy.ops.wm.open_mainfile(filepath=str(starter.SHIPPED / starter.FILE))
    for wanted in published.list_offered():
        item = bpy.data.materials[wanted.label]
        data, settings = item.asset_data, item.measured_brdf
        assert {*wanted.tags, *(() if wanted.is_computed else ("published fit",))} <= {tag.name for tag in data.tags}
        assert "not a measurement" in data.description
        assert wanted.source in data.description
        assert f"{data.catalog_id}:Measured BRDF/Starter/" in catalogues
        assert material.is_measured(item)
        levels = "(3,4,92.5)" if ready.find(wanted.name).fit.isotropic else "(2,3,89.4679)"
        assert (settings.filepath, settings.preset, settings.fitted_levels) == (wanted.path, "Standard", levels)
        assert tuple(item.preview.image_size) == (128, 128)
        pixels = np.empty(128 * 128 * 4, np.float32)
        item.preview.image_pixels_float.foreach_get(pixels)
        rendered = thumbnail(wanted._replace(model=ready.find(wanted.name).fit), 128)
        rms = np.sqrt(np.mean((pixels.reshape(128, 128, 4) - rendered) ** 2))
        assert rms < 0.04       # the picture is of the published model; the fit of two-layer-gold is .032 from it


# The camera looks straight down at a plane, and a sun of irradiance pi stands at an angle
_WITHOUT_EXTENSION = """
import math, sys
import bpy

library, name, how, picture, *angles = sys.argv[1:]
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
with bpy.data.libraries.load(library, link=how == "link", assets_only=True) as (_, target):
    target.materials = [name]
assert not hasattr(bpy.types.Material, "measured_brdf")
bpy.ops.mesh.primitive_plane_add()
bpy.context.object.data.materials.append(target.materials[0])
sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
sun.data.energy, sun.data.angle = math.pi, 0.5
camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.1, (0, 0, 3)
for item in (sun, camera):
    scene.collection.objects.link(item)
scene.camera = camera
scene.render.resolution_x = scene.render.resolution_y = 8
scene.render.image_settings.file_format = "OPEN_EXR"
scene.cycles.samples, scene.cycles.use_denoising = 64, False
scene.eevee.taa_render_samples = 4          # of the 64 by default each test takes 40 s longer
for engine in ("CYCLES", "BLENDER_EEVEE"):
    scene.render.engine = engine
    for angle in map(float, angles):
        sun.rotation_euler = (0, math.radians(angle), 0)
        scene.render.filepath = picture
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(picture)
        pixels = image.pixels[:]
        print("PIXEL", engine, angle, *[sum(pixels[channel::4]) / 64 for channel in range(3)])
        bpy.data.images.remove(image)
"""


@pytest.mark.parametrize("how", ["append", "link"])
def test_without_the_extension_an_asset_shows_its_published_model(built, tmp_path, how):
    """The mean of the formula over the sun's disk, in directions away from the highlight; closures come close."""
    from fitter.model import published

    wanted, angles = published.find("pink-plastic"), (30, 50)
    done = subprocess.run([sys.executable, "-c", _WITHOUT_EXTENSION, built / "starter.blend", wanted.label, how,
                           tmp_path / "a.exr", *map(str, angles)], capture_output=True, text=True, check=False,
                          env={**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path)}, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if line.startswith("PIXEL")]
    assert len(rows) == 4
    for _, engine, angle, *pixel in rows:
        theta = np.radians(float(angle))
        expected = np.pi * np.cos(theta) * wanted.model.evaluate(theta, 0, 0, 0)
        np.testing.assert_allclose(list(map(float, pixel)), expected, rtol=0.15, err_msg=f"{engine} {angle}")


def test_an_asset_is_compiled_when_an_object_begins_to_use_it(blender, starter, compiling):
    osl_support.enable(bpy.context.scene)
    item = append(starter, "Red fabric")
    assert rendered.scene_rendering(item, bpy.context.scene).how == "NODES"
    assert "not compiled" in rendered.scene_rendering(item, bpy.context.scene).why
    assert not rendered.scene_rendering(item, bpy.context.scene).can_enable
    assert rendered.rendering_words(rendered.scene_rendering(item, bpy.context.scene)) == "Nodes: not compiled yet"
    assert compiling.compile_used() == 0                    # nothing uses it
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(item)
    before = node_group.kept_fit(material.group_node(item).node_tree)
    assert compiling.compile_used() == 1
    tree = material.group_node(item).node_tree
    assert node_group.is_compiled(tree)
    assert node_group.kept_fit(tree) == before
    assert rendered.scene_rendering(item, bpy.context.scene).how == "EXACT"
    assert [each.name for each in bpy.data.node_groups if node_group.script_node(each)] == ["Red fabric"]
    assert compiling.compile_used() == 0
    bpy.ops.measured_brdf.use_published(name="red-fabric")
    assert material.group_node(bpy.context.object.active_material).node_tree == tree      # the same shader


def test_what_another_file_owns_is_not_compiled_until_it_is_made_local(blender, starter, compiling):
    bpy.ops.mesh.primitive_cube_add()
    item = append(starter, "Red fabric", link=True)
    bpy.context.object.data.materials.append(item)
    assert compiling.compile_used() == 0
    item.make_local(clear_liboverride=True)
    item = bpy.context.object.active_material
    material.group_node(item).node_tree.make_local()
    assert compiling.compile_used() == 1
    assert node_group.is_compiled(material.group_node(item).node_tree)


def test_an_asset_with_another_fit_is_left_to_the_update(blender, starter, compiling):
    bpy.ops.mesh.primitive_cube_add()
    item, other = (append(starter, name) for name in ("Red fabric", "Pink felt"))
    bpy.context.object.data.materials.append(item)
    tree = material.group_node(item).node_tree
    del tree["fit"]
    tree["fit"] = node_group.kept_fit(material.group_node(other).node_tree)
    assert compiling.compile_used() == 1
    assert not node_group.is_compiled(tree)
    assert compiling.compile_used() == 0                    # it is not tried for ever
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert node_group.is_compiled(material.group_node(item).node_tree)


def test_without_a_window_nothing_is_compiled_by_itself(blender, starter, compiling):
    bpy.ops.mesh.primitive_cube_add()
    bpy.context.object.data.materials.append(append(starter, "Red fabric"))
    bpy.context.view_layer.update()
    assert compiling._on_change in bpy.app.handlers.depsgraph_update_post
    assert not bpy.app.timers.is_registered(compiling._tick)


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
    assert libraries[starter.LIBRARY_NAME].path == str(starter.SHIPPED)
    assert starter.is_offered(bpy.context)
    assert libraries[starter.LIBRARY_NAME].import_method == "APPEND"
    libraries[starter.LIBRARY_NAME].path = "/somewhere/else"  # of an older installation
    libraries[starter.LIBRARY_NAME].import_method = "LINK"
    assert not starter.is_offered(bpy.context)
    assert bpy.ops.measured_brdf.add_starter_library() == {"FINISHED"}
    assert libraries[starter.LIBRARY_NAME].path == str(starter.SHIPPED)
    assert libraries[starter.LIBRARY_NAME].import_method == "APPEND"
    libraries.remove(libraries[starter.LIBRARY_NAME])


def test_a_library_that_is_not_there_is_built_by_a_second_blender(blender, starter, monkeypatch, tmp_path):
    """The command is only looked at: the fixture has run it."""
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
    assert libraries[starter.LIBRARY_NAME].path == str(tmp_path / "own")
    libraries.remove(libraries[starter.LIBRARY_NAME])


def test_no_material_reflects_more_light_than_it_gets(blender, extension):
    """A sphere in a white furnace shows the directional albedo: in five rings of equal steps of the cosine. All spheres
    are in one picture, where no light goes from one to another."""
    offered, size, columns = extension.fitter.model.published.list_offered(), 32, 12
    rows = -(-len(offered) // columns)
    scene = black_scene(columns * size, rows * size, 64, span=2 * max(rows, columns))
    scene.cycles.max_bounces = 0
    background(scene, 1)
    for number, wanted in enumerate(offered):
        row, column = divmod(number, columns)
        add_sphere().location = 2 * column + 1 - columns, rows - 1 - 2 * row, 0
        bpy.ops.measured_brdf.use_published(name=wanted.name)
    y, x = (np.mgrid[:size, :size] + 0.5) / size * 2 - 1
    radius2 = x ** 2 + y ** 2
    rings = np.where(radius2 < 0.97, np.sqrt(np.maximum(1 - radius2, 0)) * 5 // 1, -1)
    for rendering in ("EXACT", "NODES"):
        for item in scene.objects:
            if item.type == "MESH":
                extension.addon.core.shading.material.use_rendering(item.active_material, rendering)
        picture = render(scene)[..., :3]
        assert np.isfinite(picture).all()
        tiles = picture.reshape(rows, size, columns, size, 3).swapaxes(1, 2).reshape(-1, size, size, 3)
        most = {wanted.name: max(tile[rings == ring].mean(axis=0).max() for ring in range(5))
                for wanted, tile in zip(offered, tiles, strict=False)}
        brightest = sorted((value, name) for name, value in most.items())[:-4:-1]
        print(f"{rendering}: {', '.join(f'{name} {value:.3f}' for value, name in brightest)}")
        assert len(most) == len(offered)
        assert 0 < min(most.values()) < max(most.values()) < 1.01
