"""Where a lamp is, by its highlight on a chrome ball."""

from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, BoolArray, FloatArray, RealArray
from ..errors import DatasetError
from .ball_finding import regions

_BRIGHT = 0.5               # of the brightest pixel: what is the lamp's image
_WITHIN = 0.97              # of the ball's radius: pixels at its rim see what is beside it, too
_SPREAD = 0.3               # of the ball's radius, that this image may have
_ANOTHER = 0.5              # of its light, from which another patch is another lamp: less is dust, or a reflection


class Highlight(NamedTuple):
    """The line from a point of a ball toward the lamp."""

    point: FloatArray
    """On the ball: (3,), metres."""
    direction: FloatArray
    """Unit vector: (3,)."""
    centre: FloatArray
    """Of the ball: (3,), metres."""

    def at(self, distance: float) -> FloatArray:
        """The place on the line that is so far from the ball's centre, metres: (3,).

        Raises DatasetError if the distance is within the ball.
        """
        from_centre = self.point - self.centre
        if not distance > np.linalg.norm(from_centre):
            raise DatasetError(f"a lamp {distance:g} m from the middle of the ball found, expected more than its "
                               f"radius")
        along = float(from_centre @ self.direction)
        return np.asarray(self.point + self.direction * (
            np.sqrt(along ** 2 + distance ** 2 - from_centre @ from_centre) - along))


def lamp_of_highlight(radiance: RealArray, rays: FloatArray, camera: ArrayLike, centre: ArrayLike, radius: float,
                      name: str = "photograph") -> Highlight:
    """The direction to a lamp whose image a chrome ball shows.

    Its image is the largest bright patch. Raises DatasetError if the ball is not in the picture, is dark, or shows more
    than one lamp.

    Parameters
    ----------
    radiance : (height, width, channels)
        It may be saturated.
    rays : (height, width, 3) float64
        Directions through the pixels' centres.
    camera, centre : (3,) array_like
        Metres.
    radius : float
        Of the ball, metres.
    name : str
        For messages.
    """
    camera, centre = (np.asarray(place, dtype=float) for place in (camera, centre))
    axis = centre - camera
    nearest = rays @ axis
    miss = np.linalg.norm(axis - nearest[..., None] * rays, axis=-1)
    grey = np.where((miss < _WITHIN * radius) & (nearest > 0), radiance.mean(axis=2), 0.0)
    if not grey.max() > 0:
        raise DatasetError("no highlight found: the chrome ball is not in the picture, or dark", name)
    bright = _largest_patch(np.where(grey >= _BRIGHT * grey.max(), grey, 0.0), name)
    ray = np.average(rays[bright], axis=0, weights=grey[bright])
    ray /= np.linalg.norm(ray)
    spread = np.linalg.norm(rays[bright] - ray, axis=1).max() * np.linalg.norm(axis)
    if spread > _SPREAD * radius:
        raise DatasetError("a highlight as large as the chrome ball found: it is dark, or reflects the room", name)
    along = float(ray @ axis)
    point = camera + ray * (along - np.sqrt(max(radius ** 2 - axis @ axis + along ** 2, 0.0)))
    normal = (point - centre) / radius
    return Highlight(point, ray - 2 * (ray @ normal) * normal, centre)


def _largest_patch(grey: FloatArray, name: str) -> BoolArray:
    """The pixels above 0 that touch and have most light: (height, width)."""
    there = grey > 0
    rows, columns = (np.flatnonzero(there.any(axis=axis)) for axis in (1, 0))
    part = np.s_[rows[0]:rows[-1] + 1, columns[0]:columns[-1] + 1]
    first, *others = sorted(regions(there[part]), key=lambda each: -float(grey[part][each].sum()))
    if others and grey[part][others[0]].sum() > _ANOTHER * grey[part][first].sum():
        raise DatasetError("more than one highlight found on the chrome ball", name)
    found = np.zeros_like(there)
    found[part] = first
    return found
