"""Conservation of energy: damps a fit at the polar angles at which it reflects more light than it receives.

With the directional albedo A(theta), the larger one of both directions of light, the factor ``a(theta_i) a(theta_o)``
with ``a = min(1, 1 / A)`` brings every albedo to at most 1, whatever the fit is: the integral of f a(theta_i) over the
incident directions is at most A(theta_o). The factor is reciprocal, and 1 wherever both albedos are at most 1. Angles
beyond the largest measured one give way first.
"""

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..coordinates.half_difference import unproject
from ..model.fit import Fit
from ..model.transform import LogRelative
from ..samples import Samples
from ..shader_constants import DAMPING_KNOTS

VIEWS = np.radians([*range(0, 80, 2), *range(80, 91)])
"""Polar angles at which the albedo is checked, radians."""
TOLERANCE = 2e-3            # by which an albedo may exceed 1
_FEW = np.radians([*range(0, 75, 15), *range(75, 91, 3)])
_FAR_FROM_1 = 0.9           # a fit whose albedos at these few angles are lower is not looked at closer
_CELLS, _FINE_CELLS = (64, 32), (256, 64)       # of the integral along theta and azimuth: of all, and of large albedos
_LARGE = 0.97               # an albedo that is integrated in finer steps
_MARGIN = 1e-3              # by which damped albedos stay below 1: for what the integral misses


def conserved(fit: Fit, transform: LogRelative, samples: Samples) -> Fit:
    """Damp a fit where its directional albedo exceeds 1; `Fit.changes` says where, and by how much.

    Parameters
    ----------
    fit : Fit
    transform : LogRelative
        That of the fit.
    samples : Samples
        What was fitted: tells how far the measurement reaches, and what it lost.
    """
    farthest = max(float(samples.theta_i.max()), float(samples.theta_o.max()))
    if _integrals(fit, _FEW, _CELLS, farthest)[0].max() < _FAR_FROM_1:
        return fit
    total, beyond = albedo(fit, farthest)
    if total.max() <= 1 + TOLERANCE:
        return fit
    damped = replace(fit, transform=replace(transform, damping=_damping(total, beyond, farthest)))
    return replace(damped, changes=(_description(fit, damped, total, farthest, samples),))


def albedo(fit: Fit, farthest: float = np.pi / 2) -> tuple[FloatArray, FloatArray]:
    """The directional albedo of a fit at `VIEWS`, and the part of it from beyond a polar angle: (views, channels) each.

    The larger one for light that arrives at the angle and for light that leaves there.
    """
    result = _integrals(fit, VIEWS, _CELLS, farthest)
    large = result[0].max(axis=1) > _LARGE
    if large.any():
        result[:, large] = _integrals(fit, VIEWS[large], _FINE_CELLS, farthest)
    return result[0], result[1]


def _integrals(fit: Fit, theta: FloatArray, cells: tuple[int, int], farthest: float) -> FloatArray:
    """The integrals of `albedo` by the midpoint rule: (2, angles, channels).

    The azimuths are dense at the plane of incidence, where mirror reflection and retro-reflection are.
    """
    other = (np.arange(cells[0]) + 0.5) / cells[0] * (np.pi / 2)
    u = (np.arange(cells[1]) + 0.5) / cells[1]
    turn, step = np.pi * u * u * (3 - 2 * u), 6 * np.pi * u * (1 - u) / cells[1]
    grid, turns = (axis.ravel() for axis in np.meshgrid(other, turn, indexing="ij"))
    solid_angle = (2 * np.sin(other) * np.cos(other) * (np.pi / 2 / cells[0]))[:, None] * step
    beyond = grid > farthest
    result = np.zeros((2, len(theta), len(fit.columns)))
    for number, angle in enumerate(theta):
        for pair in ((grid, angle), (angle, grid)):
            light = np.maximum(fit.evaluate(pair[0], 0, pair[1], turns), 0) * solid_angle.reshape(-1, 1)
            sums = np.stack([light.sum(axis=0), light[beyond].sum(axis=0)])
            result[:, number] = np.where(sums[0] > result[0, number], sums, result[:, number])
    return result


def _damping(total: FloatArray, beyond: FloatArray, farthest: float) -> FloatArray:
    """The control points of `LogRelative.damping`: (DAMPING_KNOTS, channels)."""
    within = farthest >= VIEWS
    # beyond the measurement: as much as brings the albedos within it to 1, if that alone can
    excess = np.maximum(total - (1 - _MARGIN), 0)[within]
    share = 1 - np.divide(excess, beyond[within], out=np.zeros_like(excess), where=excess > 0).clip(0, 1).max(axis=0)
    remaining = total - beyond * (1 - share)
    factor = np.minimum(1, (1 - _MARGIN) / np.maximum(remaining, 1e-9))
    factor[~within] = np.minimum(factor[~within], share)
    # a control point of the spline takes the least factor of the four intervals that it influences
    knots = unproject(np.linspace(0, 1, DAMPING_KNOTS))
    low = np.concatenate([[0, 0], knots[:-2]]) - np.radians(2)
    high = np.concatenate([knots[2:], [np.pi / 2] * 2]) + np.radians(2)
    return np.stack([factor[(first <= VIEWS) & (last >= VIEWS)].min(axis=0)
                     for first, last in zip(low, high, strict=True)])


def _description(fit: Fit, damped: Fit, before: FloatArray, farthest: float, samples: Samples) -> str:
    """Say what was changed."""
    worst = np.degrees(VIEWS[before.max(axis=1).argmax()])
    over = np.degrees(VIEWS[(before > 1 + TOLERANCE).any(axis=1)])
    kept, all_of_it = (float((np.cos(samples.theta_o)[:, None] * np.abs(each.evaluate(*samples.directions))).sum())
                       for each in (damped, fit))
    lost = 100 * (1 - kept / all_of_it) if all_of_it else 0.0
    where = f"from {over.min():.0f} degrees" if over.max() >= 89 else f"at {over.min():.0f} to {over.max():.0f} degrees"
    measured = f"measured up to {np.degrees(farthest):.0f} degrees"
    return (f"directional albedo {where} ({measured}), at most {before.max():.3g} at {worst:.0f} degrees, "
            f"lowered to 1; the measured directions lost {lost:.2g} % of their light")
