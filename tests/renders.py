"""Scenes and renders for tests: a picture as an array, a number for each pixel from OSL, spheres under lights."""

import math
import tempfile
from pathlib import Path

import numpy as np


def empty_scene(bpy, width, height, samples):
    """A black Cycles scene with an orthographic camera above the origin; one unit is as wide as the picture."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = scene.cycles.sample_clamp_direct = 0
    scene.cycles.max_bounces = 0
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = width, height
    camera = bpy.data.cameras.new("Camera")
    camera.type = "ORTHO"
    scene.camera = bpy.data.objects.new("Camera", camera)
    scene.camera.location = (0, 0, 10)
    scene.collection.objects.link(scene.camera)
    world = bpy.data.worlds.new("World")
    scene.world = world
    if not world.node_tree:
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    return scene


def render(bpy, scene):
    """Render to (height, width, 3) float32, the bottom row first."""
    with tempfile.TemporaryDirectory() as folder:
        settings = scene.render.image_settings
        settings.file_format, settings.color_depth = "OPEN_EXR", "32"
        scene.render.filepath = str(Path(folder) / "picture.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(len(image.pixels), dtype=np.float32)
        image.pixels.foreach_get(pixels)
        picture = pixels.reshape(image.size[1], image.size[0], image.channels)[..., :3].copy()
        bpy.data.images.remove(image)
    return picture


def add_lamp(bpy, scene, kind, energy, location=(0, 0, 0), rotation=(0, 0, 0), **settings):
    """A lamp in the scene."""
    light = bpy.data.lights.new("Lamp", kind)
    light.energy = energy
    for name, value in settings.items():
        setattr(light, name, value)
    lamp = bpy.data.objects.new("Lamp", light)
    lamp.location, lamp.rotation_euler = location, rotation
    scene.collection.objects.link(lamp)
    return lamp


PROBE = """
#include "baked_constants.h"
#include "perfect_hash.h"
#include "lattice.h"
#include "draw.h"
#include "lamps.h"

shader probe(output closure color Result = 0)
{
#include "baked_tables.h"
%s
  int pixel = (int)floor(P[1]) * %d + (int)floor(P[0]);
  color out = 0.0;
  %s
  Result = out * emission();
}
"""


def probe_osl(bpy, fit, bake, code, count, **tables):
    """Run OSL code inside Cycles, once a pixel.

    Parameters
    ----------
    fit
        Its tables are at the code's disposal, and the project's OSL headers.
    bake : callable
        `fitter.bake.bake`.
    code : str
        Reads `pixel`, writes `out`, which must not be negative.
    count : int
        How many pixels are asked for.
    tables : name to array
        More arrays for the code to read.

    Returns
    -------
    (count, 3) float32
    """
    from fitter.bake import _array

    width = math.ceil(math.sqrt(count))
    source = bake(fit, PROBE % ("".join(_array(name, table) for name, table in tables.items()), width, code))
    scene = empty_scene(bpy, width, width, samples=1)
    scene.camera.data.ortho_scale = width
    scene.camera.location = (width / 2, width / 2, 10)
    scene.cycles.pixel_filter_type = "BOX"
    bpy.ops.mesh.primitive_plane_add(size=2 * width, location=(width / 2, width / 2, 0))
    text = bpy.data.texts.new("probe.osl")
    text.from_string(source)
    material = bpy.data.materials.new("probe")
    if not material.node_tree:
        material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    script, output = nodes.new("ShaderNodeScript"), nodes.new("ShaderNodeOutputMaterial")
    script.mode, script.script = "INTERNAL", text
    assert "Result" in script.outputs, "the probe does not compile"
    material.node_tree.links.new(script.outputs["Result"], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    return render(bpy, scene).reshape(-1, 3)[:count]
