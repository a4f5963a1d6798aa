"""A microfacet model, used as the prior of `LogRelative`: a Lambertian and up to two lobes ::

    b = kd + sum_k ks_k D_k(theta_h) F_k(theta_d) V_k(theta_i, theta_o),     D = (1 + tan^2 theta_h / alpha^2)^-gamma

D is a generalised Trowbridge-Reitz distribution (B. Burley: Physically Based Shading at Disney, 2012), V the
height-correlated Smith visibility (E. Heitz: Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs,
JCGT 3(2), 2014) and F the Fresnel term of C. Schlick: An Inexpensive BRDF Model for Physically-based Rendering, 1994.
A material of three channels has at most 15 parameters.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..shader_constants import DENSEST, LEAST_HEIGHT_2

MAX_LOBES = 2
NARROWEST, STEEPEST_TAIL = 1e-3, 32.0       # bounds of alpha and gamma - 1: beyond, single precision is visible
RANGES = {"alpha": (NARROWEST, STEEPEST_TAIL), "gamma": (1 + NARROWEST, 1 + STEEPEST_TAIL), "f0": (0.0, 1.0)}


class Geometry(NamedTuple):
    """The quantities that the model depends on, each (...) float64."""

    cos_i: FloatArray
    cos_o: FloatArray
    tan2_h: FloatArray
    """Squared tangent of the half angle theta_h."""
    cos_d: FloatArray
    """Cosine of the difference angle theta_d."""


@dataclass(frozen=True)
class Microfacet:
    """A Lambertian and lobes.

    Attributes
    ----------
    kd : (channels,) float64
        Diffuse reflectance, 1/sr.
    ks : (lobes, channels) float64
        Scale of each lobe, 1/sr.
    alpha, gamma, f0 : (lobes,) float64
        Of each lobe: its width, as a slope; the exponent of its tail; Fresnel reflectance at normal incidence, relative
        to that at grazing incidence.

    Examples
    --------
    The model is reciprocal.

    >>> glossy = Microfacet(np.array([0.1]), np.array([[2.0]]), np.array([0.2]), np.array([2.0]), np.array([0.04]))
    >>> forth, back = glossy.evaluate(0.3, 0, 1.1, 2), glossy.evaluate(1.1, 2, 0.3, 0)
    >>> bool(np.allclose(forth, back)), bool(forth[0] > 0.1)
    (True, True)
    """

    kd: FloatArray
    ks: FloatArray
    alpha: FloatArray
    gamma: FloatArray
    f0: FloatArray

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters of all channels in single precision."""
        return 4 * (self.kd.size + self.ks.size + self.alpha.size + self.gamma.size + self.f0.size)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The model, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        return self.at(geometry(theta_i, phi_i, theta_o, phi_o))

    def at(self, geometry: Geometry) -> FloatArray:
        """The model, 1/sr, for a geometry of (...): (..., channels) float64."""
        cos_i, cos_o, tan2_h, cos_d = geometry
        grazing = (1 - cos_d) ** 5
        total = np.broadcast_to(self.kd, (*np.shape(tan2_h), len(self.kd)))
        for ks, alpha, gamma, f0 in zip(self.ks, self.alpha, self.gamma, self.f0, strict=True):
            distribution = (1 + tan2_h / alpha ** 2) ** -gamma
            m2 = min(alpha, 1.0) ** 2
            visibility = 0.5 / (cos_o * np.sqrt(cos_i ** 2 * (1 - m2) + m2)
                                + cos_i * np.sqrt(cos_o ** 2 * (1 - m2) + m2) + DENSEST)
            total = total + ks * (distribution * (f0 + (1 - f0) * grazing) * visibility)[..., None]
        return total


def geometry(theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> Geometry:
    """The geometry of pairs of directions: angles broadcast to (...), radians.

    Examples
    --------
    A mirror pair at 60 degrees: the half vector is the normal, the difference angle 60 degrees.

    >>> found = geometry(np.pi / 3, 0, np.pi / 3, np.pi)
    >>> float(found.tan2_h), float(found.cos_d)
    (0.0, 0.5)
    """
    theta_i, theta_o = np.asarray(theta_i, dtype=float), np.asarray(theta_o, dtype=float)
    cos_i, cos_o = np.cos(theta_i), np.cos(theta_o)
    sin_i, sin_o = np.sin(theta_i), np.sin(theta_o)
    across2 = np.maximum(
        sin_i ** 2 + sin_o ** 2 + 2 * sin_i * sin_o * np.cos(np.asarray(phi_o, dtype=float) - phi_i), 0)
    up2 = np.maximum((cos_i + cos_o) ** 2, LEAST_HEIGHT_2)
    return Geometry(cos_i, cos_o, across2 / up2, np.minimum(np.sqrt(across2 + up2) / 2, 1))
