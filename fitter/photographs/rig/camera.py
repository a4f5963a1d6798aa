"""Where a camera stands and how it looks: by perspective without distortion of a lens, as a description says it, also
where nobody knows how far it is, or by the corners of a rectangle in a picture.

Of the latter the camera's place has three unknowns; its turn is that which brings four rays closest to the corners
(W. Kabsch, Acta Crystallographica A32, 1976).
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, FloatArray
from ...errors import DatasetError
from ...imaging.picture_files import PictureInfo
from ...least_squares import damped_step, levenberg_marquardt
from ..description.capture_setup import CameraSetup
from ..pictures import WHOLE, Part

_FAR_VIEW = np.radians(1.0)     # of one far away whose lens nobody knows: its rays are parallel, nearly
_MEASURED = 0.02            # of its distance, by which a camera's place may be wrong that somebody has measured
_ROUNDS = 40                # toward the camera's place; it takes 10


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
        """Where points (..., 3) are, pixels from the left and the top: (..., 2). The inverse of `rays_through`."""
        toward = (points - self.position) @ self.orientation
        step = 2 * np.tan(self.angle / 2) / self.size[1]
        return np.asarray(np.array(self.size[::-1]) / 2 + toward[..., :2] / -toward[..., 2:] / step * (1, -1))


def rays(height: int, width: int, angle: float, orientation: ArrayLike | None = None) -> FloatArray:
    """The directions from a camera through the centres of its pixels, as `CameraView` has them: (h, w, 3)."""
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
    def default_to(value: FloatArray | None, default: ArrayLike) -> FloatArray:
        return np.asarray(default if value is None else value, dtype=float)

    if isinstance(camera.position, str) or camera.position is None:
        back, up = default_to(camera.direction, (0, 0, 1)), default_to(camera.up, (0, 1, 0))
    else:
        back, up = camera.position - default_to(camera.look_at, middle), default_to(camera.up, (0, 0, 1))
    right = np.cross(up, back)
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
    steps = np.concatenate([np.linalg.norm(np.diff(directions, axis=axis), axis=-1).ravel() for axis in (0, 1)])
    return float(np.median(steps)) if len(steps) else np.pi


def find_view(camera: CameraSetup, places: FloatArray, corners: FloatArray, size: tuple[int, int],
              angle: float) -> tuple[CameraView, float]:
    """The camera that sees corners (4, 3) at places (4, 2) of its pictures, and how far the worst is off, pixels."""
    toward = rays_through(places, size, angle)
    position = _find_position(camera, toward, corners, angle / size[1])
    orientation, separation = _aim_camera(position, toward, corners)
    worst = float(np.linalg.norm(separation, axis=1).max())
    return CameraView(position, orientation, size, angle), worst / (2 * np.tan(angle / 2) / size[1])


def _find_position(camera: CameraSetup, toward: FloatArray, corners: FloatArray, pixel: float) -> FloatArray:
    """Where a camera is that sees the corners (4, 3) in the directions (4, 3) of its own axes; `pixel` is an angle."""
    spread = np.linalg.norm(toward - toward.mean(axis=0), axis=1).sum()
    distance = float(np.linalg.norm(corners, axis=1).sum() / spread)
    given = camera.position
    if isinstance(given, str):
        return np.array([0, 0, distance])
    if given is not None and not given[2] > 0:
        raise camera.error("position", "one above the sample, z more than 0")
    tilts = [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.0, -0.6)]
    starts = [given] if given is not None else [distance * np.array([a, b, np.sqrt(1 - a * a - b * b)])
                                                for a, b in tilts]

    def evaluate(place: FloatArray) -> tuple[float, FloatArray]:
        off = _aim_camera(place, toward, corners)[1].ravel() / pixel
        if given is not None:
            off = np.append(off, (place - given) / (_MEASURED * np.linalg.norm(given)))
        return float(off @ off), off

    def linearise(place: FloatArray, off: FloatArray) -> Callable[[float], FloatArray]:
        step = 1e-6 * float(np.linalg.norm(place))
        slope = np.stack([(evaluate(place + step * axis)[1] - off) / step for axis in np.eye(3)], axis=1)
        return lambda damping: place - damped_step(slope.T @ slope, slope.T @ off, damping)

    ends = [levenberg_marquardt(start, evaluate, linearise, steps=_ROUNDS, tries=8, grow=10, shrink=10, enough=0,
                                damping=1e-3)[0] for start in starts]
    return min([end for end in ends if end[2] > 0] or starts, key=lambda end: evaluate(end)[0])


def _aim_camera(position: FloatArray, toward: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The orientation, (3, 3), of a camera at this position whose rays miss the corners least, and by how much they do:
    (4, 3), radians."""
    there = corners - position
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    u, _, v = np.linalg.svd(there.T @ toward)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    return turn, toward @ turn.T - there
