"""A description of photographs as a scene, with a camera, a ball or a flat sample, and lamps; and that of such a scene.

It is what `python -m fitter photographs` and `flat` read, as `fitter.photographs.description` has it.
"""

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector, geometry

from ...fitter import DatasetError
from ...fitter.arrays import FloatArray
from ...fitter.photographs import flat_setup
from ...fitter.photographs.capture import Resolved
from ...fitter.photographs.description.capture_setup import (
    BallSetup,
    CameraSetup,
    CaptureSetup,
    Description,
    SampleSetup,
    Shot,
)
from ...fitter.photographs.scene import camera as cameras
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
_ON_CURVE = 9               # points of a mask's curve between two of its own
_HALF = 0.5                 # opacity of the photograph before the ball


def make(resolved: Resolved) -> bpy.types.Scene:
    """Make a scene of a description whose places are numbers. Raises DatasetError if it has what the settings of a
    scene cannot hold: several files of a card, say.
    """
    setup, (height, width), is_far = resolved
    shots = setup.photographs
    scene = bpy.data.scenes.new(setup.title)
    osl_support.enable(scene)
    scene.cycles.samples, scene.cycles.preview_samples = _SAMPLES, _IN_VIEW
    scene.cycles.blur_glossy = scene.cycles.sample_clamp_indirect = 0
    scene.view_settings.view_transform = "Standard"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    settings = photographs.get(scene)
    settings.camera = scene.camera = _camera(scene, setup.camera)
    if setup.ball is not None:
        settings.ball = _ball(scene, setup.ball)
    else:
        settings.sample, settings.is_far = _sample(scene, setup.need_sample()), is_far
    settings.camera.matrix_basis = camera_pose(setup.camera, setup.ball.centre if setup.ball else (0, 0, 0))
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


def _camera(scene: bpy.types.Scene, setup: CameraSetup) -> bpy.types.Object:
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = setup.sensor_width or SENSOR
    data.lens = setup.focal_length or LENS
    if setup.field_of_view is not None:
        data.lens = data.sensor_width / (2 * math.tan(math.radians(setup.field_of_view) / 2))
    background = data.background_images.new()
    background.display_depth, background.alpha = "FRONT", _HALF
    data.show_background_images = True
    return _object(scene, "Camera", data)


def camera_pose(setup: CameraSetup, centre: Any = (0, 0, 0)) -> Matrix:
    """Where a camera is in a description whose places are numbers; by default it looks at a centre, (3,)."""
    orientation = cameras.orientation(setup, centre)
    return Matrix.Translation(Vector(_numbers(setup.position))) @ Matrix(orientation.tolist()).to_4x4()


def _ball(scene: bpy.types.Scene, setup: BallSetup) -> bpy.types.Object:
    item = _object(scene, "Ball", look.sphere())
    item.location, item.scale = _numbers(setup.centre), [not_none(setup.radius)] * 3
    item.material_slots[0].material = _preview()
    return item


def _sample(scene: bpy.types.Scene, setup: SampleSetup) -> bpy.types.Object:
    """A plane, and an outline of it that is drawn before what the camera sees."""
    x, y = setup.width / 2, setup.height / 2
    mesh, edge = bpy.data.meshes.new("Sample"), bpy.data.meshes.new("Outline")
    mesh.from_pydata([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)])
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
    """What ball and sample are of until they are measured."""
    preview = bpy.data.materials.new("Not Measured")
    material.use_nodes(preview)
    surface: Any = next(node for node in not_none(preview.node_tree).nodes if node.type == "BSDF_PRINCIPLED")
    surface.inputs["Base Color"].default_value = (*[_PREVIEW[0]] * 3, 1)
    surface.inputs["Roughness"].default_value = _PREVIEW[1]
    return preview


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
    matrix, given = setup.camera.matrix, setup.ball or setup.need_sample()
    for name, value in (("dark", _one(setup.lamp.dark)), ("flat", _one(setup.lamp.flat)),
                        ("mask", _one(given.mask)), ("encoding", setup.camera.encoding),
                        ("matrix", "" if matrix is None else json.dumps(matrix.tolist()))):
        if value:
            setattr(settings, name, value)
    if setup.sample is not None:
        _store_sample(settings, setup, scene)
    scale = setup.scale
    settings.scale = scale.ways[0]
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
        if known.normal is not None:
            settings.normal = known.normal
        if known.region is not None:
            settings.region = known.region.astype(int).tolist()


def _store_sample(settings: Any, setup: CaptureSetup, scene: bpy.types.Scene) -> None:
    sample, size, brightness = setup.need_sample(), _picture_size(scene), setup.lamp.brightness
    settings.corners = np.ravel(_numbers(sample.corners)).tolist()
    if sample.outline is not None:
        settings.drawn_outline = _mask("Outline", sample.outline, size)
    settings.finds_brightness = isinstance(brightness, str)
    for shot, each in zip(settings.photographs, brightness if isinstance(brightness, np.ndarray) else (), strict=False):
        shot.brightness = each
    settings.texels = round(setup.texels or 0)
    settings.count = str(setup.materials) if isinstance(setup.materials, int) else settings.count


def _one(files: Sequence[Path] | None) -> str:
    """The only file; empty where there is none."""
    if files and len(files) > 1:
        raise DatasetError(f"{len(files)} files found, expected one: a scene holds several exposures of photographs "
                           f"alone", files[0])
    return str(files[0].absolute()) if files else ""


def describe_scene(scene: bpy.types.Scene, shots: Sequence[Any] = (), whole: bool = True) -> Description:
    """The description of some photographs of a scene; by default of those that are used.

    By default it is `whole`: what is to be measured. Else nobody need have placed the lamps, and their intensity is 1.
    Raises ValueError if an object has been deleted, or the whole is not there.
    """
    settings = photographs.get(scene)
    shots = shots or [each for each in settings.photographs if each.used]
    if not shots:
        raise ValueError("No photograph of this scene is used")
    camera = _there(scene, settings.camera, "camera")
    lens: Any = camera.data
    first = _there(scene, shots[0].lamp, f"lamp of {shots[0].name}")
    light: Any = first.data
    described: Description = {
        "name": scene.name, "camera": {"field_of_view": math.degrees(cameras.lens_angle(lens.lens,
                                                                                          lens.sensor_width))},
        "lamp": {name: bpy.path.abspath(path) for name, path in (("dark", settings.dark), ("flat", settings.flat))
                 if path},
        "scale": {settings.scale: _scale(scene, settings)} if whole else {INTENSITY: 1.0},
        "photograph": [_shot(scene, each, whole) for each in shots]}
    if is_flat(settings):
        _describe_sample(scene, settings, shots, described)
    else:
        _describe_ball(scene, settings, described, light.shadow_soft_size)
    if settings.encoding not in ("", AS_THE_FILE_SAYS):
        described["camera"]["encoding"] = settings.encoding
    if settings.matrix:
        described["camera"]["matrix"] = _matrix(settings.matrix)
    return described


def is_flat(settings: Any) -> bool:
    """Whether the photographs are of a flat sample: its corners are in them, whether or not its object is."""
    return any(settings.corners)


def _describe_ball(scene: bpy.types.Scene, settings: Any, described: Description, lamp_radius: float) -> None:
    pose, ball = np.array(_pose(settings.camera)), _there(scene, settings.ball, "ball")
    away = pose[:3, :3] / np.linalg.norm(pose[:3, :3], axis=0)
    described["camera"] |= {"position": pose[:3, 3].tolist(), "look_at": (pose[:3, 3] - away[:, 2]).tolist(),
                            "up": away[:, 1].tolist()}
    described["ball"] = {"centre": _place(ball).tolist(), "radius": settings.radius}
    if lamp_radius:
        described["lamp"]["radius"] = lamp_radius
    if settings.mask:
        described["ball"]["mask"] = bpy.path.abspath(settings.mask)


def _picture_size(scene: bpy.types.Scene) -> tuple[int, int]:
    return scene.render.resolution_y, scene.render.resolution_x


def _describe_sample(scene: bpy.types.Scene, settings: Any, shots: Sequence[Any], described: Description) -> None:
    size = _picture_size(scene)
    _there(scene, settings.sample, "sample")
    corners = np.reshape(settings.corners, (4, 2))
    if settings.drawn_corners is not None:
        corners = flat_setup.order_corners(drawn_corners(settings.drawn_corners), size)
    described["sample"] = {"width": settings.width, "height": settings.height, "corners": corners.tolist()}
    if settings.drawn_outline is not None:
        described["sample"]["outline"] = flat_setup.to_pixels(drawn_outline(settings.drawn_outline), size).tolist()
    if settings.mask:
        described["sample"]["mask"] = bpy.path.abspath(settings.mask)
    if settings.is_far:
        described["camera"]["position"] = "far"
    brightness = [each.brightness for each in shots]
    if settings.finds_brightness:
        described["lamp"]["brightness"] = "found"
    elif any(each != 1 for each in brightness):
        described["lamp"]["brightness"] = brightness
    if settings.texels:
        described["texels"] = settings.texels
    if int(settings.count or 0):
        described["materials"] = int(settings.count)


def drawn_corners(mask: Any) -> FloatArray:
    """The four points of a mask, (4, 2), as `flat_setup.order_corners` takes them."""
    if [len(each.points) for each in _splines(mask)] != [4]:
        raise ValueError(f"Corners: {mask.name!r} is not a mask of one spline with four points")
    return np.array([tuple(point.co) for point in _splines(mask)[0].points]) - 0.5


def drawn_outline(mask: Any) -> FloatArray:
    """The only curve of a mask as a polygon, (n, 2), in the same coordinates."""
    if len(_splines(mask)) != 1 or len(_splines(mask)[0].points) < 3:
        raise ValueError(f"Drawn Mask: {mask.name!r} is not a mask of one spline with three points or more")
    points = list(_splines(mask)[0].points)
    curve = [place for one, other in zip(points, [*points[1:], points[0]], strict=True)
             for place in geometry.interpolate_bezier(one.co, one.handle_right, other.handle_left, other.co,
                                                      _ON_CURVE)[:-1]]
    return np.array([place[:2] for place in curve]) - 0.5


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


def _splines(mask: Any) -> list[Any]:
    return [spline for layer in mask.layers for spline in layer.splines]


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
    """The angle between a lamp and the camera, seen from the ball, radians; of a sample, between lamp and normal."""
    if settings.ball is None:
        return Vector(_place(lamp).tolist()).angle((0, 0, 1), 0.0)
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
    if is_flat(settings):
        if settings.scale == BALL:
            raise ValueError("Scale: a white ball has no place beside a flat sample: choose the card, or a guess")
        return described | {"region": list(settings.region)}
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
