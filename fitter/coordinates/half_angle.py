"""Half and difference angles (`rusinkiewicz`) with an axis for the half angle: mu = (h, x, y), as docs/fitting.md has
it.

A reflectance that depends on theta_h alone, a highlight with its tail, or rings of colour as an interference paint has
them, is a function of one axis, so that a lattice needs few cells for it however narrow they are. Where the half vector
is the normal phi_d has no value, and there c = r^2 / (r^2 + delta^2) makes x 0, so that mu^2 and h x, of which a
function with the symmetries of the lattice is one, are smooth.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray
from . import half_difference, stretch
from .rusinkiewicz import Pair, clamp_to_horizon, half_to_directions

RELATIVE_SOFTENING = 0.3             # delta, times the larger of the stretch and 1


@dataclass(frozen=True)
class HalfAngle:
    """These coordinates as a `coordinates.Coordinates`."""

    stretch: float = stretch.NO_STRETCH     # k of the half angle: as of `HalfDifference`
    back_stretch: float = 0.0               # likewise, of the difference vector (x, y)
    name: ClassVar[str] = "half_angle"
    axes: ClassVar[tuple[str, ...]] = ("h", "x", "y")

    @property
    def softening(self) -> float:
        """The softening radius delta, in proportion to the width that the stretch magnifies."""
        return RELATIVE_SOFTENING / max(self.stretch, 1.0)

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions, angles broadcast to (...), radians, to (mu + 1) / 2: (..., 3) float64 in [0, 1]."""
        pair = Pair.from_angles(theta_i, phi_i, theta_o, phi_o)
        length = np.sqrt(pair.sum2)
        d = np.sqrt(pair.sin2_d) / (1 + length)             # 2 cos theta_d is the length of the sum
        spread = length + 2 * (pair.cos_i + pair.cos_o)
        r = np.sqrt(pair.along2) / spread
        # d cos phi_d, times sin theta_h
        rise = (pair.cos_o - pair.cos_i) / (2 * (1 + length))
        near = r * length / spread                          # r^2 / sin theta_h
        x = np.clip(rise * near / (r ** 2 + self.softening ** 2), -d, d)
        h, _ = stretch.stretch_half_vector(r, np.zeros_like(r), self.stretch)
        x, y = stretch.stretch_half_vector(x, np.sqrt(np.maximum(d ** 2 - x ** 2, 0)), self.back_stretch)
        return (np.stack(np.broadcast_arrays(h, x, y), axis=-1) + 1) / 2

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 3) to directions, (...) radians each, phi_i 0; those below the horizon move to it."""
        h, along, across = np.moveaxis(2 * np.asarray(x, dtype=float) - 1, -1, 0)
        along, across = stretch.unstretch_half_vector(along, across, self.back_stretch)
        side = np.where(h < 0, -1.0, 1.0)
        r, _ = stretch.unstretch_half_vector(np.abs(h), np.zeros_like(h), self.stretch)
        d = np.hypot(along, across)
        scale = r ** 2 / (r ** 2 + self.softening ** 2)
        cosine = np.divide(side * along, d * scale, out=np.zeros_like(d), where=d * scale > 0)
        cosine = np.clip(cosine, -1, 1)
        theta_d = half_difference.unproject(d)
        sin_d = np.sin(theta_d)
        return clamp_to_horizon(half_to_directions(half_difference.unproject(r), sin_d * cosine,
                                                   sin_d * np.sqrt(1 - cosine ** 2), np.cos(theta_d)))
