"""Conservation of energy: lowering a log-relative field where its fit reflects more light than it receives."""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..model.fit import Fit
from ..model.transform import LogRelative
from ..quality.physics import directional_albedo

VIEWS = np.radians(np.append(np.arange(0, 80, 10), np.arange(80, 91, 2.0)))     # polar angles that are checked
ROUNDS = 8                  # of lowering; then a ceiling is found by as many bisections
TOLERANCE = 2e-3            # an albedo may exceed 1 by so much
_CELLS = 56                 # of the integral, along each axis


@dataclass(frozen=True)
class Reduction:
    """How much a field is lowered, as a function of the polar angle of each of the two directions.

    Attributes
    ----------
    table : (len(VIEWS), channels) float64
        At `VIEWS`; linear between them.
    """

    table: FloatArray

    @staticmethod
    def none(channels: int) -> "Reduction":
        """The reduction that changes nothing."""
        return Reduction(np.zeros((len(VIEWS), channels)))

    def applied(self, field: FloatArray, theta_i: ArrayLike, theta_o: ArrayLike) -> FloatArray:
        """A field (..., channels) at directions of these polar angles (...), radians, lowered for both of them."""
        return field - self._at(theta_i) - self._at(theta_o)

    def increased(self, albedo: FloatArray, offset: float) -> "Reduction":
        """The reduction that, to first order, brings directional albedos (len(VIEWS), channels) down to 1.

        Each direction is to give half: exact for a constant reflectance, whose albedo is pi f.
        """
        excess = np.maximum(albedo - 1, 0)
        return Reduction(self.table - 0.5 * np.log1p(-excess / (albedo + np.pi * offset)))

    def _at(self, theta: ArrayLike) -> FloatArray:
        return np.stack([np.interp(theta, VIEWS, column) for column in self.table.T], axis=-1)


def albedo(fit: Fit) -> FloatArray:
    """The directional albedo of a fit at `VIEWS`: (len(VIEWS), channels)."""
    return directional_albedo(fit, VIEWS, _CELLS)


def conserves(found: FloatArray) -> bool:
    """Whether no directional albedo exceeds 1."""
    return bool(found.max() <= 1 + TOLERANCE)


def with_ceiling(fit: Fit, transform: LogRelative) -> Fit:
    """The fit under the highest ceiling that makes its albedo 1: for where lowering the field was not enough."""
    high = transform.ceiling
    low = np.minimum(high, 1 / np.pi)                   # under this ceiling no albedo exceeds 1
    for _ in range(ROUNDS):
        ceiling = np.sqrt(low * high)
        found = albedo(replace(fit, transform=replace(transform, ceiling=ceiling)))
        within = found.max(axis=0) <= 1
        low, high = np.where(within, ceiling, low), np.where(within, high, ceiling)
    return replace(fit, transform=replace(transform, ceiling=low))


def description(before: FloatArray, after: FloatArray) -> str:
    """What was changed, in words, given the albedo at `VIEWS` before and after."""
    worst = np.degrees(VIEWS[before.max(axis=1).argmax()])
    return f"directional albedo of {before.max():.3g} at {worst:.0f} degrees lowered to {after.max():.3g}"
