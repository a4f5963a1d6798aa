"""Rendering as on a farm, with Blender and a .blend, without the extension and the measurements."""

import json
import math

import pytest

from support.checkout import run_python
from support.stage import add_lamp, add_sphere, black_scene, render
from tools import fuzz

RENDER = """
import json, sys
import bpy
from support.stage import render
bpy.ops.wm.open_mainfile(filepath=sys.argv[1], use_scripts=False)
assert not hasattr(bpy.types.Material, "measured_brdf")
if len(sys.argv) > 2:
    bpy.context.scene.frame_set(int(sys.argv[2]))
print(json.dumps(render(bpy.context.scene)[..., :3].mean(axis=(0, 1)).tolist()))
"""


def measured_sphere(blender, folder):
    """A scene of a sphere of measurements that are gone."""
    measurements = folder / "made.astm"
    measurements.write_bytes(fuzz.seeds()["astm, made"])
    scene = black_scene(24, 24, samples=32, span=2)
    add_sphere()
    blender.ops.measured_brdf.import_data(filepath=str(measurements), diffuse_level=3, specular_level=5)
    measurements.unlink()
    return scene


def mean_elsewhere(blender, folder, *frame):
    """The mean colour of the scene, saved, as a Blender without the extension renders it."""
    blender.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    done = run_python("-c", RENDER, folder / "scene.blend", *frame)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def mean_here(scene):
    return render(scene)[..., :3].mean(axis=(0, 1))


def test_a_blend_renders_where_neither_the_extension_nor_the_measurements_are(blender, tmp_path):
    scene = measured_sphere(blender, tmp_path)
    add_lamp("POINT", 100, (2, 1, 4), shadow_soft_size=0)
    add_lamp("SUN", math.pi, rotation=(0.5, 0, 0), angle=0.01)
    here = mean_here(scene)
    assert mean_elsewhere(blender, tmp_path) == pytest.approx(here.tolist(), rel=1e-4)
    assert here.min() > 0.01


def test_a_lamp_without_a_size_is_followed_where_the_extension_is_not(blender, tmp_path):
    """At a frame other than the saved one; were the lamp unknown, only the mixture would be visible."""
    scene = measured_sphere(blender, tmp_path)
    scene.cycles.max_bounces = 0
    sun = add_lamp("SUN", math.pi, angle=0)
    for frame, lean in ((1, -0.9), (10, 0.9)):
        sun.rotation_euler = (0, lean, 0)
        sun.keyframe_insert("rotation_euler", frame=frame)
    scene.frame_set(1)
    there = mean_elsewhere(blender, tmp_path, "10")
    # a lamp at rest, which nothing has to follow
    sun.animation_data_clear()
    sun.rotation_euler = (0, 0.9, 0)
    assert there == pytest.approx(mean_here(scene).tolist(), rel=1e-3)
