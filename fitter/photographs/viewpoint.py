"""Where a camera stands and how it looks, by a description; also where nobody knows how far."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray
from . import camera as cameras
from .description.capture_setup import CameraSetup
from .picture_files import Picture, PictureInfo

FAR_VIEW = np.radians(1.0)  # of one whose lens nobody knows either: its rays are parallel, nearly


class Viewpoint(NamedTuple):
    """A camera; metres and radians."""

    position: FloatArray | None
    """(3,), or None where it is so far that what it shows has its size."""
    orientation: FloatArray
    """The rotation from the camera's axes, x to the right, y up, z backward, to those of the scene: (3, 3)."""
    field_of_view: float
    rays: FloatArray
    """Directions through the pixels' centres: (height, width, 3)."""


def orientation(camera: CameraSetup, middle: ArrayLike) -> FloatArray:
    """The orientation of a camera, as `Viewpoint` has it, that by default looks at the middle of what is measured.

    One that is far by default looks along -z, with y up: the scene has the axes of its pictures.
    """
    if isinstance(camera.position, str) or camera.position is None:
        return cameras.looking(_given(camera.direction, (0, 0, 1)), (0, 0, 0), _given(camera.up, (0, 1, 0)))
    return cameras.looking(camera.position, _given(camera.look_at, middle), _given(camera.up, (0, 0, 1)))


def _given(value: FloatArray | None, default: ArrayLike) -> ArrayLike:
    return default if value is None else value


def viewpoint(camera: CameraSetup, pictures: Iterable[Picture], size: tuple[int, int], middle: ArrayLike) -> Viewpoint:
    """The camera of a description whose pictures have this height and width, pixels."""
    turned, angle = orientation(camera, middle), field_of_view(camera, pictures)
    return Viewpoint(None if isinstance(camera.position, str) else camera.position, turned, angle,
                     cameras.rays(*size, angle, turned))


def field_of_view(camera: CameraSetup, pictures: Iterable[Picture | PictureInfo]) -> float:
    """The angle of the pictures' width, radians, by the description, or else by what the pictures say."""
    if camera.field_of_view is not None:
        return float(np.radians(camera.field_of_view))
    pictures = list(pictures)
    focal = camera.focal_length or next((each.focal_length for each in pictures if each.focal_length), None)
    if focal is not None and camera.sensor_width is not None:
        return cameras.field_of_view(focal, camera.sensor_width)
    said = next((each.field_of_view for each in pictures if each.field_of_view), None)
    if said is None and camera.is_far:
        return float(FAR_VIEW)
    if said is None:
        raise camera.error("field_of_view", "that, or focal_length and sensor_width: the photographs do not say them")
    return said
