"""The materials that a flat sample is a mix of, found in its photographs.

1. A grey mix of a Lambertian and lobes of several widths gives each texel a normal, and then each of its channels
   strengths of them: a few numbers in which mixing is linear.
2. Where m materials are mixed, the texels' strengths lie in a cone with m edges. The space of the cone is found by
   alternating least squares, its edges by successive projection (N. Gillis, S. Vavasis: Fast and Robust Recursive
   Algorithms for Separable Nonnegative Matrix Factorization, IEEE Transactions on Pattern Analysis and Machine
   Intelligence 36(4), 2014): the purest texels. There are as many as the data need.
3. Each material is fitted to what the texels that are mostly of it show under all lamps, less what they show of the
   others; then weights and normals, and materials again (Lensch et al. 2003).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import FloatArray, IntArray
from ..errors import DatasetError
from ..methods import fit
from ..model import Reflectance
from ..model.fit import Fit
from ..model.microfacet import Microfacet
from ..presets import PRESETS
from ..samples import RGB, Samples
from .ball import STEEPEST, about
from .binning import binned
from .flat_photograph import Observed
from .flat_solving import DIFFERENCE, NOISE, Texels, nonnegative, normals_of, radiances, scale_of, solved

MOST_TEXELS = 1500          # that are looked at: 4 s, and three materials have a hundred pure ones each
_WIDTHS = 0.05, 0.15, 0.4   # alpha of the lobes
_F0, _GAMMA = 0.08, 2.0     # of the lobes
_FEWEST = 4                 # photographs of a texel that has as many strengths
_LEAST_TEXELS = 30
_OF_LOBES = 0.03            # of a value, by which mixes of lobes are wrong
_NEEDED = 0.7               # of the squared errors, that one material more must leave at most: of 2 and 3 paints each
                            # left .16 to .51, and one too many .83 to 1
_ROUNDS, _SWEEPS = 30, 300  # of least squares in turn; of coordinates within one
_PUREST = 0.02              # of the texels, whose mean is an edge: one texel alone may be wrong
_DARKEST = 0.1              # of the median: darker texels have no colour
_MOSTLY = 0.75              # of what a texel shows, that is of the material fitted to it
_FITTED, _SAMPLES = 60, 900     # texels, if so many are mostly of it; samples, which are fitted in a second
_OTHERS = 0.1               # of what is taken away as another material's, that is wrong
_REFINED = 2                # rounds: further ones change the picture under another lamp by less than 1 %


def materials_found(seen: Observed, frame: FloatArray, most: int, name: str) -> tuple[Fit, ...]:
    """The materials, one to `most`, that n texels show, those that are most of the sample first.

    Their scale is such that their purest texels have the weight 1. Raises DatasetError, which names the file `name`, if
    too few texels are seen under enough lamps.
    """
    grey = solved(_lobes(), _grey(seen), frame)
    progress.report(0.1)
    enough = np.flatnonzero(grey.used.sum(axis=1) >= _FEWEST)
    if len(enough) < _LEAST_TEXELS:
        raise DatasetError(f"{len(enough)} texels are seen and lit in {_FEWEST} photographs or more, expected "
                           f"{_LEAST_TEXELS} for the materials to be found in them: give the materials", name)
    texels, seen = grey.part(enough), seen.some(enough)
    mixed = _unmixed(_equations(seen, texels, frame), most)
    models: Sequence[Reflectance] = [
        Microfacet(each[:, 0] / np.pi, each[:, 1:].T, np.array(_WIDTHS), np.full(len(_WIDTHS), _GAMMA),
                   np.full(len(_WIDTHS), _F0)) for each in mixed.strengths]
    texels = texels._replace(weights=mixed.weights)
    for number in range(_REFINED):
        with progress.part(0.1 + 0.45 * number, 0.1 + 0.45 * (number + 1)):
            samples = [_pooled(models, seen, frame, texels, material) for material in range(len(models))]
            fits = tuple(fit(each, **PRESETS["Standard"]) for each in progress.each(samples))
            if number + 1 < _REFINED:
                texels, models = solved(fits, seen, frame, texels.slopes), fits
    return fits


def _lobes() -> list[Microfacet]:
    """A Lambertian of albedo 1 and lobes of strength 1."""
    none = np.zeros(0)
    return [Microfacet(np.ones(1) / np.pi, np.zeros((0, 1)), none, none, none), *(
        Microfacet(np.zeros(1), np.ones((1, 1)), np.array([width]), np.array([_GAMMA]), np.array([_F0]))
        for width in _WIDTHS)]


def _grey(seen: Observed) -> Observed:
    """The same in the mean over channels, of light that is as bright in all."""
    brought = seen.lit.brought.mean(axis=2, keepdims=True)
    balance = brought / seen.lit.brought
    noise = np.sqrt(((seen.noise * balance) ** 2).mean(axis=2, keepdims=True) / balance.shape[2])
    return Observed(seen.lit._replace(brought=brought), (seen.radiance * balance).mean(axis=2, keepdims=True), noise,
                    seen.good)


class _Equations(NamedTuple):
    """Normal equations of the strengths d of j lobes: the squared errors are d gram d - 2 right d + square."""

    gram: FloatArray
    """(n, channels, j, j)."""
    right: FloatArray
    """(n, channels, j)."""
    square: FloatArray
    """Over all channels: (n,)."""


class _Mixed(NamedTuple):
    weights: FloatArray
    """(n, m)."""
    strengths: FloatArray
    """(m, channels, j)."""


def _equations(seen: Observed, texels: Texels, frame: FloatArray) -> _Equations:
    share = texels.used[..., None] / scale_of(seen, seen.radiance, texels.used, _OF_LOBES)
    unit = radiances(_lobes(), seen.lit, normals_of(texels.slopes, frame), texels.used) * share[..., None]
    values = seen.radiance * share
    return _Equations(np.einsum("npcj,npck->ncjk", unit, unit), np.einsum("npcj,npc->ncj", unit, values),
                      np.einsum("npc,npc->n", values, values))


def _unmixed(equations: _Equations, most: int) -> _Mixed:
    """As few materials as explain the texels."""
    best, least = _mixed_of(equations, 1)
    for count in range(2, most + 1):
        found, cost = _mixed_of(equations, count)
        if cost > _NEEDED * least:
            break
        best, least = found, cost
    return best


def _mixed_of(equations: _Equations, count: int) -> tuple[_Mixed, float]:
    """So many materials, and the sum of squared errors."""
    channels, lobes = equations.right.shape[1:]
    # where they tell little of a texel, its strengths are those of the whole sample
    gram, right = (each.sum(axis=0) for each in equations[:2])
    whole = np.linalg.solve(gram + _ridge(gram), right[..., None])[..., 0]
    pull = 0.3 * np.einsum("ncjj->nc", equations.gram)[..., None] / lobes + np.finfo(float).tiny
    each = np.linalg.solve(equations.gram + pull[..., None] * np.eye(lobes),
                           (equations.right + pull * whole)[..., None])[..., 0].reshape(-1, channels * lobes)
    strengths = np.linalg.svd(each, full_matrices=False)[2][:count].reshape(-1, channels, lobes)
    for _ in range(_ROUNDS):
        weights = _weights(equations, strengths, free=True)
        strengths = _strengths(equations, weights, free=True)
    groups = _edges(weights @ np.linalg.qr(strengths.reshape(len(strengths), -1).T)[1].T)
    explained = weights @ strengths.reshape(len(strengths), -1)
    strengths = np.maximum([np.median(explained[group], axis=0) for group in groups], 0).reshape(-1, channels, lobes)
    for _ in range(_ROUNDS // 6):
        weights = _weights(equations, strengths)
        strengths = _strengths(equations, weights)
    weights = _weights(equations, strengths)
    order = np.argsort(-(weights.sum(axis=0) * strengths.sum(axis=(1, 2))), kind="stable")
    gram, right = _of_weights(equations, strengths)
    cost = equations.square - 2 * (weights * right).sum(axis=1) + np.einsum("nm,nmk,nk->n", weights, gram, weights)
    return _Mixed(weights[:, order], strengths[order]), float(cost.sum())


def _edges(places: FloatArray) -> list[IntArray]:
    """The texels at the edges of a cone in which all lie, (n, m), as their numbers."""
    middle = places.mean(axis=0) / np.linalg.norm(places.mean(axis=0))
    bright = np.flatnonzero(places @ middle > _DARKEST * np.median(places @ middle))
    left, groups = places[bright] / (places[bright] @ middle)[:, None], []
    for _ in range(places.shape[1]):
        far = np.argsort(np.linalg.norm(left, axis=1))[-max(3, int(_PUREST * len(left))):]
        along = left[far] @ np.linalg.svd(left[far], full_matrices=False)[2][0]
        side = along > 0 if (along[along > 0] ** 2).sum() > (along[along < 0] ** 2).sum() else along < 0
        groups.append(bright[far[side]])
        edge = left[far[side]].mean(axis=0)
        left = left - np.outer(left @ edge, edge) / max(edge @ edge, np.finfo(float).tiny)
    return groups


def _ridge(gram: FloatArray) -> FloatArray:
    size = np.trace(gram, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray((1e-6 * size / gram.shape[-1] + np.finfo(float).tiny) * np.eye(gram.shape[-1]))


def _of_weights(equations: _Equations, strengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The normal equations of the weights: (n, m, m) and (n, m)."""
    through = np.einsum("mcj,ncjl->nmcl", strengths, equations.gram)
    return (np.einsum("nmcl,kcl->nmk", through, strengths),
            np.einsum("mcj,ncj->nm", strengths, equations.right))


def _weights(equations: _Equations, strengths: FloatArray, free: bool = False) -> FloatArray:
    """The weights (n, m), at least 0 if not `free`."""
    gram, right = _of_weights(equations, strengths)
    gram = gram + _ridge(gram)
    return np.asarray(np.linalg.solve(gram, right[..., None])[..., 0]) if free else nonnegative(gram, right)


def _strengths(equations: _Equations, weights: FloatArray, free: bool = False) -> FloatArray:
    """The strengths (m, channels, j), at least 0 if not `free`: then by descent along one after the other."""
    m, (channels, lobes) = weights.shape[1], equations.right.shape[1:]
    pairs = np.einsum("nm,nk->nmk", weights, weights).reshape(len(weights), -1)
    gram = np.einsum("na,ncjl->cajl", pairs, equations.gram)
    gram = gram.reshape(channels, m, m, lobes, lobes).swapaxes(2, 3).reshape(channels, m * lobes, m * lobes)
    right = np.einsum("nm,ncj->cmj", weights, equations.right).reshape(channels, m * lobes)
    gram = gram + _ridge(gram)
    found = np.linalg.solve(gram, right[..., None])[..., 0]
    if not free:
        found = np.maximum(found, 0)
        for _ in range(_SWEEPS):
            for k in range(m * lobes):
                off = np.einsum("ca,ca->c", gram[:, k], found) - right[:, k]
                found[:, k] = np.maximum(found[:, k] - off / gram[:, k, k], 0)
    return np.asarray(found.reshape(channels, m, lobes).swapaxes(0, 1))


def _pooled(models: Sequence[Reflectance], seen: Observed, frame: FloatArray, texels: Texels,
            material: int) -> Samples:
    """What texels that are mostly of one material show of it, about their normals."""
    def of_all(slopes: FloatArray) -> FloatArray:
        return radiances(models, seen.lit, normals_of(slopes, frame), texels.used) * texels.weights[:, None, None]

    each = of_all(texels.slopes)
    bright = each.sum(axis=(1, 2))
    share = bright[:, material] / np.maximum(bright.sum(axis=1), np.finfo(float).tiny)
    which = np.argsort(-share, kind="stable")[:max(_FITTED, int((share > _MOSTLY).sum()))]
    which = which[share[which] > 0]
    others = (each.sum(axis=3) - each[..., material])[which]
    change = np.stack([(of_all(texels.slopes + shift) - each)[which].sum(axis=3) / DIFFERENCE
                       for shift in DIFFERENCE * np.eye(2)], axis=3)
    by_slope = np.einsum("npci,nij,npcj->npc", change, np.linalg.inv(texels.precision[which]), change)
    radiance = seen.radiance[which]
    wrong = np.sqrt(seen.noise[which] ** 2 + (NOISE * radiance) ** 2 + (_OTHERS * others) ** 2
                    + np.maximum(by_slope, 0)).mean(axis=2)
    own = np.maximum(radiance - others, 0.05 * radiance).mean(axis=2)
    normal = np.broadcast_to(normals_of(texels.slopes[which], frame)[:, None], seen.lit.light[which].shape)
    used = texels.used[which] & (own > 0) & (np.minimum(*(
        np.einsum("npk,npk->np", toward[which], normal) for toward in seen.lit[:2])) > np.cos(STEEPEST))
    directions = about(normal[used], seen.lit.light[which][used], seen.lit.view[which][used])
    weight = texels.weights[which, material] / np.median(texels.weights[which, material])
    brought = np.cos(directions[0])[:, None] * (seen.lit.brought[which] * weight[:, None, None])[used]
    values, deviation = (radiance - others)[used] / brought, (wrong / np.where(own > 0, own, 1))[used]
    if len(values) > _SAMPLES:
        directions, values, deviation = binned(directions, values, deviation, _SAMPLES)
    channels = RGB if values.shape[1] == len(RGB) else ("grey",)
    return Samples(*directions, values, channels, f"Material {material + 1}", "photographs of a flat sample",
                   (f"{len(which):,} texels",), deviation=deviation)
