"""Nusselt coordinates of a pair of directions.

The projections of two directions onto the surface, mapped affinely to the unit cube: smooth, free of inverse
trigonometry, and without a seam at any azimuth (Kameya and Lewis 2002, section 3.2 and equations 5 and 6). An isotropic
material needs three of the four coordinates, once the incident direction has been turned into the +x half plane, and a
bilaterally symmetric one only ``lambda_o >= 1/2``.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, Directions, FloatArray


@dataclass(frozen=True)
class Nusselt:
    """Nusselt coordinates as a `coordinates.Coordinates`."""

    name: ClassVar[str] = "nusselt"
    axes: ClassVar[tuple[str, ...]] = ("kappa_i", "kappa_o", "lambda_o")

    def encode(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """As `nusselt`."""
        return nusselt(theta_i, phi_i, theta_o, phi_o)

    def decode(self, x: ArrayLike) -> Directions:
        """As `directions`."""
        return directions(x)


def nusselt(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
    """Nusselt coordinates of direction pairs (Kameya and Lewis 2002, equations 5 and 6).

    Parameters
    ----------
    theta_i, phi_i, theta_o, phi_o : array_like, broadcast to (...)
        Incident and outgoing direction, radians.

    Returns
    -------
    (..., 3) float64
        ``kappa_i`` in [1/2, 1], ``kappa_o`` in [0, 1] and ``lambda_o`` in [1/2, 1], folded by bilateral symmetry.

    Examples
    --------
    >>> nusselt(np.pi / 2, 0, np.pi / 2, np.pi).round(6)
    array([1. , 0. , 0.5])
    """
    delta_phi = np.asarray(phi_o, dtype=float) - phi_i
    sin_o = np.sin(np.asarray(theta_o, dtype=float))
    sin_i = np.sin(np.asarray(theta_i, dtype=float))
    mu = np.broadcast_arrays(sin_i, sin_o * np.cos(delta_phi), sin_o * np.abs(np.sin(delta_phi)))
    return (np.stack(mu, axis=-1) + 1) / 2


def directions(coordinates: ArrayLike) -> Directions:
    """The inverse of `nusselt`: directions whose incident azimuth is 0 and outgoing azimuth is in [0, pi].

    Parameters
    ----------
    coordinates : (..., 3) array_like
        ``kappa_i, kappa_o, lambda_o``. The pair ``(kappa_o, lambda_o)`` must lie in the disk that the outgoing
        hemisphere projects to; rounding beyond its rim is taken for the rim.

    Returns
    -------
    theta_i, phi_i, theta_o, phi_o : (...) float64
        Radians.
    """
    mu = 2 * np.asarray(coordinates, dtype=float) - 1
    mu_i, mu_x, mu_y = np.moveaxis(mu, -1, 0)
    radius = np.hypot(mu_x, mu_y)
    if (np.abs(mu_i) > 1 + 1e-9).any() or (radius > 1 + 1e-9).any():
        raise ValueError("Nusselt coordinates outside the image of the hemisphere")
    phi_o = np.arctan2(np.abs(mu_y), mu_x)
    return np.arcsin(np.clip(mu_i, 0, 1)), np.zeros_like(phi_o), np.arcsin(np.minimum(radius, 1)), phi_o
