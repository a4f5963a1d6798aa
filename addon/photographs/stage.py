"""A description of photographs as a scene, with a camera, a ball and lamps; and the description of such a scene.

The description is what `python -m fitter photographs` reads, as `fitter.photographs.capture_setup` has it.
"""

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
from ...fitter.photographs import camera as cameras
from ...fitter.photographs import viewpoint
from ...fitter.photographs.capture_setup import BallSetup, CameraSetup, CaptureSetup, Description, Shot
from ...fitter.photographs.setup import Resolved
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.shading import look, material
from ..core.storage import paths
from . import settings as photographs
from .settings import AS_THE_FILE_SAYS, BALL, GUESS, INTENSITY
from .work import LENS, SENSOR, START

_SAMPLES, _IN_VIEW = 64, 16         # per pixel: of renders, and of the 3D view, which else competes with the workers
_NEAR = 1e-6                # m: an object so near a place is there
_PREVIEW = 0.2, 0.2         # albedo and roughness of the ball until it is measured: a highlight to be seen
_HALF = 0.5                 # opacity of the photograph before the ball


def make(resolved: Resolved) -> bpy.types.Scene:
    """Make a scene of a description whose places are numbers. Raises DatasetError if it has what the settings of a
    scene cannot hold: several files of a card, say.
    """
    setup, (height, width) = resolved
    ball, shots = setup.of_ball(), setup.photographs
    scene = bpy.data.scenes.new(setup.title)
    osl_support.enable(scene)
    scene.cycles.samples, scene.cycles.preview_samples = _SAMPLES, _IN_VIEW
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    settings = photographs.get(scene)
    settings.camera = scene.camera = _camera(scene, setup.camera, not_none(ball.centre))
    settings.ball = _ball(scene, ball)
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


def _camera(scene: bpy.types.Scene, setup: CameraSetup, centre: Any) -> bpy.types.Object:
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = setup.sensor_width or SENSOR
    data.lens = setup.focal_length or LENS
    if setup.field_of_view is not None:
        data.lens = data.sensor_width / (2 * math.tan(math.radians(setup.field_of_view) / 2))
    background = data.background_images.new()
    background.display_depth, background.alpha = "FRONT", _HALF
    data.show_background_images = True
    item = _object(scene, "Camera", data)
    orientation = viewpoint.orientation(setup, centre)
    item.matrix_basis = Matrix.Translation(Vector(_numbers(setup.position))) @ Matrix(orientation.tolist()).to_4x4()
    return item


def _ball(scene: bpy.types.Scene, setup: BallSetup) -> bpy.types.Object:
    item = _object(scene, "Ball", look.sphere())
    item.location, item.scale = _numbers(setup.centre), [not_none(setup.radius)] * 3
    preview = bpy.data.materials.new("Not Measured")
    material.use_nodes(preview)
    surface: Any = next(node for node in not_none(preview.node_tree).nodes if node.type == "BSDF_PRINCIPLED")
    surface.inputs["Base Color"].default_value = (*[_PREVIEW[0]] * 3, 1)
    surface.inputs["Roughness"].default_value = _PREVIEW[1]
    item.material_slots[0].material = preview
    return item


def _numbers(place: Any) -> list[float]:
    """A place of a description in which all are numbers."""
    return np.asarray(place, dtype=float).tolist()


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
    matrix = setup.camera.matrix
    for name, value in (("dark", _one(setup.lamp.dark)), ("flat", _one(setup.lamp.flat)),
                        ("mask", _one(setup.of_ball().mask)), ("encoding", setup.camera.encoding),
                        ("matrix", "" if matrix is None else json.dumps(matrix.tolist()))):
        if value:
            setattr(settings, name, value)
    scale = setup.scale
    settings.scale = scale.way()
    if scale.albedo is not None:
        settings.albedo = scale.albedo
    if scale.intensity is not None:
        settings.intensity = np.broadcast_to(scale.intensity, 3)
    known = scale.card or scale.ball
    if known is not None:
        settings.known, settings.known_albedo = _one(known.file), np.broadcast_to(known.albedo, 3)
        settings.known_exposure = 0.0 if known.exposures is None else known.exposures[0]
        place = not_none(known.lamp)
        settings.known_lamp = next((lamp for lamp in photographs.lamps(settings)
                                    if np.linalg.norm(_place(lamp) - place) < _NEAR), None) or _lamp(
                                        scene, "the scale", light, place)
        settings.known_lamp.hide_render = settings.known_lamp.hide_viewport = True
        if known.normal is not None and known.region is not None:
            settings.normal, settings.region = known.normal, known.region.astype(int).tolist()


def _one(files: Sequence[Path] | None) -> str:
    """The only file; empty where there is none."""
    if files and len(files) > 1:
        raise DatasetError(f"{len(files)} files found, expected one: a scene holds several exposures of photographs "
                           f"alone", files[0])
    return str(files[0].absolute()) if files else ""


def description_of(scene: bpy.types.Scene, shots: Sequence[Any] = (), whole: bool = True) -> Description:
    """The description of some photographs of a scene; by default of those that are used.

    By default it is `whole`: what is to be measured. Else nobody need have placed the lamps, and their intensity is 1.
    Raises ValueError if an object has been deleted, or the whole is not there.
    """
    settings = photographs.get(scene)
    shots = shots or [each for each in settings.photographs if each.used]
    if not shots:
        raise ValueError("No photograph of this scene is used")
    camera, ball = _there(scene, settings.camera, "camera"), _there(scene, settings.ball, "ball")
    pose = np.array(_pose(camera))
    away = pose[:3, :3] / np.linalg.norm(pose[:3, :3], axis=0)
    lens: Any = camera.data
    first = _there(scene, shots[0].lamp, f"lamp of {shots[0].name}")
    light: Any = first.data
    described: Description = {
        "name": scene.name,
        "camera": {"position": pose[:3, 3].tolist(), "look_at": (pose[:3, 3] - away[:, 2]).tolist(),
                   "up": away[:, 1].tolist(),
                   "field_of_view": math.degrees(cameras.field_of_view(lens.lens, lens.sensor_width))},
        "ball": {"centre": _place(ball).tolist(), "radius": settings.radius},
        "lamp": {name: bpy.path.abspath(path) for name, path in (("dark", settings.dark), ("flat", settings.flat))
                 if path},
        "scale": {settings.scale: _scale(scene, settings)} if whole else {INTENSITY: 1.0},
        "photograph": [_shot(scene, each, whole) for each in shots]}
    if light.shadow_soft_size:
        described["lamp"]["radius"] = light.shadow_soft_size
    if settings.mask:
        described["ball"]["mask"] = bpy.path.abspath(settings.mask)
    if settings.encoding not in ("", AS_THE_FILE_SAYS):
        described["camera"]["encoding"] = settings.encoding
    if settings.matrix:
        described["camera"]["matrix"] = _matrix(settings.matrix)
    return described


def _there(scene: bpy.types.Scene, item: bpy.types.Object | None, what: str) -> bpy.types.Object:
    if item is None or item.name not in scene.objects:
        raise ValueError(f"The {what} has been deleted from {scene.name}: undo, or import the photographs again")
    return item


def _pose(item: bpy.types.Object) -> Matrix:
    """Where an object is, also where it is hidden, of which Blender evaluates nothing."""
    if item.parent is None:
        return item.matrix_basis.copy()
    return _pose(item.parent) @ item.matrix_parent_inverse @ item.matrix_basis


def _place(item: bpy.types.Object) -> FloatArray:
    return np.array(_pose(item).translation, dtype=float)


def is_placed(lamp: bpy.types.Object) -> bool:
    """Whether somebody has said where a lamp stood."""
    return bool(np.linalg.norm(_place(lamp) - START) > _NEAR)


def phase_angle(settings: Any, lamp: bpy.types.Object) -> float:
    """The angle between a lamp and the camera, seen from the ball, radians."""
    to_lamp, to_camera = (Vector((_place(item) - _place(settings.ball)).tolist()) for item in (lamp, settings.camera))
    return to_lamp.angle(to_camera, 0.0)


def _shot(scene: bpy.types.Scene, shot: Any, whole: bool) -> Description:
    lamp = _there(scene, shot.lamp, f"lamp of {shot.name}")
    if whole and not is_placed(lamp):
        raise ValueError(f"{shot.name}: say where the lamp stood, by its location, by moving it, or by a chrome ball")
    described: Description = {"files": [bpy.path.abspath(each.filepath) for each in shot.files],
                              "lamp": _place(lamp).tolist()}
    if any(each.exposure for each in shot.files):
        described["exposures"] = [each.exposure for each in shot.files]
    return described


def _scale(scene: bpy.types.Scene, settings: Any) -> Any:
    if settings.scale == GUESS:
        return settings.albedo
    if settings.scale == INTENSITY:
        return _same_or_three(settings.intensity)
    if not settings.known:
        raise ValueError("Scale: choose the photograph of the card or the white ball")
    described = {"file": bpy.path.abspath(settings.known), "albedo": _same_or_three(settings.known_albedo),
             "lamp": _place(_there(scene, settings.known_lamp, "lamp of the card or the white ball")).tolist()}
    if settings.known_exposure:
        described["exposures"] = [settings.known_exposure]
    if settings.scale == BALL:
        return described
    return described | {"normal": list(settings.normal), "region": list(settings.region)}


def _same_or_three(values: Sequence[float]) -> float | list[float]:
    """One number for three that are the same, which pictures of one channel need."""
    return values[0] if len(set(values)) == 1 else list(values)


def _matrix(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text             # the fitter says what it expects
