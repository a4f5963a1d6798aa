"""Where lamps are, by a description: at a place, or far away in a direction; or by a chrome ball."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray, RealArray
from ..errors import DatasetError
from .chrome import Highlight, lamp_of_highlight
from .description.capture_setup import Known, Shot
from .viewpoint import Viewpoint

FAR = 1e4                   # sizes of what it lights, to a lamp far away, which lights all of it alike to 1e-4


class Lamp(NamedTuple):
    """A lamp of a description."""

    toward: FloatArray
    """Its place, metres, or where it is far the unit vector toward it: (3,)."""
    is_far: bool

    def at(self, middle: ArrayLike, size: float) -> FloatArray:
        """The place of the lamp, (3,), for what is in this place and of this size, metres."""
        return np.asarray(middle, dtype=float) + FAR * size * self.toward if self.is_far else self.toward


class ChromeBall(NamedTuple):
    """A chrome ball in the place of what is measured; metres."""

    centre: FloatArray
    radius: float


def mirrored_lamp(shot: Shot, shown: RealArray, view: Viewpoint, camera: ArrayLike, chrome: ChromeBall) -> Lamp:
    """The lamp that a chrome ball shows in a photograph's picture of it, (height, width, channels), from a camera at
    (3,), which is the view's, also where that was far."""
    highlight = lamp_of_highlight(shown, view.rays, camera, chrome.centre, chrome.radius, (shot.chrome or ())[0].name)
    return Lamp(highlight.direction, True) if shot.distance is None else Lamp(highlight.at(shot.distance), False)


def placed_lamp(given: Shot | Known, middle: FloatArray, turn: FloatArray | None = None,
                ball: FloatArray | None = None) -> Lamp:
    """The lamp of a photograph that has its place or direction.

    `turn` (3, 3) is from the axes of the direction to the scene's, and the direction holds at `ball` (3,), by default
    in the middle (3,), which the distance counts from.
    """
    if given.lamp is not None:
        return Lamp(given.lamp, False)
    if given.direction is None:
        raise given.error("lamp", "a position, or instead of it a direction")
    direction = given.direction if turn is None else turn @ given.direction
    distance = given.distance if isinstance(given, Shot) else None
    if distance is None:
        return Lamp(direction, True)
    return Lamp(middle + distance * direction if ball is None else Highlight(ball, direction, middle).at(distance),
                False)


def alike(lamps: Sequence[Lamp], path: Path) -> bool:
    """Whether the lamps of photographs, one or more, are far. DatasetError if some are, and others are not: it is not
    known then how bright they are beside each other."""
    if len({lamp.is_far for lamp in lamps}) > 1:
        raise DatasetError("some lamps have a place, and some only a direction, expected the same of all: give chrome "
                           "balls their distance, or places in the place of directions", path)
    return lamps[0].is_far
