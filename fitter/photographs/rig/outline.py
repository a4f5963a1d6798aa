"""The outline of a ball in a picture, and the edges across it.

Rays r that touch a ball make the same angle with the direction a to its centre, in whatever part of the picture: ::

    r . a = cos gamma,    sin gamma = radius / distance

With v = a / cos gamma that is r . v = 1, which is linear: least squares find v from rays through the outline, where a
circle in the picture would be wrong, for perspective makes it an ellipse.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, BoolArray, FloatArray, IntArray
from .photograph import TO_SIGMA

SECTORS = 48                # of the outline
WINDOW = 6.0                # pixels to both sides of the outline where its edge is looked for
BALL_BRIGHTNESS = 0.02               # a ball is brighter than this share of what its picture has beside the background
ABOVE_NOISE = 6.0           # standard deviations of the background by which a ball is brighter than it
CLEAR = 0.5                 # least share of the brightness within that is missing beyond an edge
_STEP = 0.1                 # pixels between the places that are tried
_ROUNDS = 3                 # of least squares without what is far off


class Outline(NamedTuple):
    """A cone of rays that touch a ball."""

    axis: FloatArray    # toward its centre, a unit vector: (3,)
    half_angle: float   # gamma, radians
    residual: float     # the median distance of the edges that were found from it, pixels

    @classmethod
    def from_vector(cls, v: FloatArray, residual: float = 0.0) -> "Outline":
        """That of v."""
        return cls(v / np.linalg.norm(v), float(np.arccos(1 / np.linalg.norm(v))), residual)

    def centre(self, camera: ArrayLike, radius: float) -> FloatArray:
        """The centre of the ball of this radius, (3,), seen from a camera at (3,)."""
        return np.asarray(camera + self.axis * radius / np.sin(self.half_angle))


def angle_beyond(rays: FloatArray, v: FloatArray) -> FloatArray:
    """The angles of rays beyond the cone of v, radians: (..., 3) to (...)."""
    length = float(np.linalg.norm(v))
    axis = v / length
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(rays, axis), axis=-1), rays @ axis)
                      - np.arccos(min(1 / length, 1.0)))


class Profile(NamedTuple):
    """The edges across an outline, in sectors of it: (sectors,) each, NaN where there are too few pixels."""

    within: FloatArray  # the brightness just within the edge
    beyond: FloatArray  # and beyond it
    edge: FloatArray    # where it is, pixels from the outline outward
    around: FloatArray  # the directions of the sectors' middles, about the axis: (sectors, 3)
    rays: FloatArray    # through the edges: (sectors, 3)


def edge_profile(v: FloatArray, grey: FloatArray, rays: FloatArray, size: float, mask: BoolArray | None = None,
               ) -> Profile:
    """The edges across the outline v of a picture, (h, w); `size` is the angle of a pixel, radians."""
    axis = v / np.linalg.norm(v)
    gamma = float(np.arccos(min(1 / float(np.linalg.norm(v)), 1.0)))
    window = int(max(min(WINDOW, gamma / size / 2), 3))
    off = angle_beyond(rays, v) / size
    near = np.abs(off) < window if mask is None else (np.abs(off) < window) & mask
    x, y = _perpendicular_axes(axis)
    sector = _sector(rays[near], x, y)
    off, value = off[near], grey[near]
    edge = _steps(sector, off, value, np.arange(1 - window, window - 1 + _STEP / 2, _STEP))
    within, beyond = (_means(sector[part], value[part]) for part in (
        (off > edge[sector] - 3) & (off < edge[sector] - 0.5), off > edge[sector] + 1))
    turn = 2 * np.pi * (np.arange(SECTORS) + 0.5) / SECTORS
    around = np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y
    angle = (gamma + edge * size)[:, None]
    return Profile(within, beyond, edge, around, np.cos(angle) * axis + np.sin(angle) * around)


def _steps(sector: IntArray, off: FloatArray, value: FloatArray, places: FloatArray) -> FloatArray:
    """Of some places, in each sector that of the edge by least squares: (sectors,).

    Within an edge at e the brightness is taken to be a + b sqrt(e - off), as a sphere's is, whose normal turns with the
    root of the distance from its outline; and beyond it that of the outermost pixels.
    """
    value = value - np.nan_to_num(_means(sector[off > places[-1]], value[off > places[-1]]))[sector]
    best, edge = np.full(SECTORS, -np.inf), np.zeros(SECTORS)
    for place in places:
        inner, outer = np.maximum(place - off + 0.5, 0), np.maximum(place - off - 0.5, 0)
        columns = inner - outer, (inner ** 1.5 - outer ** 1.5) * 2 / 3       # means over the width of a pixel
        aa, ab, bb, av, bv = (np.bincount(sector, part, SECTORS) for part in (
            columns[0] ** 2, columns[0] * columns[1], columns[1] ** 2, columns[0] * value, columns[1] * value))
        with np.errstate(invalid="ignore", divide="ignore"):
            explained = np.nan_to_num((bb * av ** 2 - 2 * ab * av * bv + aa * bv ** 2) / (aa * bb - ab ** 2))
        better = explained > best
        best, edge = np.where(better, explained, best), np.where(better, place, edge)
    return edge


def _means(sector: IntArray, value: FloatArray) -> FloatArray:
    """The mean of the values in each sector; NaN where there is none."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.bincount(sector, value, SECTORS) / np.bincount(sector, minlength=SECTORS))


def fit_cone(touching: FloatArray, v: FloatArray, size: float) -> tuple[FloatArray, float, float]:
    """The v of rays of which some are wrong, the share of the circle about it where rays agree, and the median distance
    of all from it, pixels; v, 0 and infinity without any."""
    near, off = touching, np.full(1, np.inf)
    for _ in range(_ROUNDS):
        if len(near) < 3:
            return v, 0.0, np.inf
        v = np.asarray(np.linalg.lstsq(near, np.ones(len(near)), rcond=None)[0], dtype=float)
        off = np.abs(angle_beyond(touching, v)) / size
        near = touching[off <= 3 * TO_SIGMA * np.median(off) + 0.05]       # not a stand, nor where the lit part ends
    x, y = _perpendicular_axes(v / np.linalg.norm(v))
    return v, len(np.unique(_sector(near, x, y))) / SECTORS, float(np.median(off))


def _sector(rays: FloatArray, x: FloatArray, y: FloatArray) -> IntArray:
    """In which sector of an outline rays are, (n, 3) to (n,); x and y are at right angles to its axis."""
    return ((np.arctan2(rays @ y, rays @ x) / (2 * np.pi) + 1) * SECTORS).astype(int) % SECTORS


def _perpendicular_axes(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors at right angles to an axis and to each other."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


def scatter(values: FloatArray) -> float:
    """The standard deviation of values (n,) of which some are far off."""
    return TO_SIGMA * float(np.median(np.abs(values - np.median(values))))
