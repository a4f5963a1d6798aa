"""A fit as a sum of closures that Cycles can sample by itself, and what that sum leaves.

For each tabulated outgoing angle the reflected radiance T = f cos theta_i is approximated, least squares, by

- a `diffuse_ramp` about the normal: a piecewise linear function of the cosine;
- two `phong_ramp` about the direction in which the fit peaks: cos^e times a piecewise linear function of cos^e;
- a `microfacet` lobe (GGX, without a Fresnel factor), which alone is stretched as highlights are at grazing angles.

Exponents and roughness are chosen for the material as a whole. Ramps may have any sign: a closure's weight decides how
often Cycles picks it, its colours what it is worth. So the weights are free to make the density with which Cycles
samples the sum as near to it as they can. The microfacet lobe has nothing but its weight, and it is not negative.
`osl/mixture.h` evaluates the same sum.
"""

from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from . import direction_grid

KNOTS = 8                           # of a ramp, fixed by Cycles
RAMPS = 3
WEIGHTS = RAMPS * KNOTS             # in a row of the table: where the ramps' weights begin
MICROFACET = WEIGHTS + RAMPS        # the microfacet lobe's weight
DRAWN = MICROFACET + 1              # the sum of the weights, which the drawn direction's is measured by
SHARE = DRAWN + 1                   # how often a direction is to be drawn
ROW = SHARE + 1

REPLACED = 0.5                      # where light is even, drawn directions stand for the mixture this often

_EXPONENTS = (8, 20, 60, 200, 700)
_ROUGHNESS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6)
_SEARCHED = (5, 12, 18, 25)         # the views at which exponents and roughnesses are compared
_FLOOR = 0.1                        # of the mean reflected radiance: errors below it count no more than there
_ALBEDO_WEIGHT = 10
_RIDGE = 1e-4                       # keeps lobes from cancelling each other
_ITERATIONS = 30                    # of the weights: they change by less than a percent then
_LEAST_WEIGHT = 0.01                # of all weights: a closure is worth something where no other is
_DRAWN_SHARE = 2.0                  # a direction is drawn this often for what it carries
_SHARES = (0.05, 0.35)
_CAUTION = 0.05                     # drawn besides what is left at the tabulated views, since others lie between them
_STEEPEST = np.radians(86)          # for an axis


class Mixture(NamedTuple):
    """A mixture for every tabulated view.

    Attributes
    ----------
    table : (VIEWS, ROW, channels)
        The ramps' knots divided by their weight, the weights of the ramps and of the microfacet lobe, their sum, and
        how often a direction is to be drawn.
    offset : (VIEWS,)
        How far the Phong lobes' axis leans from the mirror direction toward the horizon, radians.
    exponents : tuple of two float
    roughness : float
    rest, reflected : (VIEWS, n)
        What drawing is to follow, at the directions of the grid and summed over the channels: the magnitude of what the
        mixture leaves, and of that on top of all that is reflected, both with a little of the target.
    error : float
        Of the mixture alone: the share of the reflected light that is in the wrong direction, in the mean over views.
    """

    table: np.ndarray
    offset: np.ndarray
    exponents: tuple
    roughness: float
    rest: np.ndarray
    reflected: np.ndarray
    error: float


def closure_mixture(fit):
    """The mixture of a `Fit`."""
    to = direction_grid.grid()
    theta_o = direction_grid.views()
    value = fit.evaluate(to.theta[None], to.phi[None], theta_o[:, None], np.zeros((1, 1)))
    target = np.maximum(value, 0).reshape(len(theta_o), len(to.theta), -1) * np.cos(to.theta)[:, None]
    offset = _peaks(target, to) - theta_o
    exponents, roughness = _choose(target, theta_o, offset, to)

    table = np.zeros((len(theta_o), ROW, target.shape[-1]))
    rest, reflected = np.empty((2, *target.shape[:2]))
    for view, angle in enumerate(theta_o):
        lobes = _lobes(angle, offset[view], exponents, roughness, to.unit)
        coefficients = _solve(lobes, target[view], to.solid_angle)
        left = target[view] - np.hstack(lobes) @ coefficients
        rest[view] = np.abs(left).sum(axis=1)
        reflected[view] = np.abs(target[view] + (1 / REPLACED - 1) * left).sum(axis=1)
        density = _densities(angle, offset[view], exponents, roughness, to.unit)
        table[view] = _row(lobes, density, coefficients, target[view], to.solid_angle)
    near = np.pad(target.sum(axis=2), ((1, 1), (0, 0)), mode="edge")
    near = np.maximum(np.maximum(near[:-2], near[1:-1]), near[2:])
    wrong = rest @ to.solid_angle
    light = target.sum(axis=2) @ to.solid_angle
    error = float(np.divide(wrong, light, out=np.zeros_like(wrong), where=light > 0).mean())
    return Mixture(table, offset, exponents, roughness, rest + _CAUTION * near, reflected + _CAUTION * near, error)


def evaluate(mixture, view, theta_o, wi):
    """The mixture of a tabulated view, seen from theta_o beside it: the reflected radiance at unit vectors wi.

    Parameters
    ----------
    mixture : Mixture
    view : int
    theta_o : float
        Radians.
    wi : (n, 3)
        Above the horizon, in the frame where the outgoing direction has azimuth 0.

    Returns
    -------
    (n, channels)
    """
    row = mixture.table[view]
    weights = np.repeat(row[WEIGHTS:MICROFACET], KNOTS, axis=0)
    coefficients = np.concatenate([row[:WEIGHTS] * weights, row[MICROFACET:DRAWN]])
    return np.hstack(_lobes(theta_o, mixture.offset[view], mixture.exponents, mixture.roughness, wi)) @ coefficients


def _peaks(target, to):
    """The polar angle on the mirror side at which each view's reflected radiance is largest: (VIEWS,)."""
    sectors = direction_grid.SECTORS * direction_grid.SUBSAMPLES
    total = target.sum(axis=2).reshape(len(target), -1, sectors)[:, :, :6].mean(axis=2)
    ring = total.argmax(axis=1)
    peak = to.theta.reshape(-1, sectors)[ring, 0]
    smooth = np.convolve(np.pad(peak, 2, mode="edge"), np.ones(5) / 5, mode="valid")     # the argmax jumps about
    return np.minimum(smooth, _STEEPEST)


def _choose(target, theta_o, offset, to):
    """Exponents and roughness that leave least at a few views, the one after the other."""
    def left(exponents, roughness):
        total = 0
        for view in _SEARCHED:
            lobes = _lobes(theta_o[view], offset[view], exponents, roughness, to.unit)
            wrong = np.abs(target[view] - np.hstack(lobes) @ _solve(lobes, target[view], to.solid_angle))
            total += (wrong.sum(axis=1) @ to.solid_angle) / max(target[view].sum(axis=1) @ to.solid_angle, 1e-12)
        return total

    exponents = (8, 200)
    roughness = min(_ROUGHNESS, key=lambda alpha: left(exponents, alpha))
    exponents = min(combinations(_EXPONENTS, 2), key=lambda pair: left(pair, roughness))
    return exponents, min(_ROUGHNESS, key=lambda alpha: left(exponents, alpha))


def _lobes(theta_o, offset, exponents, roughness, wi):
    """The value of every coefficient's part at every direction: a list of (n, KNOTS) and (n, 1), one for a lobe."""
    wo, axis, half = _frame(theta_o, offset)
    hat = _hats(wi[:, 2])
    hat[:, 0] = 0                   # or the ramp would glow behind its horizon
    lobes = [hat / np.pi]
    for exponent in exponents:
        fall = np.maximum(wi @ axis, 0) ** exponent
        height = np.maximum(wi @ half, 0) * (exponent + 2) / (2 * np.pi) * fall
        lobes.append(height[:, None] * _hats(fall))
    return [*lobes, _ggx(wo, wi, roughness)[:, None]]


def _densities(theta_o, offset, exponents, roughness, wi):
    """The density per solid angle with which Cycles samples each lobe: (RAMPS + 1, n)."""
    wo, axis, _ = _frame(theta_o, offset)
    phong = [(exponent + 1) / (2 * np.pi) * np.maximum(wi @ axis, 0) ** exponent for exponent in exponents]
    # of the microfacets that are seen from wo
    visible = _trowbridge_reitz(wo, wi, roughness) / (4 * wo[2] * (1 + _smith(wo[2], roughness)))
    return np.stack([wi[:, 2] / np.pi, *phong, visible])


def _frame(theta_o, offset):
    """The outgoing direction, the axis of the Phong lobes, and half way between them."""
    wo = _in_plane(theta_o)
    axis = _in_plane(-min(theta_o + offset, _STEEPEST))
    return wo, axis, (wo + axis) / np.linalg.norm(wo + axis)


def _in_plane(theta):
    return np.array([np.sin(theta), 0, np.cos(theta)])


def _hats(x):
    """Piecewise linear basis on KNOTS knots over [0, 1]: (n, KNOTS)."""
    return np.maximum(0, 1 - np.abs(np.clip(x, 0, 1)[:, None] * (KNOTS - 1) - np.arange(KNOTS)))


def _ggx(wo, wi, alpha):
    """GGX reflection with height-correlated masking and no Fresnel factor, times cos theta_i (Walter et al. 2007;
    Heitz 2014): (n,)."""
    return _trowbridge_reitz(wo, wi, alpha) / (4 * wo[2] * (1 + _smith(wo[2], alpha) + _smith(wi[:, 2], alpha)))


def _trowbridge_reitz(wo, wi, alpha):
    half = wi + wo
    cosine = half[:, 2] / np.linalg.norm(half, axis=1)
    return alpha**2 / (np.pi * (cosine**2 * (alpha**2 - 1) + 1) ** 2)


def _smith(z, alpha):
    return (np.sqrt(1 + alpha**2 * (1 / z**2 - 1)) - 1) / 2


def _solve(lobes, target, solid_angle):
    """Least squares, relative to the target above a floor, and above all of the albedo; microfacet coefficients not
    below 0: (columns, channels)."""
    basis = np.hstack(lobes)
    bounded = np.concatenate([np.full(lobe.shape[1], lobe.shape[1] == 1) for lobe in lobes])
    mean = target.mean(axis=1)
    weight = solid_angle / (mean + _FLOOR * np.average(mean, weights=solid_angle) + 1e-12)
    normal = basis.T @ (weight[:, None] * basis)
    right = basis.T @ (weight[:, None] * target)
    albedo = solid_angle @ basis
    exactly = _ALBEDO_WEIGHT / (solid_angle @ mean + 1e-12)
    normal += exactly * albedo[:, None] * albedo
    right += exactly * albedo[:, None] * (solid_angle @ target)
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


def _row(lobes, density, coefficients, target, solid_angle):
    """A row of the table: (ROW, channels)."""
    columns = np.cumsum([0] + [lobe.shape[1] for lobe in lobes])
    parts = [coefficients[start:stop] for start, stop in pairwise(columns)]
    mixture = np.hstack(lobes) @ coefficients
    shares = _shares(mixture, density, solid_angle)
    albedo = solid_angle @ target
    microfacet = parts[RAMPS][0]
    # the microfacet lobe's weight is given; the others' follow, as far as their sum stays near the albedo, which
    # Cycles' denoising passes take it for
    total = albedo.mean()
    if microfacet.mean() > _LEAST_WEIGHT * total:
        total = np.clip(microfacet.mean() / shares[RAMPS], 0.6 * total, 1.6 * total)
    total = max(total, microfacet.mean() * 1.05, 1e-3)
    means = shares[:RAMPS] / shares[:RAMPS].sum() * (total - microfacet.mean())
    weights = means[:, None] * _colours(np.array([solid_angle @ np.abs(lobe @ part) for lobe, part
                                                  in zip(lobes[:RAMPS], parts[:RAMPS], strict=True)]))
    left = (solid_angle @ np.abs(target - mixture)).sum() / max(albedo.sum(), 1e-12)
    row = np.empty((ROW, target.shape[1]))
    row[:WEIGHTS] = np.concatenate([part / weight for part, weight in zip(parts[:RAMPS], weights, strict=True)])
    row[WEIGHTS:MICROFACET] = weights
    row[MICROFACET] = microfacet
    row[DRAWN] = total
    row[SHARE] = np.clip(_DRAWN_SHARE * left, *_SHARES)
    return row


def _shares(mixture, density, solid_angle):
    """How often each lobe is best picked: (RAMPS + 1,), of sum 1.

    The least of the mixture's second moment under an even light, integral of M^2 / sum_k s_k p_k, by a fixed-point
    iteration that keeps the shares positive.
    """
    squared = (mixture**2).mean(axis=1) * solid_angle
    shares = np.full(len(density), 1 / len(density))
    for _ in range(_ITERATIONS):
        shares = shares * np.sqrt(density @ (squared / np.maximum(shares @ density, 1e-9) ** 2))
        shares = np.maximum(shares / max(shares.sum(), 1e-12), _LEAST_WEIGHT)
    return shares / shares.sum()


def _colours(reflected):
    """What a lobe reflects, (lobes, channels), as colours of mean 1: every channel has some, since a weight of 0 would
    lose the channel."""
    reflected = np.maximum(reflected, 0.02 * reflected.max(axis=1, keepdims=True)) + 1e-9
    return reflected / reflected.mean(axis=1, keepdims=True)
