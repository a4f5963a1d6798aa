"""Where a camera stands and how it looks, by the table `camera` of a description; also where nobody knows how far."""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..errors import DatasetError
from . import camera as cameras
from .picture_files import Picture, PictureInfo
from .table import Table

KEYS = ("position", "direction", "look_at", "up", "field_of_view", "focal_length", "sensor_width", "matrix", "encoding")
FAR = "far"                 # the position of a camera of unknown distance
FAR_VIEW = np.radians(1.0)  # of one whose lens nobody knows either: its rays are parallel, nearly


class Viewpoint(NamedTuple):
    """A camera; metres and radians."""

    position: FloatArray | None
    """(3,), or None where it is `FAR`: it is so far that what it shows has its size."""
    orientation: FloatArray
    """The rotation from the camera's axes, x to the right, y up, z backward, to those of the scene: (3, 3)."""
    field_of_view: float
    rays: FloatArray
    """Directions through the pixels' centres: (height, width, 3)."""


def is_far(camera: Table) -> bool:
    """Whether the distance of a camera is unknown."""
    return camera.value("position") == FAR


def orientation(camera: Table, middle: ArrayLike) -> FloatArray:
    """The orientation of a camera, as `Viewpoint` has it, that by default looks at the middle of what is measured.

    One that is far by default looks along -z, with y up: the scene has the axes of its pictures.
    """
    if is_far(camera):
        if camera.has("look_at"):
            raise camera.error("look_at", "not that, but direction, toward the camera, for it is far")
        return cameras.looking(camera.numbers("direction", 3, (0, 0, 1)), (0, 0, 0), camera.numbers("up", 3, (0, 1, 0)))
    if camera.has("direction"):
        raise camera.error("direction", f'that of a camera whose position is "{FAR}"')
    if isinstance(camera.value("position"), str):
        raise camera.error("position", f'3 numbers, or "{FAR}"')
    position = camera.numbers("position", 3)
    return cameras.looking(position, camera.numbers("look_at", 3, np.asarray(middle).tolist()),
                           camera.numbers("up", 3, (0, 0, 1)))


def viewpoint(camera: Table, pictures: Iterable[Picture], size: tuple[int, int], middle: ArrayLike, path: Path,
              ) -> Viewpoint:
    """The camera of a description whose pictures have this height and width, pixels."""
    turned, angle = orientation(camera, middle), field_of_view(camera, pictures, path)
    return Viewpoint(None if is_far(camera) else camera.numbers("position", 3), turned, angle,
                     cameras.rays(*size, angle, turned))


def field_of_view(camera: Table, pictures: Iterable[Picture | PictureInfo], path: Path) -> float:
    """The angle of the pictures' width, radians, by the table `camera`, or else by what the pictures say."""
    if camera.has("field_of_view"):
        return float(np.radians(camera.needed("field_of_view")))
    pictures = list(pictures)
    focal = camera.number("focal_length", next((each.focal_length for each in pictures if each.focal_length), None))
    width = camera.number("sensor_width")
    if focal is not None and width is not None:
        return cameras.field_of_view(focal, width)
    said = next((each.field_of_view for each in pictures if each.field_of_view), None)
    if said is None and is_far(camera):
        return float(FAR_VIEW)
    if said is None:
        raise DatasetError("camera.field_of_view is missing, expected that, or focal_length and sensor_width: the "
                           "photographs do not say them", path)
    return said
