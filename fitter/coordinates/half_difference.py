"""Half and difference coordinates of a pair of directions (docs/fitting.md): the half vector H and the difference
vector D of their points in the unit disk, in the frame whose x axis is D.

At exact retro-reflection D has no azimuth. The component of H along D is therefore computed with a length d that is at
least a softening radius delta ::

    d^4 = delta^4 + (1 - delta^4) |D|^4,    mu = (d, x, y),    x = H.D / d,    y^2 = |H|^2 - x^2

|D|^2, |H|^2 and H.D are smooth functions of both directions, and d is never 0: d, x and y^2 are smooth too, and so is
every smooth function of them that is even in y. A mirror lobe lies along the axis H = 0 at every angle of incidence,
and exchanging the directions only changes the sign of x.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray
from . import stretch

HALF_DIFFERENCE_SOFTENING = 0.03            # the softening radius delta, at most, of new fits


@dataclass(frozen=True)
class HalfDifference:
    """Half and difference coordinates as a `coordinates.Coordinates`."""

    softening: float = HALF_DIFFERENCE_SOFTENING    # the softening radius delta, above 0
    stretch: float = stretch.NO_STRETCH  # k of the half vector: `LEAST_STRETCH` to `LARGEST_STRETCH`, or 0 for none
    name: ClassVar[str] = "half_difference"
    axes: ClassVar[tuple[str, ...]] = ("d", "x", "y")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions, angles broadcast to (...), radians, to (mu + 1) / 2: (..., 3) float64 in [0, 1]."""
        q_i, q_o = (project(theta) * np.exp(1j * np.asarray(phi, dtype=float))
                    for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
        half, difference = (q_i + q_o) / 2, (q_i - q_o) / 2
        length = np.abs(difference)
        delta2 = self.softening ** 2
        d2 = np.hypot(delta2, np.sqrt(1 - delta2 ** 2) * length ** 2)
        d = np.sqrt(d2)
        in_frame = half * np.conj(difference) / d
        # y^2 = |H|^2 - x^2 as a sum of two squares, without cancellation
        rest = delta2 * np.sqrt(np.maximum(1 - length ** 4, 0) / (d2 + length ** 2)) * np.abs(half) / d
        x, y = stretch.stretch_half_vector(in_frame.real, np.hypot(in_frame.imag, rest), self.stretch)
        return (np.stack([d, x, y], axis=-1) + 1) / 2

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 3) to directions, (...) radians each, up to a turn and a mirror image. Those outside
        the image move to its rim: |H| is kept, |D| and H.D as far as possible."""
        d, along, across = np.moveaxis(2 * np.asarray(x, dtype=float) - 1, -1, 0)
        x, y = stretch.unstretch_half_vector(along, across, self.stretch)
        delta4 = self.softening ** 4
        length2 = np.sqrt(np.maximum(d ** 4 - delta4, 0) / (1 - delta4))
        half2 = x * x + y * y
        # H.D is x d; the magnitude of the cross product of H and D is `outer`
        over2 = delta4 * (1 - length2 ** 2) / np.maximum(d * d + length2, 1e-300)
        outer = np.sqrt(np.maximum((y * d) ** 2 - half2 * over2, 0))
        half, length = np.sqrt(half2) * np.exp(1j * np.arctan2(outer, x * d)), np.sqrt(length2)
        q_i, q_o = half + length, half - length
        return unproject(np.abs(q_i)), np.angle(q_i), unproject(np.abs(q_o)), np.angle(q_o)


def project(theta: ArrayLike) -> FloatArray:
    """The radius r(theta) of a projected direction: radians to [0, 1].

    Examples
    --------
    >>> project([0, np.pi / 3, np.pi / 2]).round(6).tolist()
    [0.0, 0.433013, 1.0]
    """
    theta = np.asarray(theta, dtype=float)
    return np.sin(theta) / (1 + 2 * np.cos(theta))


def unproject(radius: FloatArray) -> FloatArray:
    """The inverse of `project`, to radians: r = 2 t / (3 - t^2) with t = tan(theta / 2), solved for theta."""
    radius = np.minimum(radius, 1)
    return 2 * np.arctan(3 * radius / (1 + np.sqrt(1 + 3 * radius * radius)))
