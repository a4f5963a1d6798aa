"""The description that a scene of photographs stands for: what `python -m fitter photographs` and `flat` read."""

import json
import math
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector, geometry

from ...fitter.arrays import FloatArray
from ...fitter.photographs.description.capture_setup import Description
from ...fitter.photographs.flat.reading import order_corners, to_pixels
from ...fitter.photographs.rig import camera as cameras
from .settings import AS_THE_FILE_SAYS, GUESS, INTENSITY, WHITE_BALL, is_flat
from .work import START

NEAR = 1e-6                 # m: an object so near a place is there
_ON_CURVE = 9               # points of a mask's curve between two of its own


def describe_scene(settings: Any, shots: Sequence[Any] = (), whole: bool = True) -> Description:
    """The description of some photographs of the scene of settings; by default of those that are used.

    By default it is `whole`: what is to be measured. Else nobody need have placed the lamps, and their intensity is 1.
    Raises ValueError if an object has been deleted, or the whole is not there.
    """
    scene = settings.id_data
    shots = shots or [each for each in settings.photographs if each.used]
    if not shots:
        raise ValueError("No photograph of this scene is used")
    lens: Any = _there(scene, settings.camera, "camera").data
    light: Any = _there(scene, shots[0].lamp, f"lamp of {shots[0].name}").data
    described: Description = {
        "name": scene.name,
        "camera": _drop_empty(
            field_of_view=math.degrees(cameras.lens_angle(lens.lens, lens.sensor_width)),
            encoding="" if settings.encoding == AS_THE_FILE_SAYS else settings.encoding,
            matrix=_parse_matrix(settings.matrix)),
        "lamp": _drop_empty(dark=bpy.path.abspath(settings.dark), flat=bpy.path.abspath(settings.flat)),
        "scale": {settings.scale: _scale(scene, settings)} if whole else {INTENSITY: 1.0},
        "photograph": [_shot(scene, each, whole) for each in shots]}
    if is_flat(settings):
        _describe_sample(scene, settings, shots, described)
    else:
        pose, ball = np.array(_pose(settings.camera)), _there(scene, settings.ball, "ball")
        away = pose[:3, :3] / np.linalg.norm(pose[:3, :3], axis=0)
        described["camera"] |= {"position": pose[:3, 3].tolist(), "look_at": (pose[:3, 3] - away[:, 2]).tolist(),
                                "up": away[:, 1].tolist()}
        described["ball"] = _drop_empty(centre=position(ball).tolist(), radius=settings.radius,
                                        mask=bpy.path.abspath(settings.mask))
        described["lamp"] |= _drop_empty(radius=light.shadow_soft_size or None)
    return described


def _drop_empty(**values: Any) -> Description:
    return {key: value for key, value in values.items() if value is not None and value != ""}


def _describe_sample(scene: bpy.types.Scene, settings: Any, shots: Sequence[Any], described: Description) -> None:
    """Put a flat sample into a description that has a camera and lamps; corners and outlines are pixels of the
    photographs, whose size is that of the scene's render. Keys with their default values are left out."""
    size = scene.render.resolution_y, scene.render.resolution_x
    _there(scene, settings.sample, "sample")
    corners, outline = np.reshape(settings.corners, (4, 2)), settings.drawn_outline
    if settings.drawn_corners is not None:
        drawn = _spline_points(settings.drawn_corners, "Corners", 4, 4, "four points")
        corners = order_corners(np.array([tuple(point.co) for point in drawn]) - 0.5, size)
    brightness = [each.brightness for each in shots] if any(each.brightness != 1 for each in shots) else None
    described["sample"] = _drop_empty(
        width=settings.width, height=settings.height, corners=corners.tolist(), mask=bpy.path.abspath(settings.mask),
        outline=None if outline is None else to_pixels(_drawn_outline(outline), size).tolist())
    described["camera"] |= _drop_empty(position="far" if settings.is_far else None)
    described["lamp"] |= _drop_empty(brightness="found" if settings.finds_brightness else brightness)
    described |= _drop_empty(texels=settings.texels or None, materials=int(settings.count or 0) or None)


def _spline_points(mask: Any, name: str, least: int, most: float, expected: str) -> list[Any]:
    splines = [spline for layer in mask.layers for spline in layer.splines]
    if len(splines) != 1 or not least <= len(splines[0].points) <= most:
        raise ValueError(f"{name}: {mask.name!r} is not a mask of one spline with {expected}")
    return list(splines[0].points)


def _drawn_outline(mask: Any) -> FloatArray:
    """The only curve of a mask as a polygon, (n, 2), as `to_pixels` takes it."""
    points = _spline_points(mask, "Drawn Mask", 3, math.inf, "three points or more")
    curve = [place for one, other in zip(points, [*points[1:], points[0]], strict=True)
             for place in geometry.interpolate_bezier(one.co, one.handle_right, other.handle_left, other.co,
                                                      _ON_CURVE)[:-1]]
    return np.array([place[:2] for place in curve]) - 0.5


def _there(scene: bpy.types.Scene, item: bpy.types.Object | None, what: str) -> bpy.types.Object:
    if item is None or item.name not in scene.objects:
        raise ValueError(f"The {what} has been deleted from {scene.name}: undo, or import the photographs again")
    return item


def _pose(item: bpy.types.Object) -> Matrix:
    """Where an object is, also where it is hidden, of which Blender evaluates nothing."""
    if item.parent is None:
        return item.matrix_basis.copy()
    return _pose(item.parent) @ item.matrix_parent_inverse @ item.matrix_basis


def position(item: bpy.types.Object) -> FloatArray:
    """Where an object is, (3,), metres."""
    return np.array(_pose(item).translation, dtype=float)


def is_placed(lamp: bpy.types.Object) -> bool:
    """Whether somebody has said where a lamp stood."""
    return bool(np.linalg.norm(position(lamp) - START) > NEAR)


def phase_angle(settings: Any, lamp: bpy.types.Object) -> float:
    """The angle between a lamp and the camera, seen from the ball, radians; of a sample, between lamp and normal."""
    if settings.ball is None:
        return Vector(position(lamp).tolist()).angle((0, 0, 1), 0.0)
    to_lamp, to_camera = (Vector((position(item) - position(settings.ball)).tolist())
                          for item in (lamp, settings.camera))
    return to_lamp.angle(to_camera, 0.0)


def _shot(scene: bpy.types.Scene, shot: Any, whole: bool) -> Description:
    lamp = _there(scene, shot.lamp, f"lamp of {shot.name}")
    if whole and not is_placed(lamp):
        raise ValueError(f"{shot.name}: say where the lamp stood, by its location, by moving it, or by a chrome ball")
    exposures = [each.exposure for each in shot.files]
    return _drop_empty(files=[bpy.path.abspath(each.filepath) for each in shot.files], lamp=position(lamp).tolist(),
                       exposures=exposures if any(exposures) else None)


def _scale(scene: bpy.types.Scene, settings: Any) -> Any:
    if settings.scale == GUESS:
        return settings.albedo
    if settings.scale == INTENSITY:
        return _same_or_three(settings.intensity)
    if not settings.known:
        raise ValueError("Scale: choose the photograph of the card or the white ball")
    is_ball = settings.scale == WHITE_BALL
    lamp = _there(scene, settings.known_lamp, "lamp of the card or the white ball")
    if is_ball and is_flat(settings):
        raise ValueError("Scale: a white ball has no place beside a flat sample: choose the card, or a guess")
    return _drop_empty(file=bpy.path.abspath(settings.known), albedo=_same_or_three(settings.known_albedo),
                       lamp=position(lamp).tolist(),
                       exposures=[settings.known_exposure] if settings.known_exposure else None,
                       normal=None if is_ball or is_flat(settings) else list(settings.normal),
                       region=None if is_ball else list(settings.region))


def _same_or_three(values: Sequence[float]) -> float | list[float]:
    """One number for three that are the same, which pictures of one channel need."""
    return values[0] if len(set(values)) == 1 else list(values)


def _parse_matrix(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text             # the fitter says what it expects
