"""Half and difference angles of a pair of directions (S. Rusinkiewicz: A New Change of Variables for Efficient BRDF
Representation, Eurographics Workshop on Rendering 1998), as three smooth coordinates (docs/fitting.md).

A lobe of microfacets has one width in theta_h at every angle of incidence, so that a highlight that was measured at
some is predicted well between. phi_d has no value where the directions coincide. With i and o their unit vectors, sin
theta_d = |i - o| / 2 is replaced by a length s that is at least a softening radius delta ::

    s^4 = delta^4 + (1 - delta^4) sin^4 theta_d,    x = (o_z - i_z) / (2 s (1 + 2 cos theta_h)),
    y^2 = r^2(theta_h) - x^2

so that mu is smooth in both directions, as in `half_difference`, and exchanging them only changes the sign of x.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray
from ..shader_constants import LEAST_HEIGHT_2
from . import half_difference, stretch

SINES = 3.0                 # times the radii of `half_difference`, near retro-reflection
RUSINKIEWICZ_SOFTENING = SINES * half_difference.HALF_DIFFERENCE_SOFTENING      # the largest radius delta of new fits
LEAST_SOFTENING = 1e-3      # below, single precision shows near retro-reflection


class Pair(NamedTuple):
    """What the half and the difference angles of pairs of directions i and o are found from: (...) arrays."""

    cos_i: FloatArray       # their heights
    cos_o: FloatArray
    along2: FloatArray      # squared lengths of i + o along the surface, and in all
    sum2: FloatArray
    sin2_d: FloatArray      # of the difference angle
    outer: FloatArray       # the height of i x o

    @classmethod
    def from_angles(cls, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> "Pair":
        """From angles that broadcast to (...), radians, without cancellation."""
        theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
        turn = np.asarray(phi_o, dtype=float) - phi_i
        cos_i, cos_o, sin_i, sin_o = np.cos(theta_i), np.cos(theta_o), np.sin(theta_i), np.sin(theta_o)
        along2 = (sin_i - sin_o) ** 2 + 4 * sin_i * sin_o * np.cos(turn / 2) ** 2
        sum2 = np.maximum(along2 + (cos_i + cos_o) ** 2, LEAST_HEIGHT_2)
        sin2_d = ((cos_i - cos_o) ** 2 + (sin_i - sin_o) ** 2 + 4 * sin_i * sin_o * np.sin(turn / 2) ** 2) / 4
        return cls(cos_i, cos_o, along2, sum2, sin2_d, sin_i * sin_o * np.sin(turn))


def half_to_directions(theta_h: ArrayLike, up: FloatArray, aside: FloatArray, cos_d: FloatArray) -> Directions:
    """The directions of a half vector at the azimuth 0, theta_h from the normal, and of a difference vector: (...)
    each, radians, polar angles up to pi. Of the latter are given sin theta_d cos phi_d, toward the normal, sin theta_d
    sin phi_d, along the surface, and cos theta_d."""
    sin_h, cos_h = np.sin(theta_h), np.cos(theta_h)
    angles: list[FloatArray] = []
    for sign in (1, -1):
        along, across = sin_h * cos_d + sign * cos_h * up, sign * aside
        angles += [np.arctan2(np.hypot(along, across), cos_h * cos_d - sign * sin_h * up), np.arctan2(across, along)]
    return angles[0], angles[1], angles[2], angles[3]


def clamp_to_horizon(directions: Directions) -> Directions:
    """Directions whose light comes from the azimuth 0; those below the horizon are moved to it, (...) each."""
    theta_i, phi_i, theta_o, phi_o = directions
    turn = np.abs((phi_o - phi_i + np.pi) % (2 * np.pi) - np.pi)
    return np.minimum(theta_i, np.pi / 2), np.zeros_like(turn), np.minimum(theta_o, np.pi / 2), turn


@dataclass(frozen=True)
class Rusinkiewicz:
    """These coordinates as a `coordinates.Coordinates`."""

    softening: float = RUSINKIEWICZ_SOFTENING       # the softening radius delta, at least `LEAST_SOFTENING`
    stretch: float = stretch.NO_STRETCH             # k of the half vector: as of `HalfDifference`
    name: ClassVar[str] = "rusinkiewicz"
    axes: ClassVar[tuple[str, ...]] = ("d", "x", "y")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions, angles broadcast to (...), radians, to (mu + 1) / 2: (..., 3) float64 in [0, 1]."""
        pair = Pair.from_angles(theta_i, phi_i, theta_o, phi_o)
        along2, sum2, sin2_d = pair.along2, pair.sum2, pair.sin2_d
        delta2 = self.softening ** 2
        s2 = np.hypot(delta2, np.sqrt(1 - delta2 ** 2) * sin2_d)
        s = np.sqrt(s2)
        # 1 - s^2, and s^2 - sin^2 theta_d, without cancellation
        rest = (1 - delta2 ** 2) * (sum2 / 4) * (1 + sin2_d) / (1 + s2)
        over = delta2 ** 2 * (sum2 / 4) * (1 + sin2_d) / (s2 + sin2_d)
        d = s / (1 + 2 * np.sqrt(rest))
        y = np.sqrt(along2 * over + pair.outer ** 2) / (np.sqrt(sum2) * s)
        spread = 1 + 2 * (pair.cos_i + pair.cos_o) / np.sqrt(sum2)
        d, x, y = np.broadcast_arrays(d, (pair.cos_o - pair.cos_i) / (2 * s) / spread, y / spread)
        return (np.stack([d, *stretch.stretch_half_vector(x, y, self.stretch)], axis=-1) + 1) / 2

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 3) to directions, (...) radians each, phi_i 0; those below the horizon move to it."""
        d, along, across = np.moveaxis(2 * np.asarray(x, dtype=float) - 1, -1, 0)
        x, y = stretch.unstretch_half_vector(along, across, self.stretch)
        delta2 = self.softening ** 2
        s = np.sin(half_difference.unproject(np.abs(d)))
        sin_d = np.minimum((np.maximum(s ** 4 - delta2 ** 2, 0) / (1 - delta2 ** 2)) ** 0.25, 1)
        cos_d = np.sqrt(1 - sin_d ** 2)
        radius = np.hypot(x, y)
        theta_h = half_difference.unproject(radius)
        # sin theta_d cos phi_d, toward the normal, and sin theta_d sin phi_d, along the surface
        up = np.clip(np.divide(x * s, radius, out=np.zeros_like(s), where=radius > 0), -sin_d, sin_d)
        side = np.sqrt(np.maximum(sin_d ** 2 - up ** 2, 0))
        return clamp_to_horizon(half_to_directions(theta_h, up, side, cos_d))
