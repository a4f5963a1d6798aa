"""A mix of two reflectances."""

from dataclasses import dataclass

from ..arrays import ArrayLike, FloatArray
from . import Reflectance, is_isotropic


@dataclass(frozen=True)
class Mix:
    """Two reflectances, each with a share ::

        f = (1 - factor) first + factor second

    Attributes
    ----------
    first, second : Reflectance
        With as many channels as each other, or one.
    factor : float
        The share of the second.

    Examples
    --------
    >>> import numpy as np
    >>> from .microfacet import Microfacet
    >>> none = np.zeros((0, 1)), np.zeros(0), np.zeros(0), np.zeros(0)
    >>> dark, bright = (Microfacet(np.array([value]), *none) for value in (0.1, 0.3))
    >>> Mix(dark, bright, 0.25).evaluate(0.2, 0, 0.4, 1).round(6).tolist()
    [0.15]
    """

    first: Reflectance
    second: Reflectance
    factor: float = 0.5

    def __post_init__(self) -> None:
        if not 0 <= self.factor <= 1:
            raise ValueError(f"factor is {self.factor}, expected 0 to 1")

    @property
    def isotropic(self) -> bool:
        """Whether both are."""
        return is_isotropic(self.first) and is_isotropic(self.second)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles broadcast to (...), radians, to (..., channels) float64."""
        first, second = (each.evaluate(theta_i, phi_i, theta_o, phi_o) for each in (self.first, self.second))
        return (1 - self.factor) * first + self.factor * second
