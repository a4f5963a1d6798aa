"""What is stored of a reflectance, and what can be asked of it.

`Fit` is this project's own model; the report's baselines are others.
"""

from typing import Protocol

from ..arrays import ArrayLike, FloatArray


class Reflectance(Protocol):
    """A BRDF that can be evaluated."""

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr, without the cosine: angles broadcast to (...), radians, to (..., channels)."""
        ...


class Model(Reflectance, Protocol):
    """A BRDF that was fitted to samples, and what it takes to store it: `Fit`, `Koenderink`, `Lafortune`."""

    @property
    def coefficient_count(self) -> int:
        """Coefficients stored, counted once whatever the number of channels."""
        ...

    @property
    def nbytes(self) -> int:
        """Bytes that must be stored to evaluate all channels."""
        ...


def is_isotropic(model: Reflectance) -> bool:
    """Whether a model is isotropic; one that does not say so is."""
    return bool(getattr(model, "isotropic", True))
