"""A description of photographs as a scene, with a camera, a ball or a flat sample, and lamps."""

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ...fitter import DatasetError
from ...fitter.arrays import FloatArray
from ...fitter.photographs.description.capture_setup import CaptureSetup, SampleSetup, Shot
from ...fitter.photographs.flat.reading import sample_corners
from ...fitter.photographs.rig.camera import CameraView
from ...fitter.photographs.rig.lamps import Scene
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.blender.node_trees import use_nodes
from ..core.shading import look
from ..core.storage import paths
from . import settings as photographs
from .describing import NEAR, position
from .work import SENSOR

_SAMPLES, _IN_VIEW = 64, 16         # per pixel: of renders, and of the 3D view, which else competes with the workers
_PREVIEW = 0.2, 0.2         # albedo and roughness of the ball until it is measured: a highlight to be seen
_HALF = 0.5                 # opacity of the photograph before the ball


def make(described: Scene) -> bpy.types.Scene:
    """Make a scene of that of a description. Raises DatasetError if it has what settings cannot hold: several files of
    a card, say."""
    setup, (height, width) = described.setup, described.view.size
    shots = setup.photographs
    scene = bpy.data.scenes.new(setup.title)
    osl_support.enable(scene)
    scene.cycles.samples, scene.cycles.preview_samples = _SAMPLES, _IN_VIEW
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    settings = photographs.get(scene)
    settings.camera = scene.camera = _camera(scene, setup.camera.sensor_width or SENSOR, described.view.angle)
    settings.camera.matrix_basis = camera_pose(described.view)
    if setup.sample is None:
        settings.ball = _object(scene, "Ball", look.sphere())
        settings.ball.location, settings.ball.scale = described.what.middle, [described.what.size] * 3
        settings.ball.material_slots[0].material = _preview()
    else:
        settings.sample, settings.is_far = _sample(scene, setup.sample), described.is_far
    light = bpy.data.lights.new("Lamp", "POINT")
    light.use_soft_falloff = False          # a ball
    light.shadow_soft_size = setup.lamp.radius
    light.energy = 4 * math.pi              # a radiant intensity of 1
    add(scene, shots, light)
    _store(settings, setup, scene, light)
    settings.samples = str(shots[0].files[0].absolute().with_name(f"{setup.title}.npz"))
    photographs.show(settings)
    return scene


def add(scene: bpy.types.Scene, shots: Sequence[Shot], light: Any) -> None:
    """Add photographs of a description to a scene, each with a lamp that has this light."""
    names = [shot.files[0].stem for shot in shots]
    pictures = [_picture(str(shot.files[0].absolute())) for shot in shots]
    lamps = [_lamp(scene, name, light, not_none(shot.lamp)) for name, shot in zip(names, shots, strict=True)]
    # last, because it is not taken back on an error
    for shot, name, picture, lamp in zip(shots, names, pictures, lamps, strict=True):
        added = photographs.get(scene).photographs.add()
        added.name, added.picture, added.lamp = name, picture, lamp
        exposures = np.zeros(len(shot.files)) if shot.exposures is None else shot.exposures
        for path, exposure in zip(shot.files, exposures, strict=True):
            file = added.files.add()
            file.filepath, file.exposure = str(path.absolute()), exposure


def _picture(path: str) -> bpy.types.Image:
    picture = bpy.data.images.load(path, check_existing=True)
    if bpy.data.filepath and picture.is_editable:       # else Blender does it when the file is saved
        picture.filepath_raw = paths.relative(path, os.path.dirname(bpy.data.filepath))
    return picture


def _camera(scene: bpy.types.Scene, sensor_width: float, angle: float) -> bpy.types.Object:
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width, data.lens = sensor_width, sensor_width / (2 * math.tan(angle / 2))
    background = data.background_images.new()
    background.display_depth, background.alpha = "FRONT", _HALF
    data.show_background_images = True
    return _object(scene, "Camera", data)


def camera_pose(view: CameraView) -> Matrix:
    return Matrix.Translation(Vector(view.position.tolist())) @ Matrix(view.orientation.tolist()).to_4x4()


def _sample(scene: bpy.types.Scene, setup: SampleSetup) -> bpy.types.Object:
    """A plane, and an outline of it that is drawn before what the camera sees."""
    mesh, edge = bpy.data.meshes.new("Sample"), bpy.data.meshes.new("Outline")
    mesh.from_pydata(sample_corners(setup).tolist(), [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uv_of_part(mesh, np.array([[0, 0], [1, 1]])))
    mesh.materials.append(_preview())
    edge.from_pydata([vertex.co[:] for vertex in mesh.vertices], [(0, 1), (1, 2), (2, 3), (3, 0)], [])
    item, outline = _object(scene, "Sample", mesh), _object(scene, "Outline", edge)
    outline.parent, outline.show_in_front, outline.hide_select = item, True, True
    for each in (item, outline):        # places of lamps and camera are the sample's
        each.lock_location = each.lock_rotation = each.lock_scale = True, True, True
    return item


def uv_of_part(mesh: bpy.types.Mesh, part: FloatArray) -> FloatArray:
    """The UV coordinates of a sample with which maps lie upon the part of it, (2, 2), that they are of: its lower left
    and its upper right, shares of width and height. Beyond it they are repeated."""
    places = np.array([mesh.vertices[loop.vertex_index].co[:2] for loop in mesh.loops])
    shares = (places - places.min(axis=0)) / np.ptp(places, axis=0)
    return np.asarray((shares - part[0]) / (part[1] - part[0])).ravel()


def _preview() -> bpy.types.Material:
    preview = bpy.data.materials.new("Not Measured")
    surface: Any = next(node for node in use_nodes(preview).nodes if node.type == "BSDF_PRINCIPLED")
    surface.inputs["Base Color"].default_value = (*[_PREVIEW[0]] * 3, 1)
    surface.inputs["Roughness"].default_value = _PREVIEW[1]
    return preview


def _lamp(scene: bpy.types.Scene, name: str, light: bpy.types.Light, at: Any) -> bpy.types.Object:
    item = _object(scene, f"Lamp of {name}", light)
    item.location = at
    return item


def _object(scene: bpy.types.Scene, name: str, data: Any) -> bpy.types.Object:
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item


def _store(settings: Any, setup: CaptureSetup, scene: bpy.types.Scene, light: bpy.types.Light) -> None:
    """Store what no object says."""
    lamp, matrix, scale, surface = setup.lamp, setup.camera.matrix, setup.scale, setup.ball or setup.need_sample()
    values: dict[str, Any] = {
        "dark": _only_file(lamp.dark), "flat": _only_file(lamp.flat), "mask": _only_file(surface.mask),
        "encoding": setup.camera.encoding, "matrix": None if matrix is None else json.dumps(matrix.tolist()),
        "scale": scale.ways[0], "albedo": scale.albedo,
        "intensity": None if scale.intensity is None else np.broadcast_to(scale.intensity, 3)}
    known = scale.card or scale.ball
    if known is not None:
        place = not_none(known.lamp)
        same = (each for each in photographs.lamps(settings) if np.linalg.norm(position(each) - place) < NEAR)
        shown = next(same, None) or _lamp(scene, "the scale", light, place)
        shown.hide_render = shown.hide_viewport = True
        values |= {"known": _only_file(known.file), "known_lamp": shown, "normal": known.normal,
                   "known_albedo": np.broadcast_to(known.albedo, 3),
                   "known_exposure": 0.0 if known.exposures is None else known.exposures[0],
                   "region": None if known.region is None else known.region.astype(int).tolist()}
    if setup.sample is not None:
        outline, size = setup.sample.outline, (scene.render.resolution_y, scene.render.resolution_x)
        values |= {"corners": np.ravel(not_none(setup.sample.corners)).tolist(), "texels": round(setup.texels or 0),
                   "drawn_outline": None if outline is None else _mask("Outline", outline, size),
                   "finds_brightness": isinstance(lamp.brightness, str),
                   "count": str(setup.materials) if isinstance(setup.materials, int) else None}
        if isinstance(lamp.brightness, np.ndarray):
            for shot, brightness in zip(settings.photographs, lamp.brightness, strict=True):
                shot.brightness = brightness
    for name, value in values.items():
        if value is not None:
            setattr(settings, name, value)


def _only_file(files: Sequence[Path] | None) -> str | None:
    if files and len(files) > 1:
        raise DatasetError(f"{len(files)} files found, expected one: a scene holds several exposures of photographs "
                           f"alone", files[0])
    return str(files[0].absolute()) if files else None


def _mask(name: str, outline: FloatArray, size: tuple[int, int]) -> bpy.types.Mask:
    """A mask of a polygon, (n, 2) pixels from the left and the top of pictures of a height and width."""
    mask = bpy.data.masks.new(name)
    spline = mask.layers.new().splines.new()
    spline.use_cyclic = True
    spline.points.add(len(outline) - len(spline.points))
    for point, place in zip(spline.points, outline, strict=True):
        at = 0.5 + (place - np.array(size[::-1]) / 2) / max(size) * (1, -1)
        point.handle_left_type = point.handle_right_type = "FREE"
        point.co = point.handle_left = point.handle_right = at.tolist()
    return mask
