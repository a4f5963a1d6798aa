"""Renders a measured material in a small scene: a sphere, a key light, a uniform sky."""

import errno
import math
from pathlib import Path

import bmesh
import bpy

from ..materials import osl_support

_NAME = "Measured BRDF Studio"
_END = b"IEND\xaeB`\x82"              # of a PNG


def render(material: bpy.types.Material, path: Path, size: int, samples: int) -> None:
    """Render a sphere of a material with Cycles into a .png; OSError if that cannot be written."""
    scene = bpy.data.scenes.get(_NAME) or _build()
    scene.objects[f"{_NAME} Sphere"].material_slots[0].material = material
    scene.cycles.samples = samples
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.read_bytes().endswith(_END):        # Blender does not tell
        raise OSError(errno.EIO, "it could not be written whole; the disk may be full", str(path))


def _build() -> bpy.types.Scene:
    scene = bpy.data.scenes.new(_NAME)
    osl_support.enable(scene)
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0
    scene.cycles.use_denoising = False
    scene.render.image_settings.file_format = "PNG"
    scene.world = bpy.data.worlds.new(_NAME)
    scene.world.color = (0.1, 0.1, 0.1)
    mesh = bpy.data.meshes.new(_NAME)
    _sphere(mesh)
    mesh.materials.append(None)
    camera = bpy.data.cameras.new(_NAME)
    camera.type, camera.ortho_scale = "ORTHO", 2.1
    sun = bpy.data.lights.new(_NAME, "SUN")
    sun.energy, sun.angle = 3.0, math.radians(2)
    _add(scene, f"{_NAME} Sphere", mesh)
    scene.camera = _add(scene, "Camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 0), (math.pi / 2, 0, 0)
    _add(scene, "Sun", sun).rotation_euler = (math.radians(50), 0, math.radians(-40))
    return scene


def _sphere(mesh: bpy.types.Mesh) -> None:
    shape = bmesh.new()
    bmesh.ops.create_uvsphere(shape, u_segments=128, v_segments=64, radius=1)
    for face in shape.faces:
        face.smooth = True
    shape.to_mesh(mesh)
    shape.free()


def _add(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item
