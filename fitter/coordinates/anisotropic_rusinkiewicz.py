"""Half and difference vectors of a pair of directions as four smooth coordinates, for anisotropic reflectance.

The half vector h lies at theta_h from the normal; the difference vector d, the incident direction after the shortest
turn that takes h to the normal, at theta_d. With the projection r of `half_difference`, and R, a turn into the axes of
the reflectance ::

    mu = (stretched(R r(h)), R r(d)),    u = (k_x x, k_y y),
    stretched(x, y) = u asinh(|u|) / |u| / asinh(max(k_x, k_y))

Unlike an azimuth about h, the shortest turn has no seam above the horizon. Exchanging the directions reflects d, and a
lattice stores one half of it. By stretches of their own for both axes the highlight of a brushed metal is nearly round.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, ComplexArray, Directions, FloatArray
from ..shader_constants import LEAST_HEIGHT_2
from .anisotropic_nusselt import fold_difference, unfold_difference
from .half_difference import unproject


@dataclass(frozen=True)
class AnisotropicRusinkiewicz:
    """These coordinates as a `coordinates.Coordinates`."""

    along: float = 1.0      # the stretches k_x and k_y of the half vector,
    across: float = 1.0     # from a tenth of `stretch.LEAST_STRETCH` to `stretch.LARGEST_STRETCH`
    turn: float = 0.0       # the azimuth of the first axis, radians
    name: ClassVar[str] = "anisotropic_rusinkiewicz"
    axes: ClassVar[tuple[str, ...]] = ("half_x", "half_y", "difference_x", "difference_y")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions, angles broadcast to (...), radians, to (mu + 1) / 2: (..., 4) float64 in [0, 1]."""
        theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
        p_i, p_o = (np.sin(theta) * np.exp(1j * (np.asarray(phi, dtype=float) - self.turn))
                    for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
        z_i, z_o = np.cos(theta_i), np.cos(theta_o)
        both = p_i + p_o
        length = np.sqrt(np.maximum(np.abs(both) ** 2 + (z_i + z_o) ** 2, LEAST_HEIGHT_2))
        h, h_z = both / length, (z_i + z_o) / length
        d = p_i - (length / 2 + z_i) / (1 + h_z) * h
        return fold_difference(self._stretch(h / (1 + 2 * h_z)), d / (1 + length))

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 4) to directions, four (...) arrays, radians. Those below the horizon move to it."""
        half, difference = unfold_difference(x)
        h, h_z = _unproject(self._unstretch(half))
        d, d_z = _unproject(difference)
        angles: list[FloatArray] = []
        for sign in (1, -1):
            # the turn that takes the normal to h, of sign d
            along = sign * (d * np.conj(h)).real
            p = sign * d + (d_z - along / (1 + h_z)) * h
            z = d_z * h_z - along
            angles += [np.arctan2(np.abs(p), np.maximum(z, 0)), np.angle(p) + self.turn]
        return angles[0], angles[1], angles[2], angles[3]

    def _stretch(self, point: ComplexArray) -> ComplexArray:
        u = self.along * point.real + 1j * self.across * point.imag
        length = np.maximum(np.abs(u), np.finfo(float).tiny)
        return np.asarray(u * (np.arcsinh(length) / length / np.arcsinh(max(self.along, self.across))))

    def _unstretch(self, point: ComplexArray) -> ComplexArray:
        length, scale = np.maximum(np.abs(point), np.finfo(float).tiny), np.arcsinh(max(self.along, self.across))
        u = point * (np.sinh(scale * length) / length)
        return np.asarray(u.real / self.along + 1j * u.imag / self.across)


def _unproject(point: ComplexArray) -> tuple[ComplexArray, FloatArray]:
    """A point of the disk as a direction: its part in the surface and its height, (...) each."""
    radius = np.abs(point)
    theta = unproject(np.minimum(radius, 1))
    unit = point / np.maximum(radius, np.finfo(float).tiny)
    return np.sin(theta) * unit, np.cos(theta)
