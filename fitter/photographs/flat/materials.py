"""The materials that a flat sample is a mix of, found in its photographs.

1. A grey mix of a Lambertian and lobes of several widths gives each texel a normal, and then each of its channels
   strengths of them: a few numbers in which mixing is linear.
2. Where m materials are mixed, the texels' strengths lie in a cone with m edges. The space of the cone is found by
   alternating least squares, its edges by successive projection (N. Gillis, S. Vavasis: Fast and Robust Recursive
   Algorithms for Separable Nonnegative Matrix Factorization, IEEE Transactions on Pattern Analysis and Machine
   Intelligence 36(4), 2014): the purest texels.
3. There are as many materials as predict photographs best that were left out: one to four, or none, which is each
   texel's own Lambertian, a mix of one of each channel, and a lobe of the sample's mean. Lobes judge roughly: of many
   photographs, what may be better is fitted as well and compared.
4. Each material is fitted to what the texels that are mostly of it show under all lamps, less what they show of the
   others; then weights and normals, and materials again (Lensch et al. 2003).
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ... import progress
from ...arrays import Directions, FloatArray, IntArray, concatenate_directions
from ...errors import DatasetError
from ...least_squares import nonnegative_least_squares
from ...methods import fit
from ...methods.presets import PRESETS
from ...model import Reflectance
from ...model.fit import Fit
from ...model.microfacet import Microfacet
from ...samples import RGB, Samples
from ..ball.binning import bin_samples
from ..ball.coverage import LEAST, difference_angle
from ..description.capture_setup import MOST_MATERIALS
from ..rig.photograph import STEEPEST, to_local_angles
from .judging import UNCONSTRAINED, predict_unconstrained, relative_errors
from .photograph import Observed
from .solving import (
    DIFFERENCE,
    NOISE,
    Texels,
    estimate_prior,
    expected_deviation,
    radiances,
    slopes_to_normals,
    solve_texels,
)

MOST_TEXELS = 1500          # that are looked at: 4 s, and three materials have a hundred pure ones each
_WIDTHS = 0.05, 0.15, 0.4   # alpha of the lobes
_F0, _GAMMA = 0.08, 2.0     # of the lobes
_FEWEST = 4                 # photographs of a texel that has as many strengths
_LEAST_TEXELS = 30
_OF_LOBES = 0.03            # of a value, by which mixes of lobes are wrong
NONE, DULL = 0, -1          # of the materials that a sample is a mix of: each texel is its own, with or without a lobe
_WAYS = {**{number: f"{number} material{'s' * (number > 1)}" for number in range(1, MOST_MATERIALS + 1)},
         NONE: "each texel's own Lambertian and a lobe of the sample's mean", DULL: "each texel's own Lambertian alone"}
_ENOUGH = 1.3               # times the least error of cube roots, that fewer materials may have
_BETTER = 1.25              # times the error of texels that are each their own, or of more materials, that materials
                            # may have
_FOLDS, _JUDGED = 5, 250    # times that photographs are left out; texels that are looked at
_JUDGED_VALUES = 12000      # photographs times texels, if there are so many
_MANY = 24                  # photographs above which what lobes leave open is fitted and compared
_LEAST_DIFFUSE = 0.05       # of what a sample reflects, for its Lambertians to be some of it
_FIT_POLAR, _FIT_AZIMUTH = np.radians(np.linspace(0, 85, 24)), np.radians(np.linspace(0, 180, 25))
_ROUNDS = 30                # of least squares in turn
_PUREST = 0.02              # of the texels, whose mean is an edge: one texel alone may be wrong
_DARKEST = 0.1              # of the median: darker texels have no colour
_MOSTLY = 0.75              # of what a texel shows, that is of the material fitted to it
_FITTED, _SAMPLES = 60, 900     # texels, if so many are mostly of it; samples, which are fitted in a second
_NEAREST, _ASSUMED = 0.05, 0.1  # of the samples, those by the lamps nearest to the camera; of their values, by which
                            # what is nearer may differ
_OTHERS = 0.1               # of what is taken away as another material's, that is wrong
_REFINED = 2                # rounds: further ones change the picture under another lamp by less than 1 %


def materials_found(seen: Observed, frame: FloatArray, name: str, count: int | None = None,
                    ) -> tuple[tuple[Fit, ...], tuple[str, ...]]:
    """The materials, so many, that n texels show, those that are most of the sample first; and notes.

    By default there are as many as predict photographs best that were left out. Their scale is such that their purest
    texels have the weight 1. Raises DatasetError, which names the file `name`, if too few texels are seen under enough
    lamps.
    """
    grey = solve_texels(_lobes(), _mean_channels(seen), frame)
    progress.report(0.1)
    enough = np.flatnonzero(grey.used.sum(axis=1) >= _FEWEST)
    if len(enough) < _LEAST_TEXELS:
        raise DatasetError(f"{len(enough)} texels are seen and lit in {_FEWEST} photographs or more, expected "
                           f"{_LEAST_TEXELS} for the materials to be found in them: give the materials", name)
    texels, seen = grey.part(enough), seen.some(enough)
    asked = count
    count, rival, notes = _best_count(seen, frame) if count is None else (count, count, ())
    with progress.part(0.1, 1.0 if rival == count else 0.4):
        fits = _fit_materials(seen, texels, frame, count)
    if asked is not None and len(fits) < asked:
        return fits, (f"The photographs show {_WAYS[len(fits)]}, where {asked} were asked for",)
    if rival == count:
        return fits, notes
    with progress.part(0.4, 1.0):
        others = _fit_materials(seen, texels, frame, rival)
    off, less = (_error_of_fits(each, seen, texels, frame) for each in (fits, others))
    is_better = _BETTER * less < off
    return others if is_better else fits, (*notes, (
        f"Fitted, {_WAYS[count]} predicts them within {off:.1%}, {_WAYS[rival]} within {less:.1%}: "
        f"{_WAYS[rival if is_better else count]} it is"))


def _fit_materials(seen: Observed, texels: Texels, frame: FloatArray, count: int) -> tuple[Fit, ...]:
    """So many materials, or what `NONE` and `DULL` mix, of texels whose slopes are known; those that no texel shows are
    not among them."""
    if count < 1:
        own = _own(_equations(seen, texels, frame), count == NONE)
        return tuple(_fit_model(each, f"Part {k}", seen) for k, each in enumerate(own, start=1))
    mixed = _factorise(_equations(seen, texels, frame), count)
    models: Sequence[Reflectance] = _models(mixed.strengths)
    texels = texels._replace(weights=mixed.weights)
    for number in range(_REFINED):
        with progress.part(number / _REFINED, (number + 1) / _REFINED):
            samples = [_pool_samples(models, seen, frame, texels, material) for material in range(len(models))]
            fits = tuple(fit(each, **PRESETS["Standard"])
                         for each in progress.each([each for each in samples if each is not None]))
            if number + 1 < _REFINED:
                texels, models = solve_texels(fits, seen, frame, texels.slopes), fits
    return fits


def _lobes() -> list[Microfacet]:
    """A Lambertian of albedo 1 and lobes of strength 1."""
    return _models(np.eye(1 + len(_WIDTHS))[:, None])


def _mean_channels(seen: Observed) -> Observed:
    """The same in the mean over channels, of light that is as bright in all."""
    brought = seen.lit.brought.mean(axis=2, keepdims=True)
    balance = brought / seen.lit.brought
    noise = np.sqrt(((seen.noise * balance) ** 2).mean(axis=2, keepdims=True) / balance.shape[2])
    return Observed(seen.lit._replace(brought=brought), (seen.radiance * balance).mean(axis=2, keepdims=True), noise,
                    seen.good)


class _Equations(NamedTuple):
    """Normal equations gram d = right of the strengths d of j lobes."""

    gram: FloatArray    # (n, channels, j, j)
    right: FloatArray   # (n, channels, j)


class _Mixed(NamedTuple):
    weights: FloatArray     # (n, m)
    strengths: FloatArray   # (m, channels, j)


def _equations(seen: Observed, texels: Texels, frame: FloatArray) -> _Equations:
    share = texels.used[..., None] / expected_deviation(seen, seen.radiance, texels.used, _OF_LOBES)
    unit = radiances(_lobes(), seen.lit, slopes_to_normals(texels.slopes, frame), texels.used) * share[..., None]
    return _Equations(np.einsum("npcj,npck->ncjk", unit, unit),
                      np.einsum("npcj,npc->ncj", unit, seen.radiance * share))


def _models(strengths: FloatArray) -> list[Microfacet]:
    """Materials of strengths (m, channels, j) of the lobes, whose arrays of shapes are the same objects."""
    shapes = np.array(_WIDTHS), np.full(len(_WIDTHS), _GAMMA), np.full(len(_WIDTHS), _F0)
    return [Microfacet(each[:, 0] / np.pi, each[:, 1:].T, *shapes) for each in strengths]


def _own(equations: _Equations, shines: bool = True) -> list[Microfacet]:
    """A Lambertian of each channel, and where it shines a lobe of the sample's mean: what mixes to each texel's own
    Lambertian."""
    gram, right = (each.sum(axis=0) for each in equations)
    whole = nonnegative_least_squares(gram + _ridge(gram), right)
    channels, lobes = whole.shape
    parts = np.zeros((channels + 1, channels, lobes))
    parts[np.arange(channels), np.arange(channels), 0] = np.maximum(whole[:, 0], _LEAST_DIFFUSE * whole.sum(axis=1))
    parts[channels, :, 1:] = whole[:, 1:]
    return _models(parts if shines and whole[:, 1:].any() else parts[:channels])


def _fit_model(model: Microfacet, name: str, seen: Observed) -> Fit:
    """A model as it is in the directions of a sphere, fitted."""
    channels = seen.radiance.shape[2]
    light, view, azimuth = (each.ravel() for each in np.meshgrid(_FIT_POLAR, _FIT_POLAR, _FIT_AZIMUTH, indexing="ij"))
    level = np.zeros_like(light)
    values = model.evaluate(light, level, view, azimuth)
    return fit(Samples(light, level, view, azimuth, values, RGB if channels == len(RGB) else ("grey",), name,
                       "photographs of a flat sample"), **PRESETS["Standard"])


def _best_count(seen: Observed, frame: FloatArray) -> tuple[int, int, tuple[str, ...]]:
    """How many materials, or `NONE`, predict photographs that are left out best; the same, or what may be better still
    when both are fitted; and what is to be said of it."""
    seen = seen.some(_evenly(seen))
    errors: dict[int | str, list[tuple[float, float]]] = {}
    for used, other in _folds(seen):
        if (used.good.sum(axis=1) < _FEWEST).all():
            continue
        grey = solve_texels(_lobes(), _mean_channels(used), frame)
        enough = np.flatnonzero(grey.used.sum(axis=1) >= _FEWEST)
        if len(enough) < _LEAST_TEXELS:
            continue
        used, other, texels = used.some(enough), other.some(enough), grey.part(enough)
        equations = _equations(used, texels, frame)
        ways = {number: _models(_factorise(equations, number).strengths)
                for number in range(1, MOST_MATERIALS + 1)} | {
                        NONE: _own(equations), DULL: _own(equations, False)}
        for way, models in ways.items():
            errors.setdefault(way, []).extend(_both_errors(_predict(models, used, other, frame, texels.slopes), other))
        for name, expected in predict_unconstrained(used, other, frame).items():
            errors.setdefault(name, []).extend(_both_errors(expected, other))
    if not errors:
        return 1, 1, ()
    # a photograph that is missed by more than it shows counts by as much: a metal's Lambertians miss those of low lamps
    mean, of_roots = ({way: float(np.mean(each, axis=0)[k]) for way, each in errors.items()} for k in (0, 1))
    numbers = range(1, MOST_MATERIALS + 1)
    # highlights, which lobes of a few widths miss, are less of the cube roots
    best = next(each for each in numbers if of_roots[each] <= _ENOUGH * min(of_roots[each] for each in numbers))
    own, more = (min(ways, key=lambda each: mean[each]) for ways in ((NONE, DULL), numbers))
    rival = next((each for each in (own, more) if _BETTER * mean[each] < mean[best]), best)
    if seen.good.shape[1] <= _MANY:
        best = rival = own if rival == own else best
    why = f", for more are not {_ENOUGH:g} times better by cube roots, in which highlights count less" if (
        best not in (NONE, DULL) and mean[best] > min(mean[each] for each in numbers)) else ""
    notes = ["Photographs that were left out are predicted within " + ", ".join(
        f"{mean[way]:.1%} by {words}" for way, words in _WAYS.items()) + f": {_WAYS[best]} it is{why}"]
    free = min(UNCONSTRAINED, key=lambda each: mean[each])
    if mean[free] < mean[rival]:
        notes.append(f"No mix of materials describes this sample: a {free} at each texel, whatever the others are, "
                     f"predicts those within {mean[free]:.1%}")
    return best, rival, tuple(notes)


def _error_of_fits(fits: Sequence[Fit], seen: Observed, texels: Texels, frame: FloatArray) -> float:
    """The mean error of photographs that are left out in turn when texels are solved as a mix of these materials."""
    errors: list[float] = []
    some = _evenly(seen)
    for used, other in _folds(seen.some(some)):
        errors += relative_errors(_predict(fits, used, other, frame, texels.slopes[some]), other)
    return float(np.mean(errors))


def _evenly(seen: Observed) -> IntArray:
    """The numbers of texels that are looked at: fewer where there are many photographs, of which all count."""
    most = min(len(seen.good), _JUDGED, max(_JUDGED_VALUES // seen.good.shape[1], _LEAST_TEXELS))
    return np.linspace(0, len(seen.good) - 1, most).astype(int)


def _folds(seen: Observed) -> Iterator[tuple[Observed, Observed]]:
    """The same without some of the photographs, and these alone, in turn."""
    number = np.arange(seen.good.shape[1])
    for fold in range(min(_FOLDS, len(number))):
        left = number % _FOLDS == fold
        yield seen._replace(good=seen.good & ~left), seen._replace(good=seen.good & left)


def _predict(models: Sequence[Reflectance], used: Observed, other: Observed, frame: FloatArray,
             slopes: FloatArray) -> FloatArray:
    """What mixes of models, solved from slopes (n, 2), say of other photographs of the same texels: (n, p, channels).
    """
    found = solve_texels(models, used, frame, slopes)
    prior = estimate_prior(found)
    if prior.is_poor:
        found = solve_texels(models, used, frame, found.slopes, prior)
    unit = radiances(models, other.lit, slopes_to_normals(found.slopes, frame), other.good)
    return np.asarray(np.einsum("npcm,nm->npc", unit, found.weights))


def _both_errors(expected: FloatArray, seen: Observed) -> list[tuple[float, float]]:
    """`relative_errors`, and those of cube roots."""
    return list(zip(relative_errors(expected, seen), relative_errors(
        np.cbrt(expected), seen._replace(radiance=np.cbrt(seen.radiance))), strict=True))


def _factorise(equations: _Equations, count: int) -> _Mixed:
    """So many materials, and how much each texel has of them."""
    channels, lobes = equations.right.shape[1:]
    # where they tell little of a texel, its strengths are those of the whole sample
    gram, right = (each.sum(axis=0) for each in equations)
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
    return _Mixed(weights[:, order], strengths[order])


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


def _weight_equations(equations: _Equations, strengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The normal equations of the weights: (n, m, m) and (n, m)."""
    through = np.einsum("mcj,ncjl->nmcl", strengths, equations.gram)
    return (np.einsum("nmcl,kcl->nmk", through, strengths),
            np.einsum("mcj,ncj->nm", strengths, equations.right))


def _weights(equations: _Equations, strengths: FloatArray, free: bool = False) -> FloatArray:
    """The weights (n, m), at least 0 if not `free`."""
    gram, right = _weight_equations(equations, strengths)
    gram = gram + _ridge(gram)
    if free:
        return np.asarray(np.linalg.solve(gram, right[..., None])[..., 0])
    return nonnegative_least_squares(gram, right)


def _strengths(equations: _Equations, weights: FloatArray, free: bool = False) -> FloatArray:
    """The strengths (m, channels, j), at least 0 if not `free`."""
    m, (channels, lobes) = weights.shape[1], equations.right.shape[1:]
    pairs = np.einsum("nm,nk->nmk", weights, weights).reshape(len(weights), -1)
    gram = np.einsum("na,ncjl->cajl", pairs, equations.gram)
    gram = gram.reshape(channels, m, m, lobes, lobes).swapaxes(2, 3).reshape(channels, m * lobes, m * lobes)
    right = np.einsum("nm,ncj->cmj", weights, equations.right).reshape(channels, m * lobes)
    gram = gram + _ridge(gram)
    found = np.linalg.solve(gram, right[..., None])[..., 0] if free else nonnegative_least_squares(gram, right)
    return np.asarray(found.reshape(channels, m, lobes).swapaxes(0, 1))


def _pool_samples(models: Sequence[Reflectance], seen: Observed, frame: FloatArray, texels: Texels,
                  material: int) -> Samples | None:
    """What texels that are mostly of one material show of it, about their normals; None if none is of it at all."""
    def radiances_at(slopes: FloatArray) -> FloatArray:
        unit = radiances(models, seen.lit, slopes_to_normals(slopes, frame), texels.used)
        return unit * texels.weights[:, None, None]

    each = radiances_at(texels.slopes)
    bright = each.sum(axis=(1, 2))
    share = bright[:, material] / np.maximum(bright.sum(axis=1), np.finfo(float).tiny)
    which = np.argsort(-share, kind="stable")[:max(_FITTED, int((share > _MOSTLY).sum()))]
    which = which[share[which] > 0]
    others = (each.sum(axis=3) - each[..., material])[which]
    change = np.stack([(radiances_at(texels.slopes + shift) - each)[which].sum(axis=3) / DIFFERENCE
                       for shift in DIFFERENCE * np.eye(2)], axis=3)
    by_slope = np.einsum("npci,nij,npcj->npc", change, np.linalg.inv(texels.precision[which]), change)
    radiance = seen.radiance[which]
    wrong = np.sqrt(seen.noise[which] ** 2 + (NOISE * radiance) ** 2 + (_OTHERS * others) ** 2
                    + np.maximum(by_slope, 0)).mean(axis=2)
    own = np.maximum(radiance - others, 0.05 * radiance).mean(axis=2)
    normal = np.broadcast_to(slopes_to_normals(texels.slopes[which], frame)[:, None], seen.lit.light[which].shape)
    used = texels.used[which] & (own > 0) & (np.minimum(*(
        np.einsum("npk,npk->np", toward[which], normal) for toward in seen.lit[:2])) > np.cos(STEEPEST))
    if not used.any():
        return None
    directions = to_local_angles(normal[used], seen.lit.light[which][used], seen.lit.view[which][used])
    weight = texels.weights[which, material] / np.median(texels.weights[which, material])
    brought = np.cos(directions[0])[:, None] * (seen.lit.brought[which] * weight[:, None, None])[used]
    values, deviation = (radiance - others)[used] / brought, (wrong / np.where(own > 0, own, 1))[used]
    if len(values) > _SAMPLES:
        directions, values, deviation = bin_samples(directions, values, deviation, _SAMPLES)
    directions, values, deviation = _extend_to_camera(directions, values, deviation)
    channels = RGB if values.shape[1] == len(RGB) else ("grey",)
    return Samples(*directions, values, channels, f"Material {material + 1}", "photographs of a flat sample",
                   (f"{len(which):,} texels",), deviation=deviation)


def _extend_to_camera(directions: Directions, values: FloatArray,
                      deviation: FloatArray) -> tuple[Directions, FloatArray, FloatArray]:
    """The same, and where no lamp stood as near to the camera, values as under those that stood nearest, at the same
    half vectors: a lamp that is brighter than is said would otherwise be taken for the foot of a retro-reflection."""
    difference = difference_angle(directions)
    near = np.argsort(difference, kind="stable")[:max(_FEWEST, int(_NEAREST * len(values)))]
    if difference[near[-1]] < np.radians(LEAST):
        return directions, values, deviation
    upright = (np.cos(directions[0]) + np.cos(directions[2]))[near] / (2 * np.cos(difference[near]))
    half = np.arccos(np.clip(upright, -1, 1))
    level = np.zeros_like(half)
    return (concatenate_directions([directions, (half, level, half, level)]), np.concatenate([values, values[near]]),
            np.concatenate([deviation, np.maximum(deviation[near], _ASSUMED)]))
