"""Conservation of energy: damps a fit at the polar angles at which it reflects more light than it receives, by a factor
a of at most 1 for each direction (`LogRelative.damping`), the same in all channels (docs/fitting.md, step 6).

The directional albedo, ``a(theta) integral f a cos``, is linear in the control points of the integrand's factor: the
light at each is all that has to be known of a fit. What the square roots of the excess leave is taken away at once by
the excess itself, which suffices because the factor grows nowhere. Angles that nobody measured do not give way first:
they would be dark.
"""

from dataclasses import replace

import numpy as np

from .. import progress
from ..arrays import FloatArray
from ..coordinates.half_difference import unproject
from ..model import Reflectance, is_isotropic
from ..model.fit import Fit
from ..model.transform import LogRelative, factor_of_angle
from ..samples import Samples, subsample
from ..shader_constants import DAMPING_KNOTS
from .lattices import MAX_STRATIFIED

OUTGOING_ANGLES = np.radians([*range(0, 80, 2), *range(80, 91)])
"""Polar angles at which the albedo is checked, radians."""
TOLERANCE = 2e-3            # by which an albedo may exceed 1
_FEW_POLAR_ANGLES = np.radians([*range(0, 75, 15), *range(75, 91, 3)])
_FAR_FROM_1 = 0.8           # a fit whose albedos at these few angles are lower is not looked at closer
# of the integral on either side of the angle, and of either half of the azimuths: of all, and of large albedos
_COARSE_CELLS, _FINE_CELLS = (32, 16), (64, 24)
_LIGHT_AZIMUTHS = tuple(np.radians(range(0, 360, 45)).tolist())  # at which an anisotropic fit is looked at
_LARGE_ALBEDO = 0.93        # an albedo that is integrated in finer steps
_MARGIN = 1e-3              # by which damped albedos stay below 1: for what the integral misses
_ROUNDS = 30                # by the square root, each of which halves the excess or better
_INFLUENCE = 2              # knots on both sides of a control point, which it has an influence on


def conserve_energy(fit: Fit, transform: LogRelative, samples: Samples) -> Fit:
    """Damp a fit of this transform where its directional albedo exceeds 1; `Fit.changes` says where, and by how much.
    The samples that were fitted tell how far the measurement reaches, and what it lost."""
    with progress.part(0.0, 0.15):
        few = reflected_light(fit, _FEW_POLAR_ANGLES, _COARSE_CELLS)
    if few.sum(axis=2).max() < _FAR_FROM_1:
        return fit
    with progress.part(0.15, 1.0):
        light = _reflected_at_angles(fit, few)
    total = light.sum(axis=2).max(axis=0)
    if total.max() <= 1 + TOLERANCE:
        return fit
    farthest = max(float(samples.theta_i.max()), float(samples.theta_o.max()))
    damped = replace(fit, transform=replace(transform, damping=_damping(light)))
    return replace(damped, changes=(_description(fit, damped, total, farthest, samples),))


def _reflected_at_angles(fit: Fit, few: FloatArray) -> FloatArray:
    """`reflected_light` at `OUTGOING_ANGLES`, given that at a few angles."""
    azimuths: tuple[float, ...] | None = None
    if not fit.isotropic:       # the brightest of them
        azimuths = tuple(_LIGHT_AZIMUTHS[way] for way in {*few.sum(axis=2).max(axis=2).argmax(axis=0)})
    with progress.part(0.0, 0.8):
        light = reflected_light(fit, OUTGOING_ANGLES, _COARSE_CELLS, azimuths)
    large = light.sum(axis=2).max(axis=(0, 2)) > _LARGE_ALBEDO
    if large.any():
        with progress.part(0.8, 1.0):
            light[:, large] = reflected_light(fit, OUTGOING_ANGLES[large], _FINE_CELLS, azimuths)
    return light


def reflected_light(model: Reflectance, theta: FloatArray, cells: tuple[int, int],
                    azimuths: tuple[float, ...] | None = None) -> FloatArray:
    """The light that leaves at an angle, and that arrives there, by the control points of the damping that it would
    have: (2, angles, DAMPING_KNOTS, channels), whose sum over the control points is the albedo; of an anisotropic fit,
    which is reciprocal, at each azimuth: (azimuths, angles, ...). By the midpoint rule, dense about the angle and about
    the plane of incidence: there are mirror and retro-reflection."""
    u, v = ((np.arange(count) + 0.5) / count for count in cells)
    turn, step = np.pi / 2 * np.concatenate([v ** 3, 2 - v ** 3]), np.tile(1.5 * np.pi * v * v / cells[1], 2)
    isotropic = is_isotropic(model)
    if isotropic:
        azimuths = 0.0,
    else:                       # and not symmetric about the plane of incidence
        turn, step = np.concatenate([turn, -turn]), np.tile(step / 2, 2)
        azimuths = azimuths or _LIGHT_AZIMUTHS
    light = []
    for number, angle in enumerate(theta):
        progress.report(number / len(theta))
        other = np.concatenate([angle - angle * u ** 3, angle + (np.pi / 2 - angle) * u ** 3])
        width = 3 * np.concatenate([angle * u * u, (np.pi / 2 - angle) * u * u]) / cells[0]
        solid_angle = (2 * np.sin(other) * np.cos(other) * width)[:, None] * step
        at_control_points = factor_of_angle(np.eye(DAMPING_KNOTS), other)
        values = [model.evaluate(other[:, None], azimuth + turn, angle, azimuth) for azimuth in azimuths]
        if isotropic:
            values.append(model.evaluate(angle, 0.0, other[:, None], turn))
        light.append([at_control_points.T @ np.einsum("itc,it->ic", np.maximum(value, 0), solid_angle)
                      for value in values])
    return np.stack(light, axis=1)


def _damping(light: FloatArray) -> FloatArray:
    """The control points of `LogRelative.damping`: (DAMPING_KNOTS, channels), in all channels the same."""
    knots = np.linspace(0, 1, DAMPING_KNOTS)
    most, reach = 1 - _MARGIN, _INFLUENCE / (DAMPING_KNOTS - 1)
    control_points = np.ones((DAMPING_KNOTS, 1))

    low, high = (unproject(np.clip(knots + side, 0, 1)) + np.sign(side) * np.radians(2) for side in (-reach, reach))
    influences = (low[:, None] <= OUTGOING_ANGLES) & (high[:, None] >= OUTGOING_ANGLES)
    for power in [0.5] * _ROUNDS + [1.0]:
        albedos = (factor_of_angle(control_points, OUTGOING_ANGLES)
                   * np.einsum("wvkc,k->wvc", light, control_points[:, 0])).max(axis=(0, 2))
        over = np.maximum(albedos / most, 1)
        control_points *= np.stack([over[at].max() for at in influences])[:, None] ** -power
    return np.repeat(control_points, light.shape[-1], axis=1)


def _description(fit: Fit, damped: Fit, before: FloatArray, farthest: float, samples: Samples) -> str:
    """Say what was changed."""
    worst = np.degrees(OUTGOING_ANGLES[before.max(axis=1).argmax()])
    over = np.degrees(OUTGOING_ANGLES[(before > 1 + TOLERANCE).any(axis=1)])
    at = subsample(samples, MAX_STRATIFIED).directions
    after, all_of_it = (float((np.cos(at[2])[:, None] * np.abs(each.evaluate(*at))).sum())
                        for each in (damped, fit))
    lost = 100 * (1 - after / all_of_it) if all_of_it else 0.0
    where = f"from {over.min():.0f} degrees" if over.max() >= 89 else f"at {over.min():.0f} to {over.max():.0f} degrees"
    measured = f"measured up to {np.degrees(farthest):.0f} degrees"
    return (f"directional albedo {where} ({measured}), at most {before.max():.3g} at {worst:.0f} degrees, "
            f"lowered to 1; the measured directions lost {lost:.2g} % of their light")
