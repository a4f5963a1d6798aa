"""What a region of the 3D view shows, as arithmetic: points to pixels, pixels to rays, and dragging on a sphere."""

import math
from dataclasses import dataclass

import numpy as np

from ...fitter.arrays import ArrayLike, FloatArray

_STEEPEST = np.radians(89)      # of the incident direction


@dataclass(frozen=True, eq=False)
class View:
    """A view: a matrix from the world to clip coordinates, (4, 4), and a width and a height in pixels."""

    matrix: FloatArray
    width: float
    height: float

    def project(self, points: ArrayLike) -> FloatArray:
        """Where points are seen: (..., 3) to (..., 2) pixels from the bottom left; nan behind the viewer."""
        points = np.asarray(points, dtype=float)
        clip = points @ self.matrix[:, :3].T + self.matrix[:, 3]
        w = np.where(clip[..., 3:] > 1e-9, clip[..., 3:], np.nan)
        return (clip[..., :2] / w + 1) / 2 * (self.width, self.height)

    def ray(self, at: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """The ray through a pixel: its origin (3,), and its direction (3,) of length 1, away from the viewer."""
        x, y = 2 * np.asarray(at, dtype=float) / (self.width, self.height) - 1
        ends = np.linalg.solve(self.matrix, np.array([[x, x], [y, y], [-1, 1], [1, 1]]))
        near, far = (ends[:3] / ends[3]).T
        return near, (far - near) / np.linalg.norm(far - near)

    def direction_to_viewer(self, point: ArrayLike) -> FloatArray:
        """The direction from a point to the viewer, (3,), of length 1."""
        return -self.ray(np.nan_to_num(self.project(point)))[1]

    def pixel(self, point: ArrayLike) -> float:
        """How long a pixel is at the depth of a point."""
        at = self.project(point)
        if not np.isfinite(at).all():
            return 0.0
        sides = [self.ray(at + step) for step in ((-0.5, 0), (0.5, 0))]
        toward = self.direction_to_viewer(point)
        left, right = (origin + direction * ((np.asarray(point) - origin) @ toward) / (direction @ toward)
                       for origin, direction in sides)
        return float(np.linalg.norm(right - left))


def drag_direction(view: View, at: ArrayLike, frame: FloatArray, radius: float) -> tuple[float, float]:
    """The direction of a hemisphere, in its frame (4, 4), seen at a pixel: theta and phi, radians. Beside it that
    on its outline; below the horizon the one above it on the horizon."""
    origin, direction = view.ray(at)
    to_center = frame[:3, 3] - origin
    along = to_center @ direction
    nearest = along * direction - to_center
    half = math.sqrt(max(radius ** 2 - float(nearest @ nearest), 0.0))
    # the nearer side, unless only the farther one is above the horizon
    near, far = ((nearest + side * half * direction) @ frame[:3, :3] for side in (-1, 1))
    x, y, z = (float(part) for part in (near if near[2] > 0 or far[2] <= 0 else far))
    return limit_polar_angle(math.atan2(math.hypot(x, y), z)), math.atan2(y, x)


def limit_polar_angle(theta: float) -> float:
    return float(np.clip(theta, 0, _STEEPEST))
