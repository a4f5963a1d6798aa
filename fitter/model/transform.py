"""What turns the function that the lattices hold, the field, into a reflectance."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..shader_constants import STEEPEST
from .microfacet import Microfacet

LEAST_OFFSET = 1e-30        # 1/sr: darker than any reflectance, and still a number in single precision


class Transform(Protocol):
    """What a transform offers. Transforms are frozen dataclasses."""

    name: ClassVar[str]
    """How files and shaders call the transform."""

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters in single precision."""
        ...

    def reflectance(self, field: FloatArray, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
                    phi_o: ArrayLike) -> FloatArray:
        """The reflectance that a field stands for: (n, channels) to (n, channels), 1/sr."""
        ...


@dataclass(frozen=True)
class Identity:
    """The field is the reflectance itself (Kameya and Lewis 2002)."""

    name: ClassVar[str] = "identity"

    @property
    def nbytes(self) -> int:
        """There are no parameters."""
        return 0

    def reflectance(self, field: FloatArray, *_directions: ArrayLike) -> FloatArray:
        """The field as it is."""
        return field


IDENTITY = Identity()


@dataclass(frozen=True)
class LogRelative:
    """The field is the logarithm of the reflectance f relative to that of a prior b ::

        s = log((f + offset) / (b + offset))

    Logarithms turn a peak into a hill, keep the reflectance positive, and ask for relative rather than absolute
    accuracy (the log-relative mapping of J. B. Nielsen, H. W. Jensen, R. Ramamoorthi: On Optimal, Minimal BRDF Sampling
    for Reflectance Acquisition, SIGGRAPH Asia 2015, whose reference is a median of materials instead of a prior).

    Attributes
    ----------
    prior : Microfacet
    offset : float
        1/sr: differences between reflectances well below it hardly count.
    ceiling : (channels,) float64
        1/sr: the reflectance is never above it.
    floor : float
        1/sr: the reflectance is never below it. 0, or minus infinity where noise around 0 is to be kept.
    """

    name: ClassVar[str] = "log_relative"
    prior: Microfacet
    offset: float
    ceiling: FloatArray
    floor: float = -np.inf

    @property
    def nbytes(self) -> int:
        """Bytes of the parameters in single precision."""
        return self.prior.nbytes + 8 + 4 * len(self.ceiling)

    def reflectance(self, field: FloatArray, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
                    phi_o: ArrayLike) -> FloatArray:
        """The reflectance that a field stands for: (n, channels) to (n, channels), 1/sr."""
        around = self.prior.evaluate(theta_i, phi_i, theta_o, phi_o) + self.offset
        return np.clip(around * np.exp(np.minimum(field, STEEPEST)) - self.offset, self.floor, self.ceiling)

    def field(self, values: FloatArray, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike,
              phi_o: ArrayLike) -> FloatArray:
        """The field that stands for reflectances: (n, channels), 1/sr, to (n, channels)."""
        around = self.prior.evaluate(theta_i, phi_i, theta_o, phi_o)
        return bounded_log(values, self.offset) - bounded_log(around, self.offset)


def bounded_log(values: FloatArray, offset: float) -> FloatArray:
    """log(f + offset), bounded from below where noise brings f below -offset: (n, channels), 1/sr, to (n, channels).

    >>> bounded_log(np.array([0.0, -2.0]), 1.0).round(3)
    array([ 0.   , -2.996])
    """
    return np.log(np.maximum(values + offset, 0.05 * offset))
