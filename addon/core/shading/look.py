"""Renders a material with Cycles on a sphere or a shader ball, in a studio, under a sky, or in a given world.

All are surfaces of revolution about their Z axis, from which anisotropic materials take their direction.
"""

import errno
import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from contextvars import copy_context
from pathlib import Path
from typing import Any, NamedTuple

import bmesh
import bpy
import numpy as np
from bpy.app.handlers import persistent
from mathutils import Matrix, Vector

from ....fitter import progress
from ....fitter.arrays import FloatArray, SingleArray
from ..annotations import Vector3, not_none
from ..blender import osl_support
from ..blender.node_trees import use_nodes
from ..blender.previews import image_pixels

SPHERE, BALL = "SPHERE", "BALL"
STUDIO, SKY, WORLD = "STUDIO", "SKY", "WORLD"
SHAPES = ((SPHERE, "Sphere", "A sphere, as on thumbnails"),
          (BALL, "Shader Ball", "A ball with a groove, on a stand"))
LIGHTINGS = ((STUDIO, "Studio", "Three area lights before a grey floor"),
             (SKY, "Sky", "Blender's Sky Texture, with the sun"),
             (WORLD, "World", "The world of this scene"))

MATERIALS_FILE = "materials.blend"
_REQUEST = "request.json"
_LOOK_NAME = "Measured BRDF Look"
_SUBJECT, _FLOOR_NAME = f"{_LOOK_NAME} Subject", f"{_LOOK_NAME} Floor"
_SEGMENTS = 128
_GROOVE = math.radians(58), math.radians(7), 0.06       # of the ball: its polar angle, half its width, and its depth
_TILT = math.radians(-28)                               # of the ball, toward the camera
_BALL_AT = 1.28                                         # height of the middle of the ball, m
_FLOOR_ALBEDO = 0.3                                     # albedo of the floor
_SUN = math.radians(38), math.radians(140)              # elevation and rotation of the sky's sun
_SKY_STRENGTH = 0.06
_EXTENT = 1000.0                                        # of the floor under a sky, m
_SHARP_EDGE = math.radians(40)                          # edges beyond this angle are
_CAMERA = {STUDIO: (0.0, -9.5, 3.2), SKY: (0.0, -9.8, 1.7), WORLD: (0.0, -9.8, 1.7)}
_SCENE_LIGHTS = (((-4.0, -3.5, 5.0), 2.5, 420.0), ((5.0, -3.0, 2.5), 3.0, 110.0), ((2.0, 4.0, 5.0), 2.0, 300.0))
"""Of the studio: place, diameter (m) and power (W)."""
_PNG_END = b"IEND\xaeB`\x82"          # of a PNG
_SAMPLE = re.compile(r"Sample (\d+)/(\d+)")


class Request(NamedTuple):
    """What is rendered of the materials in a .blend that are named."""

    materials: list[str]
    world: str          # the name of the one that gives the light; empty where `lighting` is not WORLD
    shape: str
    lighting: str
    size: int           # pixels on a side
    samples: int        # per pixel
    transform: str      # this and the exposure, in stops, are of the view
    exposure: float


def write_request(folder: Path, request: Request) -> None:
    """Write what `answer` is to render, beside `MATERIALS_FILE`."""
    (folder / _REQUEST).write_text(json.dumps(request._asdict()), "utf-8")


def answer(folder: Path) -> None:
    """Render the materials of a folder's `MATERIALS_FILE`, as its request says. `pictures` reads them."""
    progress.report(0.0, "Opening")
    request = Request(**json.loads((folder / _REQUEST).read_text("utf-8")))
    with bpy.data.libraries.load(str(folder / MATERIALS_FILE), link=False) as (_, target):
        target.materials, target.worlds = list(request.materials), [request.world] if request.world else []
    if None in (*target.materials, *target.worlds):
        raise ValueError(f"{folder / MATERIALS_FILE}: expected "
                         f"{', '.join(filter(None, (*request.materials, request.world)))}")
    world = target.worlds[0] if request.world else None
    scene = scene_for(request.shape, request.lighting, world, request.size, request.samples)
    if world is not None:
        scene.view_settings.exposure = request.exposure
        with suppress(TypeError):               # another OpenColorIO configuration has other transforms
            scene.view_settings.view_transform = request.transform
    for number, material in enumerate(progress.each(target.materials)):
        np.save(folder / f"{number}.npy", render(scene, material, folder / "render.png"))


def pictures(folder: Path, count: int) -> list[SingleArray]:
    """What `answer` has rendered: (size, size, 4) each."""
    return [np.load(folder / f"{number}.npy", allow_pickle=False) for number in range(count)]


def scene_for(shape: str, lighting: str, world: bpy.types.World | None, size: int, samples: int) -> bpy.types.Scene:
    """A scene to look at materials in, for `render`: one of `SHAPES` and of `LIGHTINGS`, of which WORLD takes a world;
    pixels on a side, and samples per pixel."""
    scene = bpy.data.scenes.new(_LOOK_NAME)
    osl_support.enable(scene)
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0
    scene.cycles.caustics_reflective = False        # of the floor: noise
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = samples, False, "CPU"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard" if lighting == STUDIO else "AgX"
    scene.world = world if lighting == WORLD else _sky() if lighting == SKY else _world((0.5, 0.5, 0.5, 1), 0.15)[0]
    if shape == BALL:
        _add(scene, _SUBJECT, _lathe(_ball_profile())).matrix_world = (
            Matrix.Translation((0, 0, _BALL_AT)) @ Matrix.Rotation(_TILT, 4, "X"))
        _add(scene, _SUBJECT, _lathe(_stand_profile()))
    else:
        _add(scene, _SUBJECT, sphere()).location.z = 1
    if lighting != WORLD:
        _add(scene, _FLOOR_NAME, _backdrop() if lighting == STUDIO else _floor(
            [(-_EXTENT, -_EXTENT, 0), (_EXTENT, -_EXTENT, 0), (_EXTENT, _EXTENT, 0), (-_EXTENT, _EXTENT, 0)],
            [(0, 1, 2, 3)]))
    for place, width, power in _SCENE_LIGHTS if lighting == STUDIO else ():
        light = bpy.data.lights.new(_LOOK_NAME, "AREA")
        light.shape, light.size, light.energy = "DISK", width, power
        _add_aimed(scene, light, place, 1)
    camera = bpy.data.cameras.new(_LOOK_NAME)
    height, camera.lens = (1.12, 112) if shape == BALL else (1.0, 122)      # that it looks at, and mm
    scene.camera = _add_aimed(scene, camera, _CAMERA[lighting], height)
    return scene


def render(scene: bpy.types.Scene, material: bpy.types.Material, path: Path) -> SingleArray:
    """Render a material in a scene of `scene_for` into a .png: (size, size, 4), sRGB, the bottom row first, or OSError.
    """
    for item in scene.objects:
        if item.name.startswith(_SUBJECT):
            item.material_slots[0].material = material
    scene.render.filepath = str(path)
    with _report_progress():
        bpy.ops.render.render(write_still=True, scene=scene.name)
    if not path.read_bytes().endswith(_PNG_END):    # Blender does not tell
        raise OSError(errno.EIO, "it could not be written whole; the disk may be full", str(path))
    image = bpy.data.images.load(str(path))
    picture = image_pixels(image)
    bpy.data.images.remove(image)
    return picture


@contextmanager
def _report_progress() -> Iterator[None]:
    here = copy_context()

    @persistent
    def on_stats(statistics: Any, *_: object) -> None:      # in the thread that renders
        sample = _SAMPLE.search(str(statistics))
        if sample is not None:
            here.run(progress.report, int(sample[1]) / int(sample[2]), "Rendering")

    progress.report(0.0, "Rendering")
    bpy.app.handlers.render_stats.append(on_stats)
    try:
        yield
    finally:
        bpy.app.handlers.render_stats.remove(on_stats)


def _add(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item


def _ball_profile() -> FloatArray:
    """A ball of the radius 1 with a groove: (n, 2) radii and heights, from the bottom to the top."""
    theta = np.linspace(math.pi, 0, 193)
    at, half_width, depth = _GROOVE
    groove = np.where(np.abs(theta - at) < half_width, (1 + np.cos(math.pi * (theta - at) / half_width)) / 2, 0)
    radius = 1 - depth * groove
    return np.stack([radius * np.sin(theta), radius * np.cos(theta)], axis=-1)


def sphere() -> bpy.types.Mesh:
    """A unit sphere with a UV map, and a slot for a material."""
    theta = np.linspace(math.pi, 0, 97)
    return _lathe(np.stack([np.sin(theta), np.cos(theta)], axis=-1))


def _stand_profile() -> FloatArray:
    """A foot with rounded edges and a neck that reaches into the ball."""
    round_off = np.linspace(0, math.pi / 2, 9)
    lower = np.stack([0.76 + 0.04 * np.sin(round_off), 0.04 - 0.04 * np.cos(round_off)], axis=-1)
    upper = np.stack([0.76 + 0.04 * np.cos(round_off), 0.11 + 0.04 * np.sin(round_off)], axis=-1)
    neck = np.stack([0.44 - 0.16 * np.sin(round_off), 0.31 - 0.16 * np.cos(round_off)], axis=-1)
    return np.concatenate([[[0, 0]], lower, upper, neck, [[0.28, 0.42]]])


def _lathe(profile: FloatArray) -> bpy.types.Mesh:
    """A surface of revolution about the Z axis, with a UV map: U around, V along the profile."""
    rings, turn = len(profile), np.linspace(0, 2 * math.pi, _SEGMENTS + 1)
    places = np.stack([np.outer(profile[:, 0], np.cos(turn)), np.outer(profile[:, 0], np.sin(turn)),
                       np.repeat(profile[:, 1:], _SEGMENTS + 1, axis=1)], axis=-1).reshape(-1, 3)
    ring, step = (grid.ravel() for grid in np.meshgrid(np.arange(rings - 1), np.arange(_SEGMENTS), indexing="ij"))
    first = ring * (_SEGMENTS + 1) + step
    faces = np.stack([first, first + 1, first + _SEGMENTS + 2, first + _SEGMENTS + 1], axis=-1)
    along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    uv = np.stack([faces % (_SEGMENTS + 1) / _SEGMENTS, along[faces // (_SEGMENTS + 1)] / along[-1]], axis=-1)
    mesh = bpy.data.meshes.new(_LOOK_NAME)
    mesh.from_pydata(places.tolist(), [], faces.tolist())
    mesh.uv_layers.new().uv.foreach_set("vector", uv.astype(np.float32).ravel())
    mesh.materials.append(None)
    shape = bmesh.new()
    shape.from_mesh(mesh)
    bmesh.ops.remove_doubles(shape, verts=shape.verts[:], dist=1e-6)    # the poles and the seam
    for face in shape.faces:
        face.smooth = True
    shape.to_mesh(mesh)
    shape.free()
    mesh.set_sharp_from_angle(angle=_SHARP_EDGE)
    return mesh


def _backdrop() -> bpy.types.Mesh:
    """A floor that bends into a wall behind the subject."""
    bend = np.linspace(0, math.pi / 2, 17)
    depth = np.concatenate([[-30], 5 + 4 * np.sin(bend), [9]])
    height = np.concatenate([[0], 4 - 4 * np.cos(bend), [30]])
    places = [(x, y, z) for y, z in zip(depth.tolist(), height.tolist(), strict=True) for x in (-40.0, 40.0)]
    return _floor(places, [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(depth) - 1)])


def _floor(places: list[Vector3], faces: list[tuple[int, int, int, int]]) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(_LOOK_NAME)
    mesh.from_pydata(places, [], faces)
    for polygon in mesh.polygons:
        polygon.use_smooth = True
    material = bpy.data.materials.new(_FLOOR_NAME)
    _add_surface(material, "BsdfDiffuse", "OutputMaterial", (_FLOOR_ALBEDO, _FLOOR_ALBEDO, _FLOOR_ALBEDO, 1))
    mesh.materials.append(material)
    return mesh


def _add_aimed(scene: bpy.types.Scene, data: bpy.types.Light | bpy.types.Camera, place: Vector3,
               height: float) -> bpy.types.Object:
    """Add a lamp or a camera at a place, turned to a height above the origin."""
    item = _add(scene, _LOOK_NAME, data)
    toward = Vector(place) - Vector((0, 0, height))
    item.location, item.rotation_euler = place, toward.to_track_quat("Z", "Y").to_euler()
    return item


def _world(color: tuple[float, float, float, float], strength: float) -> tuple[bpy.types.World, bpy.types.Node]:
    """An even world, and the node that makes it."""
    world = bpy.data.worlds.new(_LOOK_NAME)
    background = _add_surface(world, "Background", "OutputWorld", color)
    background.inputs["Strength"].default_value = strength
    return world, background


def _sky() -> bpy.types.World:
    world, background = _world((0.5, 0.5, 0.5, 1), _SKY_STRENGTH)
    sky: Any = not_none(world.node_tree).nodes.new("ShaderNodeTexSky")
    kinds = sky.bl_rna.properties["sky_type"].enum_items.keys()
    sky.sky_type = next(kind for kind in ("MULTIPLE_SCATTERING", "NISHITA") if kind in kinds)
    sky.sun_elevation, sky.sun_rotation = _SUN
    not_none(world.node_tree).links.new(sky.outputs["Color"], background.inputs["Color"])
    return world


def _add_surface(owner: bpy.types.Material | bpy.types.World, kind: str, output: str,
                 color: tuple[float, float, float, float]) -> bpy.types.Node:
    tree = use_nodes(owner)
    tree.nodes.clear()
    node, end = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new(f"ShaderNode{output}")
    node.inputs["Color"].default_value = color
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return node
