"""Nusselt coordinates of a pair of directions that turns with nothing, for anisotropic reflectance, by projections p of
both onto the surface (Kameya and Lewis 2002, section 3.2) ::

    mu = ((p_i + p_o) / 2, (p_i - p_o) / 2)

Exchanging the directions reflects the last two, of which a lattice stores one half. The cells are as fine as those of
p_i and p_o themselves, and the pairs lie in a ball, so that fewer are never read.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, ComplexArray, Directions, FloatArray


@dataclass(frozen=True)
class AnisotropicNusselt:
    """These coordinates as a `coordinates.Coordinates`."""

    name: ClassVar[str] = "anisotropic_nusselt"
    axes: ClassVar[tuple[str, ...]] = ("sum_x", "sum_y", "difference_x", "difference_y")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Map directions, angles broadcast to (...), radians, to (mu + 1) / 2: (..., 4) float64 in [0, 1]."""
        p_i, p_o = (np.sin(np.asarray(theta, dtype=float)) * np.exp(1j * np.asarray(phi, dtype=float))
                    for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)))
        return fold_difference((p_i + p_o) / 2, (p_i - p_o) / 2)

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 4) to four (...) arrays, radians; those outside the disk move to its rim."""
        half, difference = unfold_difference(x)
        p_i, p_o = half + difference, half - difference
        return (np.arcsin(np.minimum(np.abs(p_i), 1)), np.angle(p_i),
                np.arcsin(np.minimum(np.abs(p_o), 1)), np.angle(p_o))


def fold_difference(half: ComplexArray, difference: ComplexArray) -> FloatArray:
    """Two points of the unit disk, (...) each, as (mu + 1) / 2: (..., 4), the last of at least 1/2."""
    half, difference = np.broadcast_arrays(half, difference)
    difference = np.where(difference.imag < 0, -difference, difference)
    return (np.stack([half.real, half.imag, difference.real, difference.imag], axis=-1) + 1) / 2


def unfold_difference(x: ArrayLike) -> tuple[ComplexArray, ComplexArray]:
    """The two points of coordinates (..., 4)."""
    a, b, c, d = np.moveaxis(2 * np.asarray(x, dtype=float) - 1, -1, 0)
    return a + 1j * b, c + 1j * d
