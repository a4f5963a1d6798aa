"""The microfacet model that J. Low, J. Kronander, A. Ynnerman, J. Unger (BRDF Models for Accurate and Efficient
Rendering of Glossy Surfaces, ACM TOG 31(1), 2012) fitted to all materials of MERL, in which all channels share the
shape of the lobe and its index of refraction ::

    f = kd / pi + A F(eta, theta_d) G / (pi cos theta_i cos theta_o (1 + B (1 - cos theta_h))^C)
    G = min(1, 2 cos theta_h cos theta_o / c, 2 cos theta_h cos theta_i / c),    c = cos theta_d

F, that of a dielectric, and G are those of R. L. Cook, K. E. Torrance: A Reflectance Model for Computer Graphics, ACM
TOG 1(1), 1982.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..optics.fresnel import fresnel
from .microfacet import geometry

_LEAST = 1e-9               # the least that is divided by


@dataclass(frozen=True)
class Low2012:
    """A published fit."""

    kd: FloatArray      # albedo of the Lambertian, (channels,)
    a: FloatArray       # scale of the lobe, (channels,)
    b: float            # its width,
    c: float            # and its fall-off
    eta: float          # index of refraction

    @property
    def width(self) -> float:
        """The half angle within which the lobe is level, radians."""
        return float(min(0.05 * np.sqrt(2 / self.b), 0.01))

    def log_falloff(self, theta_h: FloatArray) -> FloatArray:
        """By how much the logarithm of the lobe is lower than at its peak, at half angles of (n,) radians."""
        return np.asarray(self.c * np.log1p(self.b * (1 - np.cos(theta_h))))

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        at = geometry(theta_i, phi_i, theta_o, phi_o)
        cos_h = 1 / np.sqrt(1 + at.tan2_h)
        shadowing = np.minimum(1, 2 * cos_h * np.minimum(at.cos_i, at.cos_o) / np.maximum(at.cos_d, _LEAST))
        lobe = fresnel(self.eta, at.cos_d) * shadowing / (np.pi * np.maximum(at.cos_i * at.cos_o, _LEAST))
        lobe /= (1 + self.b * (1 - cos_h)) ** self.c
        return self.kd / np.pi + self.a * lobe[..., None]
