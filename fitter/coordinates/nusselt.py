"""Nusselt coordinates of a pair of directions (Kameya and Lewis 2002, section 3.2, equations 5 and 6): both are turned
about the normal until the incident one is in the +x half plane, projected onto the surface, and mapped to the unit
cube. The map is smooth and has no seam in azimuth. With bilateral symmetry, ``lambda_o >= 1/2`` suffices."""

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
        """Map directions, angles broadcast to (...), radians, to (..., 3) float64, of which two are at least 1/2."""
        delta_phi = np.asarray(phi_o, dtype=float) - phi_i
        sin_i, sin_o = (np.sin(np.asarray(theta, dtype=float)) for theta in (theta_i, theta_o))
        mu = np.broadcast_arrays(sin_i, sin_o * np.cos(delta_phi), sin_o * np.abs(np.sin(delta_phi)))
        return (np.stack(mu, axis=-1) + 1) / 2

    def decode(self, x: ArrayLike) -> Directions:
        """Map coordinates (..., 3) to directions, (...) radians each: phi_i is 0 and phi_o in [0, pi]. Raises
        ValueError if they lie outside the image of the hemispheres."""
        mu_i, mu_x, mu_y = np.moveaxis(2 * np.asarray(x, dtype=float) - 1, -1, 0)
        radius = np.hypot(mu_x, mu_y)
        if (np.abs(mu_i) > 1 + 1e-9).any() or (radius > 1 + 1e-9).any():
            raise ValueError("Nusselt coordinates outside the image of the hemisphere")
        phi_o = np.arctan2(np.abs(mu_y), mu_x)
        return np.arcsin(np.clip(mu_i, 0, 1)), np.zeros_like(phi_o), np.arcsin(np.minimum(radius, 1)), phi_o
