"""Weights of materials and a normal at each texel of a flat sample, from what it shows under several lamps.

The radiance is linear in the weights w, which are not negative, and not in the slopes s of the normal
n ~ s_1 t + s_2 b + n_0. For given slopes the weights are least squares; the slopes descend by damped Gauss-Newton
with the weights projected out (G. Golub, V. Pereyra: The Differentiation of Pseudo-Inverses and Nonlinear Least Squares
Problems Whose Variables Separate, SIAM Journal on Numerical Analysis 10(2), 1973).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, Directions, FloatArray, IntArray
from ...least_squares import nonnegative_least_squares
from ...model import Reflectance
from ...model.microfacet import Microfacet
from ..rig.photograph import STEEPEST, to_local_angles
from .photograph import Observed, ShadingGeometry

NOISE = 0.01                # of a value: what photographs are out by beside their noise, as lamps flicker
STEEP = 0.5                 # slope that is expected of a normal, where nothing tells: 27 degrees
DIFFERENCE = 2e-3          # of slopes, .1 degrees: less than lobes are wide
_TRIED, _DESCENDED = 4, 12  # steps from each start, and from the best
_STILL = 2e-4               # slope, .01 degrees: a step at which it ends
_CURVED = 0.02              # slope, 1.1 degrees, from where derivatives were worked out to where they are used
_SHADOWS = 2                # times that shadows are looked for
_DOUBTFUL = 4.0             # squared error of a value in units of its variance, and of the median over texels
_DARK = 0.1                 # of the median reflectance over the lamps: less is a shadow, until a model says better
_MISSING = 0.3              # of what a model expects: where so much is missing, and 5 deviations, is a shadow
_DEVIATIONS = 5.0
_FEWEST = 3                 # photographs of a texel that shadows may leave
_RIDGE = 1e-9               # of materials that are one
_LEAST_SPREAD = 0.1         # of a weight, by which those of texels differ
_POOR = 4.0                 # variance that a poor model leaves, in units of the noise's


class Texels(NamedTuple):
    """What is found of n texels."""

    weights: FloatArray     # (n, materials)
    deviation: FloatArray   # their standard deviation
    slopes: FloatArray      # (n, 2)
    precision: FloatArray   # the inverse of their covariance: (n, 2, 2)
    used: BoolArray         # the photographs that count: (n, p)
    misfit: FloatArray      # the squared error of a value, in units of its variance: (n,)
    response: FloatArray    # by how much the weights change with the slopes: (n, materials, 2)

    def part(self, which: slice | IntArray) -> "Texels":
        """Some of them."""
        return Texels(self.weights[which], self.deviation[which], self.slopes[which], self.precision[which],
                      self.used[which], self.misfit[which], self.response[which])


class Prior(NamedTuple):
    """What is expected of every texel's weights before its own photographs tell, by empirical Bayes."""

    mean: FloatArray        # (materials,)
    precision: FloatArray   # the inverse of their variance, in units of that of the values: (materials,)
    misfit: float     # the variance of values, in units of that which their noise has: 1, or what the model leaves

    @property
    def is_poor(self) -> bool:
        """Whether the model leaves so much that texels help one another, errors are no smaller in the dark, and a
        shadow looks like any other."""
        return self.misfit > _POOR

    @property
    def rows(self) -> tuple[FloatArray, FloatArray]:
        """The same as values that are measured beside the others: (materials, materials) and (materials,)."""
        root = np.sqrt(self.precision)
        return np.diag(root), root * self.mean


def no_prior(materials: int) -> Prior:
    """That of texels of which nothing is known before."""
    return Prior(np.zeros(materials), np.zeros(materials), 1.0)


def estimate_prior(found: Texels) -> Prior:
    """The prior that texels, which were solved without one, make probable."""
    known = found.used.any(axis=1)
    if not found.weights[known].any():
        return no_prior(found.weights.shape[1])
    misfit = max(float(np.median(found.misfit[known])), 1.0)
    weights = found.weights[known]
    low, mean, high = np.quantile(weights, [0.16, 0.5, 0.84], axis=0)
    # a spread of nothing would hold all texels at the median
    least = _LEAST_SPREAD * np.maximum(np.maximum(mean, weights.mean(axis=0)), _LEAST_SPREAD ** 3 * weights.max())
    spread = np.maximum((high - low) / 2, least)
    return Prior(mean, misfit / spread ** 2 * (misfit > _POOR), misfit)


def slopes_to_normals(slopes: FloatArray, frame: FloatArray) -> FloatArray:
    """Unit normals (..., 3) of slopes (..., 2) along the first two rows of a frame (3, 3); its last is the plane's."""
    steep = slopes @ frame[:2] + frame[2]
    return np.asarray(steep / np.linalg.norm(steep, axis=-1, keepdims=True))


def normals_to_slopes(normals: FloatArray, frame: FloatArray, most: float) -> FloatArray:
    """The inverse of `slopes_to_normals`; of 0 where the slope is more than this."""
    along = normals @ frame.T
    slopes = along[..., :2] / np.maximum(along[..., 2:], 1e-9)
    return np.where(np.linalg.norm(slopes, axis=-1, keepdims=True) < most, slopes, 0.0)


def radiances(fits: Sequence[Reflectance], lit: ShadingGeometry, normals: FloatArray,
              good: BoolArray | None = None) -> FloatArray:
    """What points with normals (n, 3) send to the cameras, of each material with the weight 1: (n, p, channels,
    materials); it is worked out where it is good, (n, p), and elsewhere 0."""
    good = np.ones(lit.light.shape[:2], bool) if good is None else good
    normal = np.broadcast_to(normals[:, None], lit.light.shape)[good]
    directions = to_local_angles(normal, lit.light[good], lit.view[good])
    brought = np.maximum(np.cos(directions[0]), 0)[:, None] * lit.brought[good]
    found = np.zeros((*lit.brought.shape, len(fits)))
    found[good] = _reflectances(fits, directions) * brought[..., None]
    return found


def _reflectances(fits: Sequence[Reflectance], directions: Directions) -> FloatArray:
    """Of each material, (n, channels, materials), 1/sr. Models of the same lobes are evaluated as one with more
    channels."""
    first, *others = fits
    if isinstance(first, Microfacet) and all(isinstance(each, Microfacet) and each.alpha is first.alpha
                                             for each in others):
        models = [each for each in fits if isinstance(each, Microfacet)]
        joint = replace(first, kd=np.concatenate([each.kd for each in models]),
                        ks=np.concatenate([each.ks for each in models], axis=1))
        return np.swapaxes(joint.evaluate(*directions).reshape(-1, len(models), len(first.kd)), 1, 2)
    return np.stack(np.broadcast_arrays(*(fit.evaluate(*directions) for fit in fits)), axis=-1)


def solve_texels(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, first: FloatArray | None = None,
                 prior: Prior | None = None) -> Texels:
    """The weights, with a prior, and slopes of n texels.

    It begins with the first slopes, (n, 2), where they lead to what is seen: else, and by default, with flat ones,
    those of a Lambertian, and those that mirror the brightest lamp.
    """
    prior = no_prior(len(fits)) if prior is None else prior
    if first is None:
        return _solve(fits, seen, frame, _find_start(fits, seen, frame, prior), prior)
    found = _solve(fits, seen, frame, first, prior)
    known = found.used.any(axis=1)
    if not known.any():
        return found
    off = np.flatnonzero(known & (found.misfit > np.maximum(_DOUBTFUL, _DOUBTFUL * np.median(found.misfit[known]))))
    if len(off):
        part = seen.some(off)
        again = _solve(fits, part, frame, _find_start(fits, part, frame, prior), prior)
        better = again.misfit < found.misfit[off]
        for old, new in zip(found, again, strict=True):
            old[off[better]] = new[better]
    return found


def _find_start(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, prior: Prior) -> FloatArray:
    """The slopes to which the best of several starts leads: (n, 2)."""
    used = seen.good & ~_dark(seen, frame, prior)
    scale = expected_deviation(seen, seen.radiance, used, prior=prior)
    starts = [np.zeros((len(used), 2)), *guess_slopes(seen, used, frame)]
    best, lowest = starts[0], np.full(len(used), np.inf)
    for start in starts:
        found, cost = _descend(fits, seen, used, scale, frame, start, _TRIED, prior)[:2]
        better = cost < lowest
        best, lowest = np.where(better[:, None], found, best), np.where(better, cost, lowest)
    return best


def _solve(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, slopes: FloatArray, prior: Prior) -> Texels:
    """The same from slopes to begin with, (n, 2). What is in a shadow is found by the model, until that changes no
    more."""
    used = seen.good & ~_dark(seen, frame, prior)
    scale = expected_deviation(seen, seen.radiance, used, prior=prior)
    found: Texels | None = None
    going, known, unit = np.arange(len(used)), np.zeros_like(used), np.zeros(())
    for _ in range(_SHADOWS):
        part, start = seen.some(going), slopes[going]
        normal = slopes_to_normals(start, frame)
        unit = unit + radiances(fits, part.lit, normal, part.good & ~known)
        expected = np.einsum("npcm,nm->npc", unit, _weights(unit, part, used[going], scale[going], prior))
        scale[going] = expected_deviation(part, expected, used[going], prior=prior)
        missing = (expected - part.radiance).mean(axis=2)
        shadow = (missing > _MISSING * expected.mean(axis=2)) & (
            missing > _DEVIATIONS * np.sqrt(prior.misfit * (scale[going] ** 2).mean(axis=2) / scale.shape[2]))
        upright = np.minimum(*(np.einsum("npk,nk->np", toward, normal) for toward in part.lit[:2])) > np.cos(STEEPEST)
        trusted = part.good & ~shadow & upright
        trusted = np.where((trusted.sum(axis=1) >= _FEWEST)[:, None], trusted, used[going])
        if found is not None:
            changed = (trusted != used[going]).any(axis=1)
            going, trusted, unit = going[changed], trusted[changed], unit[changed]
        if not len(going):
            break
        used[going] = trusted
        part = seen.some(going)
        descent = _descend(fits, part, trusted, scale[going], frame, slopes[going], _DESCENDED, prior, unit)
        slopes = slopes.copy()
        slopes[going] = descent.slopes
        seen_of = descent.unit[:, :-len(fits)]
        known, unit = trusted, seen_of.reshape(unit.shape) * scale[going][..., None]
        now = _judge(part, trusted, scale[going], descent, prior)
        if found is None:
            found = now
        else:
            for old, new in zip(found, now, strict=True):
                old[going] = new
    assert found is not None
    return found


def turned_weights(found: Texels, slopes: FloatArray) -> tuple[FloatArray, IntArray]:
    """The weights, (n, materials), of texels whose slopes become these, (n, 2), by their derivative; and the numbers of
    those that turn too far for it: `given_normals` has their weights."""
    turned = slopes - found.slopes
    weights = np.maximum(found.weights + np.einsum("nmk,nk->nm", found.response, turned), 0)
    return weights, np.flatnonzero(np.linalg.norm(turned, axis=1) > _CURVED)


def given_normals(fits: Sequence[Reflectance], seen: Observed, frame: FloatArray, found: Texels,
                  slopes: FloatArray, prior: Prior) -> FloatArray:
    """The weights, (n, materials), of texels whose slopes are these, (n, 2)."""
    unit = radiances(fits, seen.lit, slopes_to_normals(slopes, frame), found.used)
    expected = np.einsum("npcm,nm->npc", unit, found.weights)
    return _weights(unit, seen, found.used, expected_deviation(seen, expected, found.used, prior=prior), prior)


def _nonnegative(unit: FloatArray, values: FloatArray) -> FloatArray:
    """The nonnegative weights, (n, m), with which radiances of unit weights, (n, q, m), are closest to values (n, q).
    """
    return nonnegative_least_squares(_gram(unit), np.einsum("nqm,nq->nm", unit, values))


def _gram(unit: FloatArray) -> FloatArray:
    gram = np.einsum("nqm,nqk->nmk", unit, unit)
    trace = np.einsum("nmm->n", gram)
    return np.asarray(gram + (_RIDGE * trace + np.finfo(float).tiny)[:, None, None] * np.eye(gram.shape[1]))


def _weights(unit: FloatArray, seen: Observed, used: BoolArray, scale: FloatArray, prior: Prior) -> FloatArray:
    """The weights for radiances of unit weights: (n, p, c, m) to (n, m)."""
    share = used[..., None] / scale
    n, p, channels, m = unit.shape
    return _nonnegative(*_append_prior((unit * share[..., None]).reshape(n, p * channels, m),
                                       (seen.radiance * share).reshape(n, p * channels), used, prior))


def _append_prior(unit: FloatArray, values: FloatArray, used: BoolArray, prior: Prior) -> tuple[FloatArray, FloatArray]:
    """Radiances of unit weights (n, q, m) and values (n, q), and below them those of the prior, of texels that are
    seen in a photograph."""
    rows, expected = prior.rows
    is_seen = np.asarray(used.any(axis=1))
    return (np.concatenate([unit, is_seen[:, None, None] * rows], axis=1),
            np.concatenate([values, is_seen[:, None] * expected], axis=1))


def expected_deviation(seen: Observed, expected: FloatArray, used: BoolArray, share: float = NOISE,
                       prior: Prior | None = None) -> FloatArray:
    """The deviation that is expected of values, (n, p, c): their noise, and a share of them, or of what is typical of
    the texel where they are far below it, or below it at all where the model is poor."""
    count = np.maximum(used.sum(axis=1), 1)[:, None, None]
    least = 1.0 if prior is not None and prior.is_poor else _DARK
    typical = least * (expected * used[..., None]).sum(axis=1, keepdims=True) / count
    deviation = np.hypot(seen.noise, share * np.maximum(expected, np.maximum(typical, 0)))
    # what does not count, as saturated pixels, may have neither noise nor radiance
    return np.where(used[..., None], deviation, 1.0)


def _dark(seen: Observed, frame: FloatArray, prior: Prior) -> BoolArray:
    """Where a texel is so much darker than under other lamps that it may be in a shadow: (n, p)."""
    if prior.is_poor:
        return np.zeros(seen.good.shape, bool)
    reflected = _flat_reflectance(seen, frame)
    typical = np.nanmedian(np.where(seen.good, reflected, np.nan), axis=1) if seen.good.any(axis=1).all() else np.array(
        [np.median(each[good]) if good.any() else 0.0 for each, good in zip(reflected, seen.good, strict=True)])
    return np.asarray(reflected < _DARK * typical[:, None])


def _flat_reflectance(seen: Observed, frame: FloatArray) -> FloatArray:
    """What a flat texel reflects, in the mean over channels, 1/sr: (n, p)."""
    cosine = np.maximum(seen.lit.light @ frame[2], np.cos(STEEPEST))
    return np.asarray((seen.radiance / (seen.lit.brought * cosine[..., None])).mean(axis=2))


def guess_slopes(seen: Observed, used: BoolArray, frame: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slopes of a Lambertian, whatever shines, and those that mirror the lamp under which a texel is brightest: (n, 2).

    Of the first the sum of absolute differences is least, by weights in turn: highlights count little.
    """
    brightness = (seen.radiance / seen.lit.brought).mean(axis=2)
    weight = used.astype(float)
    turned = seen.lit.light @ frame.T
    for _ in range(6):
        gram = np.einsum("np,npi,npj->nij", weight, turned, turned)
        gram += (1e-6 * weight.sum(axis=1) + 1e-12)[:, None, None] * np.eye(3)
        pointing = np.linalg.solve(gram, np.einsum("np,npi,np->ni", weight, turned, brightness)[..., None])[..., 0]
        off = np.abs(brightness - np.einsum("npi,ni->np", turned, pointing))
        weight = used / np.maximum(off, NOISE * np.abs(brightness) + 1e-12)
    lambertian = normals_to_slopes(pointing @ frame, frame, 2 * STEEP)
    brightest = np.where(used, _flat_reflectance(seen, frame), -np.inf).argmax(axis=1)
    half = (seen.lit.light + seen.lit.view)[np.arange(len(used)), brightest]
    return lambertian, normals_to_slopes(half, frame, 2 * STEEP)


class _Descent(NamedTuple):
    slopes: FloatArray
    cost: FloatArray
    weights: FloatArray
    unit: FloatArray    # radiances of unit weights in units of their deviation: (n, q, m)
    change: FloatArray  # their derivatives by both slopes: (n, q, m, 2)


def _descend(fits: Sequence[Reflectance], seen: Observed, used: BoolArray, scale: FloatArray, frame: FloatArray,
             start: FloatArray, steps: int, prior: Prior, unit: FloatArray | None = None) -> _Descent:
    """Slopes (n, 2) that descended from a start by so many steps; `unit` is the radiances of unit weights there, (n, p,
    channels, materials). Derivatives are worked out again where the slopes have changed by more than `_CURVED` since.
    """
    slopes = start.copy()
    share = used[..., None] / scale
    observed_values = (seen.radiance * share).reshape(len(used), -1)

    def unit_radiances(which: IntArray, tried: FloatArray) -> FloatArray:
        part = ShadingGeometry(*(each[which] for each in seen.lit))
        found = radiances(fits, part, slopes_to_normals(tried, frame), used[which]) * share[which][..., None]
        return _append_prior(found.reshape(len(which), -1, len(fits)), observed_values[which], used[which],
                             prior)[0]

    everywhere = np.arange(len(slopes))
    unit = unit_radiances(everywhere, slopes) if unit is None else (unit * share[..., None]).reshape(
        *observed_values.shape, -1)
    unit, values = _append_prior(unit[:, :observed_values.shape[1]], observed_values, used, prior)
    weights = _nonnegative(unit, values)
    cost = _cost(unit, values, weights, slopes, prior)
    change, derived = np.zeros((*unit.shape, 2)), np.full_like(slopes, np.inf)
    damping, going = np.full(len(slopes), 1e-2), everywhere
    for _ in range(steps):
        stale = going[~(np.linalg.norm(slopes[going] - derived[going], axis=1) < _CURVED)]
        if len(stale):
            for k, shift in enumerate(DIFFERENCE * np.eye(2)):
                change[stale, ..., k] = (unit_radiances(stale, slopes[stale] + shift) - unit[stale]) / DIFFERENCE
            derived[stale] = slopes[stale]
        of = _normal_equations(unit[going], values[going], change[going], slopes[going], weights[going], prior)
        diagonal = np.einsum("nii->ni", of.slopes)[..., None] * np.eye(2)
        step = np.linalg.solve(of.slopes + damping[going, None, None] * diagonal, of.right[..., None])[..., 0]
        step *= np.minimum(1, STEEP / 2 / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-12))
        moves = np.linalg.norm(step, axis=1) > _STILL
        going, step = going[moves], step[moves]
        if not len(going):
            break
        tried = slopes[going] + step
        there = unit_radiances(going, tried)
        w = _nonnegative(there, values[going])
        now = _cost(there, values[going], w, tried, prior)
        better = now < cost[going]
        at_better = going[better]
        slopes[at_better], weights[at_better], cost[at_better] = tried[better], w[better], now[better]
        unit[at_better] = there[better]
        damping[going] *= np.where(better, 0.2, 6.0)
        derived[going[~better & (derived[going] != slopes[going]).any(axis=1)]] = np.inf
    return _Descent(slopes, cost, weights, unit, change)


def _cost(unit: FloatArray, values: FloatArray, weights: FloatArray, slopes: FloatArray, prior: Prior) -> FloatArray:
    off = values - np.einsum("nqm,nm->nq", unit, weights)
    return np.asarray((off ** 2).sum(axis=1) + prior.misfit * (slopes ** 2).sum(axis=1) / STEEP ** 2)


class _Equations(NamedTuple):
    weights: FloatArray     # the inverse of the weights' covariance, with the slopes projected out: (n, m, m)
    slopes: FloatArray      # that of the slopes', with the weights above 0 projected out: (n, 2, 2)
    right: FloatArray       # the right side of a step of the slopes: (n, 2)
    response: FloatArray    # by how much the weights above 0 change with the slopes: (n, m, 2)


def _normal_equations(unit: FloatArray, values: FloatArray, change: FloatArray, slopes: FloatArray,
                      weights: FloatArray, prior: Prior) -> _Equations:
    now = np.einsum("nqm,nm->nq", unit, weights)
    change = np.einsum("nqmk,nm->nqk", change, weights)
    gram = _gram(unit)
    across = np.swapaxes(unit, 1, 2) @ change
    stiff = prior.misfit / STEEP ** 2
    own = np.swapaxes(change, 1, 2) @ change + np.eye(2) * stiff
    right = np.einsum("nqk,nq->nk", change, values - now) - slopes * stiff
    taken = gram - across @ np.linalg.solve(own, np.swapaxes(across, 1, 2))
    held = weights <= 0
    active = np.where(held[:, :, None] | held[:, None, :], 0.0, gram) + held[:, :, None] * np.eye(held.shape[1])
    across = np.where(held[..., None], 0.0, across)
    response = np.asarray(-np.linalg.solve(active, across), dtype=float)
    return _Equations(taken, own + np.swapaxes(across, 1, 2) @ response, right, response)


def _judge(seen: Observed, used: BoolArray, scale: FloatArray, found: _Descent, prior: Prior) -> Texels:
    """What was found, with its deviation: by the noise, or where more is left, by that."""
    values = _append_prior(found.unit[:, :-len(prior.mean)], (seen.radiance * (used[..., None] / scale)).reshape(
        len(used), -1), used, prior)[1]
    of = _normal_equations(found.unit, values, found.change, found.slopes, found.weights, prior)
    known = used.sum(axis=1) * seen.radiance.shape[2]
    left = found.cost / np.maximum(known - found.weights.shape[1] - 2, 1)
    more = np.maximum(left, 1)
    trace = np.einsum("nmm->n", of.weights)
    safe = of.weights + (_RIDGE * np.abs(trace) + np.finfo(float).tiny)[:, None, None] * np.eye(of.weights.shape[1])
    variance = np.einsum("nmm->nm", np.linalg.inv(safe)) * more[:, None]
    deviation = np.where((known > 0)[:, None], np.sqrt(np.maximum(variance, 0)), np.inf)
    return Texels(found.weights, deviation, found.slopes, of.slopes / more[:, None, None], used, left, of.response)
