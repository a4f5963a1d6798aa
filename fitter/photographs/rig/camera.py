"""Where a camera stands and how it looks: by perspective without distortion of a lens, as a description says it, also
where nobody knows how far it is."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, FloatArray
from ...errors import DatasetError
from ...imaging.picture_files import PictureInfo
from ..description.capture_setup import CameraSetup
from ..pictures.reading import WHOLE, Part

_FAR_VIEW = np.radians(1.0)     # of one far away whose lens nobody knows: its rays are parallel, nearly


class CameraView(NamedTuple):
    """A camera and its pictures."""

    position: FloatArray        # (3,), metres
    orientation: FloatArray     # from its axes, x to the right, y up, z backward, to those of the scene: (3, 3)
    size: tuple[int, int]       # height and width, pixels
    angle: float                # of the width, radians

    def rays(self, part: Part = WHOLE) -> FloatArray:
        """Directions through the middles of a part's pixels, unit vectors, the top row first: (h, w, 3)."""
        rows, columns = (np.arange(side)[each] + 0.5 for each, side in zip(part, self.size, strict=True))
        places = np.stack(np.meshgrid(columns, rows), axis=-1)
        return np.asarray(rays_through(places, self.size, self.angle) @ self.orientation.T)

    def project(self, points: FloatArray) -> FloatArray:
        """Where points (..., 3) are, pixels from the left and the top: (..., 2). The inverse of `rays_through`.

        Examples
        --------
        >>> view = CameraView(np.zeros(3), np.eye(3), (20, 30), 1.0)
        >>> view.project(rays_through(np.array([[3.0, 7.5]]), view.size, view.angle)).round(9).tolist()
        [[3.0, 7.5]]
        """
        toward = (points - self.position) @ self.orientation
        step = 2 * np.tan(self.angle / 2) / self.size[1]
        return np.asarray(np.array(self.size[::-1]) / 2 + toward[..., :2] / -toward[..., 2:] / step * (1, -1))


def rays(height: int, width: int, angle: float, orientation: ArrayLike | None = None) -> FloatArray:
    """The directions from a camera through the centres of its pixels, as `CameraView` has them.

    Examples
    --------
    >>> rays(1, 2, np.pi / 2)[0].round(3).tolist()
    [[-0.447, 0.0, -0.894], [0.447, 0.0, -0.894]]
    """
    turned = np.eye(3) if orientation is None else np.asarray(orientation, dtype=float)
    return CameraView(np.zeros(3), turned, (height, width), angle).rays()


def rays_through(places: FloatArray, size: tuple[int, int], angle: float) -> FloatArray:
    """Unit vectors, in the camera's axes, through places (..., 2) of a picture of this height and width: pixels from
    its left edge, and from its top."""
    if not 0 < angle < np.pi:
        raise DatasetError(f"a field of view of {np.degrees(angle):g} degrees found, expected 0 to 180")
    (height, width), step = size, 2 * np.tan(angle / 2) / size[1]
    x, y = step * (places[..., 0] - width / 2), step * (height / 2 - places[..., 1])
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1)
    return np.asarray(directions / np.linalg.norm(directions, axis=-1, keepdims=True))


def orientation(camera: CameraSetup, middle: ArrayLike) -> FloatArray:
    """The orientation of a camera, as `CameraView` has it: by default it looks at the middle of what is measured, and
    one that is far along -z, with y up, so that the scene has the axes of its pictures."""
    def default_to(value: FloatArray | None, default: ArrayLike) -> ArrayLike:
        return default if value is None else value

    if isinstance(camera.position, str) or camera.position is None:
        return _look_at(default_to(camera.direction, (0, 0, 1)), (0, 0, 0), default_to(camera.up, (0, 1, 0)))
    return _look_at(camera.position, default_to(camera.look_at, middle), default_to(camera.up, (0, 0, 1)))


def _look_at(position: ArrayLike, target: ArrayLike, up: ArrayLike) -> FloatArray:
    back = np.asarray(position, dtype=float) - np.asarray(target, dtype=float)
    right = np.cross(np.asarray(up, dtype=float), back)
    lengths = np.linalg.norm(back), np.linalg.norm(right)
    if not lengths[0]:
        raise DatasetError("the camera stands at the point that it looks at")
    if lengths[1] < 1e-9 * lengths[0]:
        raise DatasetError("the camera looks along the direction that is up in its picture")
    z, x = back / lengths[0], right / lengths[1]
    return np.stack([x, np.cross(z, x), z], axis=1)


def lens_angle(focal_length: float, sensor_width: float) -> float:
    """The angle that a sensor takes behind a lens, radians; both lengths in one unit."""
    return 2 * float(np.arctan(sensor_width / (2 * focal_length)))


def field_of_view(camera: CameraSetup, pictures: Sequence[PictureInfo]) -> float:
    """The angle of the pictures' width, radians, by the description, or else by what the pictures say."""
    if camera.field_of_view is not None:
        return float(np.radians(camera.field_of_view))
    focal = camera.focal_length or next((each.focal_length for each in pictures if each.focal_length), None)
    if focal is not None and camera.sensor_width is not None:
        return lens_angle(focal, camera.sensor_width)
    said = next((each.field_of_view for each in pictures if each.field_of_view), None)
    if said is None and not camera.is_far:
        raise camera.error("field_of_view", "that, or focal_length and sensor_width: the photographs do not say them")
    return float(_FAR_VIEW) if said is None else said


def pixel_angle(directions: FloatArray) -> float:
    """The angle between rays of neighbouring pixels, the median over the picture: (h, w, 3) to radians."""
    along = [np.linalg.norm(np.diff(directions, axis=axis), axis=-1).ravel() for axis in (0, 1)]
    steps = np.concatenate(along)
    return float(np.median(steps)) if len(steps) else np.pi
