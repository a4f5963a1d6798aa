"""The transform that maps the field of lattices to reflectance, where the field is not the reflectance itself."""

import dataclasses
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..coordinates.half_difference import project
from ..lattice import dense
from ..shader_constants import LARGEST_EXPONENT
from .microfacet import Microfacet

LEAST_OFFSET = 1e-30        # 1/sr: below any reflectance, but not 0 in single precision


@dataclass(frozen=True)
class LogRelative:
    """The field is the logarithm of the reflectance f relative to that of a prior b ::

        s = log((f + offset) / (b + offset))

    of reflectances that are desaturated; what bounds it, and undoes that, is in docs/fitting.md (step 2). The logarithm
    flattens peaks, keeps the reflectance positive, and makes errors relative. It is the log-relative mapping of J. B.
    Nielsen, H. W. Jensen, R. Ramamoorthi: On Optimal, Minimal BRDF Sampling for Reflectance Acquisition, SIGGRAPH Asia
    2015, with a prior in the place of their median of materials.

    The damping is a cubic B-spline whose knots are even in the projection r(theta) of `coordinates.half_difference`;
    its control points are continued beyond the normal by their mirror images, beyond the horizon by the last.
    """

    name: ClassVar[str] = "log_relative"
    prior: Microfacet
    offset: float                   # 1/sr; differences between reflectances far below it hardly change the field
    ceiling: FloatArray             # upper bounds of the reflectance, 1/sr, (channels,)
    floor: float = -np.inf          # lower bound, 1/sr: 0, or minus infinity to keep noise around 0
    # (DAMPING_KNOTS, channels) from 0 to 1, or (0, 1) for none
    damping: FloatArray = dataclasses.field(default_factory=lambda: np.zeros((0, 1)))
    desaturation: float = 0.0       # at least 0 and less than 1

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters in single precision."""
        return self.prior.nbytes + 12 + 4 * len(self.ceiling) + 4 * self.damping.size

    @property
    def isotropic(self) -> bool:
        """Whether the prior is."""
        return self.prior.isotropic

    def reflectance(self, field: FloatArray, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
                    phi_o: ArrayLike) -> FloatArray:
        """Map a field at directions (n,) to reflectance: (n, channels) to (n, channels), 1/sr."""
        reference = self.prior.evaluate(theta_i, phi_i, theta_o, phi_o) + self.offset
        value = reference * np.exp(np.minimum(field, LARGEST_EXPONENT)) - self.offset
        value = value / _smooth_max_one((value / self.ceiling).max(axis=1, keepdims=True))
        value = np.maximum(resaturate(value, self.desaturation), self.floor)
        if len(self.damping):
            value = value * factor_of_angle(self.damping, theta_i) * factor_of_angle(self.damping, theta_o)
        return value

    def field(self, values: FloatArray, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
              phi_o: ArrayLike) -> FloatArray:
        """The inverse of `reflectance`, without the bounds: (n, channels), 1/sr, to (n, channels)."""
        reference = self.prior.evaluate(theta_i, phi_i, theta_o, phi_o)
        return bounded_log(desaturate(values, self.desaturation), self.offset) - bounded_log(reference, self.offset)


def _smooth_max_one(x: FloatArray) -> FloatArray:
    """max(1, x), twice differentiable: the 16-norm of both."""
    larger = np.maximum(x, 1)
    return np.asarray(larger * (1 + (np.minimum(x, 1) / larger) ** 16) ** 0.0625)


def desaturate(values: FloatArray, grey: float) -> FloatArray:
    """Values mixed with their mean over channels, by weights 1 - grey and grey: (n, channels) to (n, channels)."""
    return values + grey * (values.mean(axis=1, keepdims=True) - values)


def resaturate(values: FloatArray, grey: float) -> FloatArray:
    """The inverse of `desaturate`."""
    return values + grey / (1 - grey) * (values - values.mean(axis=1, keepdims=True))


def factor_of_angle(control_points: FloatArray, theta: ArrayLike) -> FloatArray:
    """The factor of a polar angle by its spline in `LogRelative`: (DAMPING_KNOTS, n) and (m,) radians to (m, n)."""
    last = len(control_points) - 1
    at = np.atleast_1d(project(theta) * last)
    first = np.minimum(at.astype(int), last - 1)
    taps = np.minimum(np.abs(first[:, None] + np.arange(-1, 3)), last)
    return np.einsum("mk,mkn->mn", dense.weights(at - first), control_points[taps])


def bounded_log(values: FloatArray, offset: float) -> FloatArray:
    """log(f + offset), at least log(0.05 offset), as noise may bring f below -offset: 1/sr, of any shape."""
    return np.log(np.maximum(values + offset, 0.05 * offset))
