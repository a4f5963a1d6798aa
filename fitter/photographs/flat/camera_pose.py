"""The camera that sees the corners of a rectangle where they are in a picture.

The lens is without distortion. The camera's place has three unknowns; its turn is that which brings four rays closest
to the corners (W. Kabsch, Acta Crystallographica A32, 1976).
"""

from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from ...least_squares import damped_step, levenberg_marquardt
from ..description.capture_setup import CameraSetup
from ..rig.camera import CameraView, rays_through

_MEASURED = 0.02            # of its distance, by which a camera's place may be wrong that somebody has measured
_ROUNDS = 40                # toward the camera's place; it takes 10


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

    def residual(position: FloatArray) -> FloatArray:
        off = _aim_camera(position, toward, corners)[1].ravel() / pixel
        return off if given is None else np.append(off, (position - given) / (_MEASURED * np.linalg.norm(given)))

    ends = [end for start in starts if (end := _minimise(residual, start))[2] > 0]
    return min(ends or starts, key=lambda end: float((residual(end) ** 2).sum()))


def _minimise(residual: Callable[[FloatArray], FloatArray], position: FloatArray) -> FloatArray:
    """Where the least squares of what a function misses are, near a position."""
    def evaluate(place: FloatArray) -> tuple[float, FloatArray]:
        off = residual(place)
        return float(off @ off), off

    def linearise(place: FloatArray, off: FloatArray) -> Callable[[float], FloatArray]:
        step = 1e-6 * float(np.linalg.norm(place))
        slope = np.stack([(residual(place + step * axis) - off) / step for axis in np.eye(3)], axis=1)
        return lambda damping: place - damped_step(slope.T @ slope, slope.T @ off, damping)

    return levenberg_marquardt(position, evaluate, linearise, steps=_ROUNDS, tries=8, grow=10, shrink=10, enough=0,
                               damping=1e-3)[0]


def _aim_camera(position: FloatArray, toward: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The orientation, (3, 3), of a camera at this position whose rays miss the corners least, and by how much they do:
    (4, 3), radians."""
    there = corners - position
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    u, _, v = np.linalg.svd(there.T @ toward)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    return turn, toward @ turn.T - there
