"""What is stored of a reflectance, and what can be asked of it."""

from typing import Protocol

from ..arrays import ArrayLike, FloatArray


class Reflectance(Protocol):
    """A BRDF that can be evaluated."""

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr, without the cosine: angles broadcast to (...), radians, to (..., channels)."""
        ...


def is_isotropic(model: Reflectance) -> bool:
    """Whether a model is isotropic; one that does not say so is."""
    return bool(getattr(model, "isotropic", True))
