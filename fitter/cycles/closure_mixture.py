"""The closure mixture: a sum of closures close to a fit, which Cycles can sample by itself, and the remainder.

For each tabulated outgoing angle, least squares approximate the reflected radiance T = f cos theta_i by

- a `diffuse_ramp` about the normal: a piecewise linear function of the cosine;
- two `phong_ramp`s about the direction in which the fit peaks: cos^e times a piecewise linear function of cos^e;
- a `microfacet` lobe (GGX, without a Fresnel factor), the only one that stretches as highlights do at grazing angles.

A material has one pair of exponents and one roughness. The value of a ramp closure is its weight times its colours.
Cycles picks a closure with a probability in proportion to its weight, while the colours may have any value and sign.
So the weights are chosen to bring the density with which Cycles samples the sum close to the sum itself, and the
colours follow. The microfacet lobe has a weight but no colours; its coefficient is not negative. `osl/mixture.h`
evaluates the same sum.
"""

from itertools import combinations, pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import (
    KNOTS,
    MICROFACET,
    RAMPS,
    REMAINDER_SHARE,
    REPLACING_PROBABILITY,
    ROW,
    SECTORS,
    STEEPEST_AXIS,
    TOTAL_WEIGHT,
    WEIGHTS,
)
from . import direction_grid

if TYPE_CHECKING:
    from ..model.fit import Fit

_EXPONENTS = (8, 20, 60, 200, 700)                      # candidates for the phong_ramps
_ROUGHNESS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6)      # candidates for the microfacet lobe
_SEARCHED = (5, 12, 18, 25)     # views at which the candidates are compared
_FLOOR = 0.1                    # relative errors count in full above this fraction of the mean reflected radiance
_ALBEDO_WEIGHT = 10             # weight of the equation that preserves the albedo
_RIDGE = 1e-4                   # ridge regression, so that lobes of opposite sign do not cancel each other
_ITERATIONS = 30                # of the weights, which then change by less than a percent
_LEAST_WEIGHT = 0.01            # minimum share of the weights, so that every lobe gets sampled
_SHARE_PER_ERROR = 2.0          # REMAINDER_SHARE per unit of the mixture's relative error
_SHARES = (0.05, 0.35)          # bounds of REMAINDER_SHARE
_BETWEEN_VIEWS = 0.05           # extra density for views between the tabulated ones, relative to the target


class Mixture(NamedTuple):
    """The mixture for every tabulated view.

    Attributes
    ----------
    table : (VIEWS, ROW, channels)
        Rows as `shader_constants` describes them. The knots of a ramp are divided by its weight.
    offset : (VIEWS,)
        Angle from the mirror direction to the axis of the phong_ramps, radians, positive toward the horizon.
    exponents : tuple of two
        Of the phong_ramps.
    roughness : float
        Of the microfacet lobe.
    remainder : (VIEWS, n)
        Magnitude of the remainder at the directions of the grid, summed over the channels: what sampled directions
        carry beside the mixture. It includes a little of the target, for views between the tabulated ones.
    reflected : (VIEWS, n)
        The same for directions that stand in for the mixture and carry all of the reflected radiance.
    error : float
        Of the mixture alone: the fraction of the reflected light that it puts in the wrong direction, mean over views.
    """

    table: NDArray[np.float64]
    offset: NDArray[np.float64]
    exponents: tuple[float, float]
    roughness: float
    remainder: NDArray[np.float64]
    reflected: NDArray[np.float64]
    error: float


def closure_mixture(fit: "Fit") -> Mixture:
    """The closure mixture of a fit.

    Parameters
    ----------
    fit : Fit
        Only its `evaluate` is used.

    Returns
    -------
    Mixture
    """
    to = direction_grid.grid()
    theta_o = direction_grid.views()
    value = fit.evaluate(to.theta[None], to.phi[None], theta_o[:, None], np.zeros((1, 1)))
    target = np.maximum(value, 0).reshape(len(theta_o), len(to.theta), -1) * np.cos(to.theta)[:, None]
    offset = _peaks(target, to) - theta_o
    exponents, roughness = _choose(target, theta_o, offset, to)

    table = np.zeros((len(theta_o), ROW, target.shape[-1]))
    remainder, reflected = np.empty((2, *target.shape[:2]))
    for view, angle in enumerate(theta_o):
        lobes = _lobes(angle, offset[view], exponents, roughness, to.unit)
        coefficients = _solve(lobes, target[view], to.solid_angle)
        difference = target[view] - np.hstack(lobes) @ coefficients
        remainder[view] = np.abs(difference).sum(axis=1)
        reflected[view] = np.abs(target[view] + (1 / REPLACING_PROBABILITY - 1) * difference).sum(axis=1)
        density = _densities(angle, offset[view], exponents, roughness, to.unit)
        table[view] = _row(lobes, density, coefficients, target[view], to.solid_angle)
    nearby = np.pad(target.sum(axis=2), ((1, 1), (0, 0)), mode="edge")
    nearby = np.maximum(np.maximum(nearby[:-2], nearby[1:-1]), nearby[2:])
    misplaced = remainder @ to.solid_angle
    light = target.sum(axis=2) @ to.solid_angle
    error = float(np.divide(misplaced, light, out=np.zeros_like(misplaced), where=light > 0).mean())
    return Mixture(table, offset, exponents, roughness, remainder + _BETWEEN_VIEWS * nearby,
                   reflected + _BETWEEN_VIEWS * nearby, error)


def evaluate(mixture: Mixture, view: int, theta_o: float, wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The reflected radiance of the mixture of a tabulated view, seen from an angle near it.

    Parameters
    ----------
    mixture : Mixture
    view : int
        The tabulated view.
    theta_o : float
        The outgoing angle, radians.
    wi : (n, 3)
        Unit vectors above the horizon, in the frame where the outgoing direction has azimuth 0.

    Returns
    -------
    (n, channels)
    """
    row = mixture.table[view]
    weights = np.repeat(row[WEIGHTS:MICROFACET], KNOTS, axis=0)
    coefficients = np.concatenate([row[:WEIGHTS] * weights, row[MICROFACET:TOTAL_WEIGHT]])
    return np.hstack(_lobes(theta_o, mixture.offset[view], mixture.exponents, mixture.roughness, wi)) @ coefficients


def _peaks(target: NDArray[np.float64], to: direction_grid.Directions) -> NDArray[np.float64]:
    """The angle from the normal, on the mirror side, at which each view's reflected radiance is largest: (VIEWS,)."""
    sectors = SECTORS * direction_grid.SUBSAMPLES
    total = target.sum(axis=2).reshape(len(target), -1, sectors)[:, :, :6].mean(axis=2)
    ring = total.argmax(axis=1)
    peak = to.theta.reshape(-1, sectors)[ring, 0]
    smooth = np.convolve(np.pad(peak, 2, mode="edge"), np.ones(5) / 5, mode="valid")     # peak jumps from ring to ring
    return np.minimum(smooth, STEEPEST_AXIS)


def _choose(target: NDArray[np.float64], theta_o: NDArray[np.float64], offset: NDArray[np.float64],
            to: direction_grid.Directions) -> tuple[tuple[float, float], float]:
    """Exponents and roughness with the least error at a few views, by searching one after the other."""
    def error(exponents: tuple[float, float], roughness: float) -> float:
        total = 0
        for view in _SEARCHED:
            lobes = _lobes(theta_o[view], offset[view], exponents, roughness, to.unit)
            difference = np.abs(target[view] - np.hstack(lobes) @ _solve(lobes, target[view], to.solid_angle))
            total += (difference.sum(axis=1) @ to.solid_angle) / max(target[view].sum(axis=1) @ to.solid_angle, 1e-12)
        return total

    exponents = (8, 200)
    roughness = min(_ROUGHNESS, key=lambda alpha: error(exponents, alpha))
    exponents = min(combinations(_EXPONENTS, 2), key=lambda pair: error(pair, roughness))
    return exponents, min(_ROUGHNESS, key=lambda alpha: error(exponents, alpha))


def _lobes(theta_o: float, offset: float, exponents: tuple[float, float], roughness: float,
           wi: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """The basis functions of each lobe at each direction: a list of (n, KNOTS) for ramps, (n, 1) for the last."""
    wo, axis, half = _frame(theta_o, offset)
    hat = _hats(wi[:, 2])
    hat[:, 0] = 0                   # Cycles evaluates the ramp below the horizon too, where it must be black
    lobes = [hat / np.pi]
    for exponent in exponents:
        falloff = np.maximum(wi @ axis, 0) ** exponent
        height = np.maximum(wi @ half, 0) * (exponent + 2) / (2 * np.pi) * falloff
        lobes.append(height[:, None] * _hats(falloff))
    return [*lobes, _ggx(wo, wi, roughness)[:, None]]


def _densities(theta_o: float, offset: float, exponents: tuple[float, float], roughness: float,
               wi: NDArray[np.float64]) -> NDArray[np.float64]:
    """The density per solid angle with which Cycles samples each lobe: (RAMPS + 1, n)."""
    wo, axis, _ = _frame(theta_o, offset)
    phong = [(exponent + 1) / (2 * np.pi) * np.maximum(wi @ axis, 0) ** exponent for exponent in exponents]
    # Cycles samples the microfacets that are visible from wo
    visible = _trowbridge_reitz(wo, wi, roughness) / (4 * wo[2] * (1 + _smith(wo[2], roughness)))
    return np.stack([wi[:, 2] / np.pi, *phong, visible])


def _frame(theta_o: float, offset: float) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """The outgoing direction, the axis of the phong_ramps, and their half vector: (3,) each."""
    wo = _in_plane(theta_o)
    axis = _in_plane(-min(theta_o + offset, STEEPEST_AXIS))
    return wo, axis, (wo + axis) / np.linalg.norm(wo + axis)


def _in_plane(theta: float) -> NDArray[np.float64]:
    """A direction in the plane of incidence, on the viewer's side where theta is positive."""
    return np.array([np.sin(theta), 0, np.cos(theta)])


def _hats(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Piecewise linear basis on KNOTS knots over [0, 1]: (n,) to (n, KNOTS)."""
    return np.maximum(0, 1 - np.abs(np.clip(x, 0, 1)[:, None] * (KNOTS - 1) - np.arange(KNOTS)))


def _ggx(wo: NDArray[np.float64], wi: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
    """GGX reflection with height-correlated masking and no Fresnel factor, times cos theta_i (Walter et al. 2007;
    Heitz 2014): (n,)."""
    return _trowbridge_reitz(wo, wi, alpha) / (4 * wo[2] * (1 + _smith(wo[2], alpha) + _smith(wi[:, 2], alpha)))


def _trowbridge_reitz(wo: NDArray[np.float64], wi: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
    """The distribution of the microfacets at the half vector: (n,)."""
    half = wi + wo
    cosine = half[:, 2] / np.linalg.norm(half, axis=1)
    return alpha**2 / (np.pi * (cosine**2 * (alpha**2 - 1) + 1) ** 2)


def _smith(z: NDArray[np.float64], alpha: float) -> NDArray[np.float64]:
    """Smith's Lambda, from the cosine z of a direction."""
    return (np.sqrt(1 + alpha**2 * (1 / z**2 - 1)) - 1) / 2


def _solve(lobes: list[NDArray[np.float64]], target: NDArray[np.float64],
           solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of the basis functions: (columns, channels).

    Least squares of errors relative to the target, with a heavy equation that preserves the albedo. The coefficient of
    the microfacet lobe is not negative.
    """
    basis = np.hstack(lobes)
    bounded = np.concatenate([np.full(lobe.shape[1], lobe.shape[1] == 1) for lobe in lobes])
    mean = target.mean(axis=1)
    weight = solid_angle / (mean + _FLOOR * np.average(mean, weights=solid_angle) + 1e-12)
    normal = basis.T @ (weight[:, None] * basis)
    right = basis.T @ (weight[:, None] * target)
    albedo = solid_angle @ basis
    albedo_weight = _ALBEDO_WEIGHT / (solid_angle @ mean + 1e-12)
    normal += albedo_weight * albedo[:, None] * albedo
    right += albedo_weight * albedo[:, None] * (solid_angle @ target)
    scale = np.sqrt(normal.diagonal()) + 1e-12
    normal, right = normal / scale / scale[:, None], right / scale[:, None]
    normal[np.diag_indices(len(normal))] += _RIDGE

    result = np.zeros_like(right)
    for channel in range(right.shape[1]):
        used = np.ones(len(normal), dtype=bool)
        while True:
            found = np.linalg.solve(normal[np.ix_(used, used)], right[used, channel])
            result[used, channel] = found
            below = bounded & (result[:, channel] < 0)
            if not below.any():
                break
            used &= ~below
            result[below, channel] = 0
    return result / scale[:, None]


def _row(lobes: list[NDArray[np.float64]], density: NDArray[np.float64], coefficients: NDArray[np.float64],
         target: NDArray[np.float64], solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """A row of the table: (ROW, channels)."""
    columns = np.cumsum([0] + [lobe.shape[1] for lobe in lobes])
    parts = [coefficients[start:stop] for start, stop in pairwise(columns)]
    mixture = np.hstack(lobes) @ coefficients
    shares = _shares(mixture, density, solid_angle)
    albedo = solid_angle @ target
    microfacet = parts[RAMPS][0]
    # The coefficient of the microfacet lobe is its weight. The other weights follow from the best shares, as long as
    # their sum stays close to the albedo, for which Cycles takes it in the passes that guide its denoiser.
    total = albedo.mean()
    if microfacet.mean() > _LEAST_WEIGHT * total:
        total = np.clip(microfacet.mean() / shares[RAMPS], 0.6 * total, 1.6 * total)
    total = max(total, microfacet.mean() * 1.05, 1e-3)
    means = shares[:RAMPS] / shares[:RAMPS].sum() * (total - microfacet.mean())
    weights = means[:, None] * _colours(np.array([solid_angle @ np.abs(lobe @ part) for lobe, part
                                                  in zip(lobes[:RAMPS], parts[:RAMPS], strict=True)]))
    error = (solid_angle @ np.abs(target - mixture)).sum() / max(albedo.sum(), 1e-12)
    row = np.empty((ROW, target.shape[1]))
    row[:WEIGHTS] = np.concatenate([part / weight for part, weight in zip(parts[:RAMPS], weights, strict=True)])
    row[WEIGHTS:MICROFACET] = weights
    row[MICROFACET] = microfacet
    row[TOTAL_WEIGHT] = total
    row[REMAINDER_SHARE] = np.clip(_SHARE_PER_ERROR * error, *_SHARES)
    return row


def _shares(mixture: NDArray[np.float64], density: NDArray[np.float64],
            solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The best probability of picking each lobe: (RAMPS + 1,), of sum 1.

    It minimises the second moment of the estimate under an even light, the integral of M^2 / sum_k s_k p_k, by a
    fixed-point iteration that keeps the shares positive.
    """
    squared = (mixture**2).mean(axis=1) * solid_angle
    shares = np.full(len(density), 1 / len(density))
    for _ in range(_ITERATIONS):
        shares = shares * np.sqrt(density @ (squared / np.maximum(shares @ density, 1e-9) ** 2))
        shares = np.maximum(shares / max(shares.sum(), 1e-12), _LEAST_WEIGHT)
    return shares / shares.sum()


def _colours(reflected: NDArray[np.float64]) -> NDArray[np.float64]:
    """What each lobe reflects, (lobes, channels), scaled to colours of mean 1.

    Every channel gets a minimum: with a weight of 0 it would be lost.
    """
    reflected = np.maximum(reflected, 0.02 * reflected.max(axis=1, keepdims=True)) + 1e-9
    return reflected / reflected.mean(axis=1, keepdims=True)
