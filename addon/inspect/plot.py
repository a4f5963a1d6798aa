"""The polar plot over the 3D view as arithmetic: where it lies, where values lie in it, and what the mouse is at."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...fitter.arrays import ArrayLike, FloatArray
from ...fitter.lobe import RADII, Radius

_WIDTH, _SHARE = (430.0, 640.0), 0.5        # at a scale of 1, if there is room; of the free width
LINE = 19.0                 # height of a line of text
_MARGIN, _ABOVE, _BELOW, _BESIDE = 12.0, 24.0, 20.0, 38.0       # around the box; around the half disc
_PAD = 10.0                 # between the box and its text
_TITLES = 2                 # lines above
_LEAST = 60.0               # radius
_RINGS = (1.0, 0.65, 0.35)  # of the radius, about
_APART = 0.14               # rings, at least

Rectangle = tuple[float, float, float, float]
"""x, y of the lower left corner, width, height: pixels."""


@dataclass(frozen=True)
class Plot:
    """A box with half a disc: up is the normal, left is the light. All in pixels, from the bottom left of the region,
    but the scale of the interface.
    """

    x: float
    y: float
    width: float
    height: float
    radius: float
    scale: float

    @property
    def center(self) -> FloatArray:
        """Of the half disc."""
        return np.array([self.x + self.width / 2, self.y + (_PAD + LINE + _BELOW) * self.scale])

    @property
    def corners(self) -> FloatArray:
        """Of the box, (4, 2)."""
        right, top = self.x + self.width, self.y + self.height
        return np.array([(self.x, self.y), (right, self.y), (right, top), (self.x, top)])

    def line(self, number: int) -> tuple[float, float]:
        """Where a line of text begins: 0 is the topmost, -1 the lowest."""
        inside = self.x + _PAD * self.scale
        if number < 0:
            return inside, self.y + (_PAD + LINE * (-1 - number) + 4) * self.scale
        return inside, self.y + self.height - (_PAD + LINE * (number + 1) - 5) * self.scale

    def holds(self, at: ArrayLike) -> bool:
        """Whether the box is under a pixel."""
        x, y = np.asarray(at)
        return bool(self.x <= x <= self.x + self.width and self.y <= y <= self.y + self.height)

    def angle(self, at: ArrayLike) -> float:
        """The outgoing angle under a pixel, radians: negative on the light's side, at most a right angle."""
        x, y = np.asarray(at, dtype=float) - self.center
        return math.atan2(x, max(y, 0.0))

    def is_read(self, at: ArrayLike) -> bool:
        """Whether a pixel is in the half disc."""
        x, y = np.asarray(at, dtype=float) - self.center
        return bool(math.hypot(x, y) <= 1.05 * self.radius and y >= -4 * self.scale)

    def points(self, theta: ArrayLike, length: ArrayLike) -> FloatArray:
        """Where angles and lengths, 1 on the outer circle, lie: (...) to (..., 2) pixels."""
        theta, length = np.broadcast_arrays(np.asarray(theta, dtype=float), np.asarray(length, dtype=float))
        return self.center + self.radius * length[..., None] * np.stack([np.sin(theta), np.cos(theta)], axis=-1)


def placed(free: Rectangle, side: str, scale: float) -> Plot:
    """A plot in the lower "LEFT" or "RIGHT" corner of the free part of a region, at a scale of the interface."""
    x, y, width, height = free
    around = (2 * _PAD + LINE * (1 + _TITLES) + _ABOVE + _BELOW) * scale
    wide = min(np.clip(_SHARE * width, _WIDTH[0] * scale, _WIDTH[1] * scale), width - 2 * _MARGIN * scale)
    radius = max(min(float(wide) / 2 - _BESIDE * scale, height - 2 * _MARGIN * scale - around), _LEAST * scale)
    wide = 2 * (radius + _BESIDE * scale)
    left = x + _MARGIN * scale if side == "LEFT" else x + width - wide - _MARGIN * scale
    return Plot(left, y + _MARGIN * scale, wide, radius + around, radius, scale)


def free_part(region: Rectangle, others: Sequence[Rectangle]) -> Rectangle:
    """The part of a region that others over it leave free: in pixels of the region; the rest, of the window.

    Of the parts beside each of them, the largest: a header or a sidebar lies along an edge, and Adjust Last Operation
    in a corner.
    """
    x, y, width, height = region
    free = 0.0, 0.0, width, height
    for other_x, other_y, other_width, other_height in others:
        free = _largest_beside(free, (other_x - x, other_y - y, other_width, other_height))
    return free


def _largest_beside(free: Rectangle, other: Rectangle) -> Rectangle:
    x, y, width, height = free
    right, top = x + width, y + height
    other_right, other_top = other[0] + other[2], other[1] + other[3]
    if min(other_right, right) <= max(other[0], x) or min(other_top, top) <= max(other[1], y):
        return free
    parts = ((x, y, other[0] - x, height), (other_right, y, right - other_right, height),
             (x, y, width, other[1] - y), (x, other_top, width, top - other_top))
    return max(parts, key=lambda part: max(part[2], 0) * max(part[3], 0))


def lengths(values: FloatArray, largest: float, radius: Radius) -> FloatArray:
    """How far from the center values lie, 1/sr: 1 where they are the largest."""
    return np.asarray(RADII[radius](np.maximum(values, 0) / largest))


def dashes(points: FloatArray, length: float) -> FloatArray:
    """The ends of the dashes of a polyline, which have gaps of their length between them: (n, 2) to (2 m, 2)."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    at = np.arange(0.0, along[-1] + length, length)
    at = at[:len(at) // 2 * 2]
    return np.stack([np.interp(at, along, axis) for axis in points.T], axis=-1)


def rings(largest: float, radius: Radius) -> list[tuple[float, float]]:
    """Values of one digit, 1/sr, and the radii of their circles, the largest first, for a plot whose outer circle is
    `largest`."""
    circles: list[tuple[float, float]] = []
    for ring in _RINGS:
        value = _of_one_digit(largest * (ring ** 3 if radius == "cube root" else ring))
        length = float(lengths(np.array(value), largest, radius))
        if not circles or length < circles[-1][1] - _APART:
            circles.append((value, length))
    return circles


def shown_value(value: float) -> str:
    """A value for people, 1/sr: three digits."""
    if value == 0:
        return "0"
    digits = 2 - math.floor(math.log10(abs(value)))
    return f"{round(value, digits):.10f}".rstrip("0").rstrip(".") if digits < 8 else f"{value:.1e}"


def _of_one_digit(value: float) -> float:
    """The largest number of one digit that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(math.floor(value / power + 1e-9), 1)
