"""Half and difference coordinates of a pair of directions, in a projection that spreads grazing angles.

Each direction is projected to a point of the unit disk at the radius ``r(theta) = sin theta / (1 + 2 cos theta)``:
as smooth at the normal as the Nusselt projection sin theta, but with room at grazing angles, where measured reflectance
changes fastest. Of the two points q_i and q_o the half vector H = (q_i + q_o) / 2 and the difference
D = (q_i - q_o) / 2 are taken, seen from the frame whose x axis is D (after S. Rusinkiewicz: A New Change of Variables
for Efficient BRDF Representation, 1998, whose half angle and difference angle they stand for).

At exact retro-reflection D vanishes and has no azimuth. Lengths along D are therefore divided by a length d that stays
above a softening radius delta ::

    d^4 = delta^4 + (1 - delta^4) |D|^4,    mu = (d, x, y),    x = H.D / d,    y^2 = |H|^2 - x^2

|D|^2, |H|^2 and H.D are smooth in both directions wherever these are, and d is never 0: so are d, x and y^2, and hence
every function of them that is even in y. Where |D| is well above delta, mu tends to (|D|, H_x, |H_y|), which it is for
delta = 0.

A mirror lobe lies along the axis H = 0 whatever the angle of incidence, normal incidence is a point like any other, and
exchanging the two directions only changes the sign of x. The image is within the bounds of Nusselt coordinates, so that
the same lattices serve both.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray
from ..shader_constants import LEAST_LENGTH

SOFTENING = 0.01             # the softening radius delta of new fits


@dataclass(frozen=True)
class HalfDifference:
    """Half and difference coordinates as a `coordinates.Coordinates`.

    Attributes
    ----------
    softening : float
        The softening radius delta; 0 in fits by versions that had none.
    """

    softening: float = SOFTENING
    name: ClassVar[str] = "half_difference"
    axes: ClassVar[tuple[str, ...]] = ("d", "x", "y")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """As `half_difference`."""
        return half_difference(theta_i, phi_i, theta_o, phi_o, self.softening)

    def decode(self, x: ArrayLike) -> Directions:
        """As `directions`."""
        return directions(x, self.softening)


def half_difference(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike,
                    softening: float) -> FloatArray:
    """Coordinates of direction pairs: angles broadcast to (...), radians, to (..., 3) in [0, 1].

    (mu + 1) / 2, as `nusselt.nusselt` scales its own: the first and the third are at least 1/2.
    """
    q_i, q_o = (project(theta) * np.exp(1j * np.asarray(phi, dtype=float))
                for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
    half, difference = (q_i + q_o) / 2, (q_i - q_o) / 2
    length = np.abs(difference)
    d2 = np.hypot(softening ** 2, np.sqrt(1 - softening ** 4) * length ** 2)
    d = np.sqrt(d2)
    # without softening, D has no azimuth where the directions coincide: that of the half vector stands in
    divides = d > LEAST_LENGTH
    axis = np.where(divides, difference, np.where(np.abs(half) > LEAST_LENGTH, half, 1))
    seen = half * np.conj(axis) / np.where(divides, d, np.abs(axis))
    # y^2 = |H|^2 - x^2 as a sum of squares, which loses no digits
    over = softening ** 2 * np.sqrt(np.maximum(1 - length ** 4, 0) / np.where(divides, d2 + length ** 2, 1))
    rest = over * np.abs(half) / np.where(divides, d, 1)
    return (np.stack([d, seen.real, np.hypot(seen.imag, rest)], axis=-1) + 1) / 2


def directions(coordinates: ArrayLike, softening: float) -> Directions:
    """The inverse of `half_difference`, up to a turn about the normal: (..., 3) to four (...) arrays, radians.

    Coordinates outside the image are taken for a point of its rim: of the same |H|, and as far as may be of the same
    |D| and H.D.
    """
    d, x, y = np.moveaxis(2 * np.asarray(coordinates, dtype=float) - 1, -1, 0)
    length2 = np.sqrt(np.maximum(d ** 4 - softening ** 4, 0) / (1 - softening ** 4))
    half2 = x * x + y * y
    # of H and D: the inner product is x d, the outer one this
    over2 = softening ** 4 * (1 - length2 ** 2) / np.maximum(d * d + length2, 1e-300)
    outer = np.sqrt(np.maximum((y * d) ** 2 - half2 * over2, 0))
    half, length = np.sqrt(half2) * np.exp(1j * np.arctan2(outer, x * d)), np.sqrt(length2)
    q_i, q_o = half + length, half - length
    return _theta(np.abs(q_i)), np.angle(q_i), _theta(np.abs(q_o)), np.angle(q_o)


def project(theta: ArrayLike) -> FloatArray:
    """Radius of a direction's projection, r(theta): radians to [0, 1]."""
    theta = np.asarray(theta, dtype=float)
    return np.sin(theta) / (1 + 2 * np.cos(theta))


def _theta(radius: FloatArray) -> FloatArray:
    """The angle whose radius this is: with t = tan(theta / 2), r = 2 t / (3 - t^2)."""
    radius = np.minimum(radius, 1)
    return 2 * np.arctan(3 * radius / (1 + np.sqrt(1 + 3 * radius * radius)))
