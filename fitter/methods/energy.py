"""Conservation of energy: lowers a log-relative field where the fit reflects more light than it receives."""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..model.fit import Fit
from ..model.transform import LogRelative
from ..quality.physics import directional_albedo

VIEWS = np.radians(np.append(np.arange(0, 80, 10), np.arange(80, 91, 2.0)))
"""Polar angles at which the albedo is checked, radians."""
ROUNDS = 8                  # of lowering the field; and of bisection, where that fails
TOLERANCE = 2e-3            # by which an albedo may exceed 1
_CELLS = 56                 # of the integral, along each axis


@dataclass(frozen=True)
class Reduction:
    """How much a field is lowered: the sum of one function of theta_i and the same function of theta_o.

    Attributes
    ----------
    table : (len(VIEWS), channels) float64
        That function at `VIEWS`; linear between them.
    """

    table: FloatArray

    @staticmethod
    def none(channels: int) -> "Reduction":
        """The reduction that changes nothing."""
        return Reduction(np.zeros((len(VIEWS), channels)))

    def applied(self, field: FloatArray, theta_i: FloatArray, theta_o: FloatArray) -> FloatArray:
        """Lower a field (..., channels) at directions of these polar angles (...), radians.

        Examples
        --------
        >>> reduction = Reduction(np.full((len(VIEWS), 1), 0.25))
        >>> reduction.applied(np.array([[1.0]]), np.array([0.1]), np.array([0.2])).tolist()
        [[0.5]]
        """
        return field - self._at(theta_i) - self._at(theta_o)

    def increased(self, albedo: FloatArray, offset: float) -> "Reduction":
        """The reduction that, to first order, brings directional albedos (len(VIEWS), channels) down to 1.

        Each of the two directions takes half. Exact for a constant reflectance f, whose albedo is pi f.

        Examples
        --------
        A constant reflectance of albedo 1.25, and no offset: the field falls by log(1.25) in all.

        >>> reduction = Reduction.none(1).increased(np.full((len(VIEWS), 1), 1.25), 0.0)
        >>> float(np.exp(reduction.applied(np.zeros((1, 1)), np.zeros(1), np.zeros(1)))[0, 0])
        0.8
        """
        excess = np.maximum(albedo - 1, 0)
        return Reduction(self.table - 0.5 * np.log1p(-excess / (albedo + np.pi * offset)))

    def _at(self, theta: FloatArray) -> FloatArray:
        return np.stack([np.interp(theta, VIEWS, column) for column in self.table.T], axis=-1)


def albedo(fit: Fit) -> FloatArray:
    """The directional albedo of a fit at `VIEWS`: (len(VIEWS), channels)."""
    return directional_albedo(fit, VIEWS, _CELLS)


def conserves(albedo: FloatArray) -> bool:
    """Whether no directional albedo exceeds 1, to within `TOLERANCE`.

    Examples
    --------
    >>> conserves(np.array([[0.3, 1.001]])), conserves(np.array([[0.3, 1.2]]))
    (True, False)
    """
    return bool(albedo.max() <= 1 + TOLERANCE)


def with_ceiling(fit: Fit, transform: LogRelative) -> Fit:
    """Clip the fit at the highest ceiling with which no albedo exceeds 1: for fits that lowering did not mend."""
    high = transform.ceiling
    low = np.minimum(high, 1 / np.pi)                   # under this ceiling no albedo exceeds 1
    for _ in range(ROUNDS):
        ceiling = np.sqrt(low * high)
        found = albedo(replace(fit, transform=replace(transform, ceiling=ceiling)))
        within = found.max(axis=0) <= 1
        low, high = np.where(within, ceiling, low), np.where(within, high, ceiling)
    return replace(fit, transform=replace(transform, ceiling=low))


def description(before: FloatArray, after: FloatArray) -> str:
    """Say what was changed, given the albedo at `VIEWS` before and after.

    Examples
    --------
    >>> before = np.full((len(VIEWS), 1), 0.9)
    >>> before[3] = 1.25
    >>> description(before, np.minimum(before, 1))
    'directional albedo of 1.25 at 30 degrees lowered to 1'
    """
    worst = np.degrees(VIEWS[before.max(axis=1).argmax()])
    return f"directional albedo of {before.max():.3g} at {worst:.0f} degrees lowered to {after.max():.3g}"
