"""The studio of the thumbnails as the world of a scene."""

import math
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.shading import material as materials
from measured_brdf.addon.core.shading import node_group
from measured_brdf.addon.panel import menu, rendering

from fitter import Fit
from fitter.imaging import studio
from support.drawn import Layout
from support.stage import black_scene, render

SIZE = 24


@pytest.fixture
def scene(blender, quick):
    made = black_scene(SIZE, SIZE, samples=256, span=2)
    made.cycles.max_bounces = 0
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48)
    bpy.ops.object.shade_smooth()
    return made


def use(name):
    assert bpy.ops.measured_brdf.use_published(name=name) == {"FINISHED"}
    return bpy.context.object.active_material


@pytest.mark.parametrize("turn", [0.0, 70.0])
def test_the_camera_sees_what_the_thumbnail_shows(scene, turn):
    material = use("chromium-satin")
    angle = math.radians(turn)
    scene.camera.location = 5 * math.sin(angle), -5 * math.cos(angle), 0
    scene.camera.rotation_euler = math.pi / 2, 0, angle
    bpy.context.view_layer.update()
    assert bpy.ops.measured_brdf.add_studio() == {"FINISHED"}
    picture = render(scene)[::-1, :, :3]            # the bottom row first
    place = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    y, x = np.meshgrid(place, place, indexing="ij")
    inside = x ** 2 + y ** 2 < 0.8
    normal = np.stack([x, y, np.sqrt(np.maximum(1 - x ** 2 - y ** 2, 0))], axis=-1)[inside]
    fit = Fit.from_bytes(node_group.kept_fit(materials.group_node(material).node_tree))
    expected, seen = studio.on_sphere(fit, normal), picture[inside]
    assert np.abs(seen - expected).mean() < 0.06 * expected.mean()
    assert np.corrcoef(seen[:, 1], expected[:, 1])[0, 1] > 0.99


def test_it_is_offered_where_a_metal_meets_a_plain_world_and_undone_in_one_step(scene):
    def offered(material):
        layout = Layout()
        rendering.draw_words(layout, SimpleNamespace(scene=scene, screen=None), material)
        return layout.button("Add Studio")

    rubber = use("blue-rubber")
    assert offered(rubber) is None
    gold, former = use("gold-polished"), scene.world
    assert offered(gold).operator == "measured_brdf.add_studio"
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.measured_brdf.add_studio() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="after")
    assert offered(gold) is None
    assert former.use_fake_user, "it is saved with the file"
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert scene.world.name == "World"
    assert [len(items) for items in (bpy.data.worlds, bpy.data.images)] == [1, 0]


def test_the_add_menu_has_it(blender):
    layout = Layout()
    menu.add_studio(SimpleNamespace(layout=layout), None)
    assert layout.button("Measured BRDF Studio").operator == "measured_brdf.add_studio"
    assert menu.add_studio in bpy.types.VIEW3D_MT_light_add._dyn_ui_initialize()
