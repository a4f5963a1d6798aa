"""The plot over the 3D view as arithmetic: where it lies, and what the mouse is at."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...fitter.arrays import ArrayLike, FloatArray
from ...fitter.imaging.plane_plot import Disc

_WIDTH, _SHARE = (430.0, 640.0), 0.5        # at a scale of 1, if there is room; of the free width
LINE = 19.0                 # height of a line of text
_MARGIN, _ABOVE, _BELOW, _BESIDE = 12.0, 24.0, 20.0, 38.0       # around the box; around the half disc
_PAD = 10.0                 # between the box and its text
_TITLES = 2                 # lines above
_LEAST = 60.0               # radius

Rectangle = tuple[float, float, float, float]
"""x, y of the lower left corner, width, height: pixels."""


@dataclass(frozen=True)
class Plot:
    """A box with half a disc: up is the normal, left is the light. All in pixels of the region, but `scale`."""

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
        return np.array([self.x, self.y]) + np.array([self.width, self.height]) * [(0, 0), (1, 0), (1, 1), (0, 1)]

    def line(self, number: int) -> tuple[float, float]:
        """Where a line of text begins: 0 is the topmost, -1 the lowest."""
        inside = self.x + _PAD * self.scale
        if number < 0:
            return inside, self.y + (_PAD + LINE * (-1 - number) + 4) * self.scale
        return inside, self.y + self.height - (_PAD + LINE * (number + 1) - 5) * self.scale

    def holds(self, at: ArrayLike) -> bool:
        return bool(((self.corners[0] <= at) & (at <= self.corners[2])).all())

    def angle(self, at: ArrayLike) -> float:
        """The outgoing angle under a pixel, radians: negative on the light's side, at most a right angle."""
        x, y = np.asarray(at, dtype=float) - self.center
        return math.atan2(x, max(y, 0.0))

    def is_read(self, at: ArrayLike) -> bool:
        x, y = np.asarray(at, dtype=float) - self.center
        return bool(math.hypot(x, y) <= 1.05 * self.radius and y >= -4 * self.scale)

    @property
    def disc(self) -> Disc:
        """What the plane of incidence is drawn in."""
        return Disc(self.center, self.radius, self.scale)


def place_plot(free: Rectangle, side: str, scale: float) -> Plot:
    """A plot in the lower "LEFT" or "RIGHT" corner of the free part of a region, at a scale of the interface."""
    x, y, width, height = free
    around = (2 * _PAD + LINE * (1 + _TITLES) + _ABOVE + _BELOW) * scale
    wide = min(np.clip(_SHARE * width, _WIDTH[0] * scale, _WIDTH[1] * scale), width - 2 * _MARGIN * scale)
    radius = max(min(float(wide) / 2 - _BESIDE * scale, height - 2 * _MARGIN * scale - around), _LEAST * scale)
    wide = 2 * (radius + _BESIDE * scale)
    left = x + _MARGIN * scale if side == "LEFT" else x + width - wide - _MARGIN * scale
    return Plot(left, y + _MARGIN * scale, wide, radius + around, radius, scale)


def free_part(region: Rectangle, others: Sequence[Rectangle]) -> Rectangle:
    """The part of a region that others over it leave free, in its pixels: of those beside each of them, the largest."""
    left, low, right, top = 0.0, 0.0, region[2], region[3]
    for other in others:
        x, y = other[0] - region[0], other[1] - region[1]
        if min(x + other[2], right) <= max(x, left) or min(y + other[3], top) <= max(y, low):
            continue
        beside = ((left, low, x, top), (x + other[2], low, right, top), (left, low, right, y),
                  (left, y + other[3], right, top))
        left, low, right, top = max(beside, key=lambda part: max(part[2] - part[0], 0) * max(part[3] - part[1], 0))
    return left, low, right - left, top - low
