"""A fit as a sum of Blender's closures: what Cycles samples, with OSL and, as closure nodes, without; and EEVEE. What
the sum is, and what it is used for, is in docs/rendering.md.

The lobes are what is left of many, whose shapes do not change with the viewer's angle, after those have been removed
without which the error grows least (B. Hassibi, D. G. Stork: Second Order Derivatives for Network Pruning: Optimal
Brain Surgeon, NIPS 1992); then the shapes are refined for all angles at once, by a Levenberg-Marquardt iteration for
the absolute error in which the colours have been eliminated (Golub and Pereyra: The Differentiation of Pseudo-Inverses
and Nonlinear Least Squares Problems Whose Variables Separate, 1973) and second differences from angle to angle are
penalised.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import FloatArray, RealArray
from ..least_squares import nonnegative_least_squares
from ..model import Reflectance, is_isotropic
from ..optics.subsurface import Walk
from ..shader_constants import LEAST_FOLLOWED
from . import node_lobes
from .node_lobes import FACETS, Kind, Pairs, Shape
from .outgoing_directions import OutgoingDirections, tabulate_outgoing
from .principal import principal
from .selection import selection_probabilities

_FACET_WIDTHS = (0.08, 0.12, 0.17, 0.23, 0.3, 0.38, 0.47, 0.57, 0.68, 0.8, 0.95)   # candidates for microfacet lobes
_TILTS = (-0.3, -0.12, 0.0, 0.15, 0.4, 1.0)
_DIFFUSE_TILTS = (-0.6, 0.6, 0.9)                               # candidates for diffuse lobes beside the first
_SHEEN_ROUGHNESSES = (0.15, 0.3, 0.6, 1.0)                      # candidates for sheen
_TURNED_ROUGHNESS = (0.15, 0.25, 0.38, 0.53, 0.72)              # the same of anisotropic fits
_TURNED_TILTS = (0.0, 0.5)
_ANISOTROPIES = (-0.75, -0.4, 0.0, 0.4, 0.75)
_WORTH = 0.006                  # of the light: a lobe that puts less of it right takes more time than it is worth
_CHOICE, _REFINEMENT = slice(3, None, 7), slice(0, None, 5)     # of the directions, what is looked at
_CHOICE_VIEWS = 12              # and at about how many angles
_CHOICE_REWEIGHTINGS = 2        # of as few lobes as an engine has
_REFINEMENTS = 10                # of the refinement, for each of two floors
_SETTLED = 1e-3                 # of the error: a step that lowers it by less is the last
_TRIES = 4                      # of a step
_LONGEST = 0.3                  # step of a parameter
_STIFFNESS = 0.1                # of the second differences of shapes
_LEAST_FACET_ROUGHNESS, _SHEEREST = 0.04, 0.05  # roughness of a facet and of sheen
_MOST_TILTED = 1.0
_TILTED_COSINE = 0.3      # cosine of a tilted normal and the viewer, in that of the surface's
_MOST_ANISOTROPIC = 0.78
_THRIFTLESS = 0.02             # by which share those may be above it
_ERROR_FLOOR, _LAST_FLOOR = 0.1, 0.02   # absolute errors below this share of the mean radiance count as squared ones
_FIRMNESS = 10.0                # of the albedo's squared errors
_THRIFT = 1.0                   # and of those of the weights of all closures, which are the denoiser's albedo
_RIDGE = 1e-4                   # of the squared colours, in the squared target
_REWEIGHTINGS = 6
_SCALES = (0.7, 1.5)            # bounds of the factors that give the lobes the albedo of the fit
_LEAST_DIVISOR = 1e-30
_LEAST_ALBEDO = 1e-12           # albedo, whose square is far from the least number of single precision
LAST_SHOWN = np.radians(80)     # the last view whose error the panel states
_OVERSHOOT_WEIGHT = 10.0        # what is above the target counts as this many times as much that is below
_BELOW_REWEIGHTINGS = 20
_PROBABILITY = 3.0              # of sampling the residual, per share of the light in it
_PROBABILITIES = (0.2, 1.0)     # bounds of that probability
_PREPARED_SHARE = 0.1           # share of the target that sampled directions are prepared to carry anywhere


_Lobe = tuple[Kind, float, float, float]       # kind, roughness, tilt and anisotropy


class Engine(NamedTuple):
    """Which closures of a renderer approximate a fit."""

    lobes: int              # at most, beside the first diffuse one
    kinds: tuple[Kind, ...]
    normal_offsets: tuple[float, float]  # bounds of the tilt
    anisotropic: bool       # whether it renders facets of two widths, and colours that follow the viewer's azimuth
    sampled: bool           # whether a shader samples directions by them


CYCLES = Engine(6, ("diffuse", "GGX", "Beckmann", "sheen"), (-_MOST_TILTED, _MOST_TILTED), True, True)
# EEVEE shows Beckmann as GGX, sheen as a diffuse closure and no anisotropy, and lights what lies below the horizon
EEVEE = Engine(3, ("GGX",), (-0.5, 0.5), False, False)


class Sampling(NamedTuple):
    """What the shader shows of a mixture where it is exact, and how it samples directions for what that leaves. With
    their lower colours lobes hardly exceed the fit, so that the residual only adds; times the balance it gives the
    fit's albedo."""

    lower_colours: FloatArray               # (stops, lobes, phases, channels)
    selection_probabilities: FloatArray     # (stops, lobes + 1): of the pdf of each lobe and, the last, of none
    probability: FloatArray                 # (stops,): with which a sample of a shading point has a direction
    albedo: FloatArray                      # (stops, channels): of the fit, in the mean over the azimuths,
    residual: FloatArray                    # and of what the lobes leave of it
    balance: FloatArray                     # (stops, channels)


class NodeMixture(NamedTuple):
    """A sum of closure nodes, the first a diffuse one about the surface's normal. There are two phases where colours
    change with the azimuth of the viewer, else one."""

    kinds: tuple[Kind, ...]
    theta: FloatArray               # polar angles of the viewer, (stops,) radians, from 0
    shape: Shape                    # arrays (stops, lobes)
    colour: FloatArray              # of the closures, (stops, lobes, phases, channels)
    turn: float | None              # the azimuth of the first principal axis, radians; None where the fit is isotropic
    sampling: Sampling | None       # None of EEVEE
    error: float                    # share of the reflected light in wrong directions, in the mean over polar angles,
    worst: float                    # and at the worst of them up to 80 degrees
    albedo_error: float             # largest difference at these angles, and between them, in the mean of the channels


class Nodes(NamedTuple):
    """The closure nodes of a fit for each renderer, and the random walk below it, where light enters it."""

    cycles: NodeMixture
    eevee: NodeMixture
    walk: Walk | None = None


def node_mixtures(fit: Reflectance) -> Nodes:
    """The closure nodes of a fit for each renderer."""
    cycles, eevee = _mixtures(fit, CYCLES, EEVEE)
    return Nodes(cycles, eevee, subsurface_walk(fit))


def subsurface_walk(fit: Reflectance) -> Walk | None:
    """The random walk below a fit, None where no light enters it."""
    below = getattr(fit, "edited_subsurface", None)
    return None if below is None else below.walk


def cycles_mixture(fit: Reflectance) -> NodeMixture:
    """That of Cycles alone, which the shader samples."""
    return _mixtures(fit, CYCLES)[0]


def _mixtures(fit: Reflectance, *engines: Engine) -> list[NodeMixture]:
    fit = getattr(fit, "surface", fit)
    turn, stretch = None, 1.0
    if not is_isotropic(fit):
        axes = principal(fit)
        turn, stretch = axes.turn, axes.stretch
    views = tabulate_outgoing(fit, turn, stretch)
    return [_fit_mixture(views, turn, engine) for engine in progress.each(engines)]


def evaluate(mixture: NodeMixture, wo: FloatArray, wi: FloatArray) -> FloatArray:
    """Reflected radiance of the closures, (n, channels), 0 below the horizon: for a viewing direction, (3,), and
    incident ones, (n, 3), unit vectors whose azimuths are from the tangent."""
    theta, phi = np.arccos(np.clip(wo[2], -1, 1)), np.arctan2(wo[1], wo[0])
    turn = phi if mixture.turn is None else mixture.turn
    back = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    pairs = node_lobes.Pairs.make((back @ wo)[None, None], (wi @ back.T)[None, None], np.array([[[1.0, 0.0, 0.0]]]))
    phases = np.ones((1, 1))
    if mixture.colour.shape[2] > 1:
        phases = np.array([[np.cos(phi - turn) ** 2, np.sin(phi - turn) ** 2]])
    at = np.array([theta])
    shape = Shape(*(_interpolate(mixture.theta, at, each) for each in mixture.shape))
    nothing = np.empty((1, 0, 1, len(wi)))
    seen = OutgoingDirections(at, phases, pairs, (wi[:, 2] > 0)[None, None].astype(float), nothing, nothing)
    columns, colour = _columns(seen, mixture.kinds, shape), _interpolate(mixture.theta, at, mixture.colour)
    return np.asarray(_radiance(columns, colour)[0, :, 0].T)


def _fit_mixture(views: OutgoingDirections, turn: float | None, engine: Engine) -> NodeMixture:
    if not engine.anisotropic:
        views = replace(views, azimuthal_basis=np.ones((len(views.azimuthal_basis), 1)))
    few = slice(0, None, len(views.theta) // _CHOICE_VIEWS)
    chosen = _choose(views.select(few, _CHOICE), engine, turn is not None)
    kinds, shape = _shapes(chosen, views.theta[::2], engine)
    # their shapes and colours, at every other angle
    stops = views.select(slice(0, None, 2), slice(None))
    shape = _refine(stops.select(slice(None), _REFINEMENT), kinds, shape, engine)
    everywhere = _columns(views, kinds, Shape(*(_interpolate(stops.theta, views.theta, each) for each in shape)))
    colour = _colours(stops, everywhere[::2])
    colour = colour * _albedo_scales(views, stops.theta, everywhere, colour)
    radiance = _radiance(everywhere, _interpolate(stops.theta, views.theta, colour))
    found = views.reflected_light(radiance)
    mean = np.maximum(views.albedo.mean(axis=-1, keepdims=True), _LEAST_DIVISOR)
    misplaced, shown = views.directional_error(radiance), views.theta <= LAST_SHOWN
    mixture = NodeMixture(kinds, stops.theta, shape, colour, turn, None,
                          float(misplaced.mean()), float(misplaced[shown].max()),
                          float(np.abs((found - views.albedo) / mean)[shown].max()))
    return mixture._replace(sampling=_sampling(views, mixture)) if engine.sampled else mixture


def _sampling(every: OutgoingDirections, mixture: NodeMixture) -> Sampling:
    """How the shader samples a mixture, at the angles that nodes tabulate."""
    views, kinds, shape = every.select(slice(0, None, 2), slice(None)), mixture.kinds, mixture.shape
    everywhere = _columns(every, kinds, Shape(*(_interpolate(mixture.theta, every.theta, each) for each in shape)))
    columns = everywhere[::2]
    below, albedo = _fit_lower_colours(views, columns), views.albedo.mean(axis=1)
    # the weights of all closures are the denoiser's albedo, of which a direction needs a part
    room = np.minimum((1 + _THRIFTLESS) * albedo, np.maximum(albedo, 1)) - LEAST_FOLLOWED * albedo
    weights = below.sum(axis=1).mean(axis=1)
    below *= np.minimum(room / np.maximum(weights, _LEAST_DIVISOR), 1)[:, None, None]
    apart = views.target - _radiance(columns, below)
    left = np.maximum(apart, 0).sum(axis=1)
    carried = left + np.float32(_PREPARED_SHARE) * views.target.sum(axis=1)
    evenly = np.full_like(carried[:, None], 1 / (2 * np.pi))
    densities = np.moveaxis(_evaluate_lobes(node_lobes.pdf, views, kinds, shape), 0, 1)
    together = np.concatenate([densities, evenly], axis=1)
    flat = (len(carried), -1)
    found = selection_probabilities(carried.reshape(flat), together.reshape(*together.shape[:2], -1),
                                    views.solid_angle.reshape(flat))
    share = (views.solid_angle * left).sum(axis=2).mean(axis=1) / views.brightness
    apart = every.target - _radiance(everywhere, _interpolate(mixture.theta, every.theta, below))
    missing, above = (every.reflected_light(np.maximum(each, 0)).mean(axis=1) for each in (apart, -apart))
    balance = 1 - _average_near_knots(above) / np.maximum(_average_near_knots(missing), _LEAST_DIVISOR)
    return Sampling(below, found, np.clip(_PROBABILITY * share, *_PROBABILITIES), albedo, missing[::2],
                    np.maximum(balance, 0))


def _average_near_knots(values: FloatArray) -> FloatArray:
    """Values at stops and half of those between them and the next ones, (views, ...): (stops, ...)."""
    halved = 0.5 * np.pad(values[1::2], ((1, 1), *((0, 0),) * (values.ndim - 1)))
    return np.asarray(values[::2] + halved[:-1] + halved[1:])


def _fit_lower_colours(views: OutgoingDirections, columns: RealArray) -> FloatArray:
    """The colours, (views, lobes, phases, channels), of the least absolute error that counts more above the target."""
    lobes = _Lobes.make(views, columns)
    found = _solve(views, lobes, _absolute_error_weights(views, views.target_rows, _ERROR_FLOOR))
    solid_angle = np.concatenate([views.solid_angle, 0 * views.solid_angle[..., :2]], axis=-1)
    albedo = np.maximum(views.albedo.mean(axis=1), _LEAST_ALBEDO)[..., None].astype(columns.dtype)
    share, floor = solid_angle.reshape(len(columns), 1, -1) / albedo, np.float32(_LAST_FLOOR / np.pi) * albedo
    for _ in range(_BELOW_REWEIGHTINGS):
        weight = np.abs(found.residual)
        weight += floor
        np.divide(share, weight, out=weight)
        weight[found.residual < 0] *= _OVERSHOOT_WEIGHT
        found = _solve(views, lobes, weight, found)
    return found.colour.reshape(len(found.colour), *columns.shape[1:3], -1)


def _interpolate(stops: FloatArray, at: FloatArray, values: RealArray) -> FloatArray:
    """Values that are tabulated at angles, (stops, ...), interpolated linearly: (at, ...)."""
    flat = values.reshape(len(stops), -1)
    found = np.stack([np.interp(at, stops, column) for column in flat.T], axis=-1)
    return found.reshape(len(at), *values.shape[1:])


def _columns(views: OutgoingDirections, kinds: Sequence[Kind], shape: Shape) -> RealArray:
    """The lobes, times the phases of their colours: (views, lobes, phases, azimuths, n)."""
    return _multiply_azimuthal_basis(views, _evaluate_lobes(node_lobes.evaluate, views, kinds, shape))


def _evaluate_lobes(function: Callable[[Kind, Shape, Pairs], RealArray], views: OutgoingDirections,
                    kinds: Sequence[Kind], shape: Shape) -> RealArray:
    """A function of `node_lobes` for each lobe, all those of a kind at once: (..., lobes, views, azimuths, n)."""
    found = None
    for kind in set(kinds):
        numbers = [number for number, each in enumerate(kinds) if each == kind]
        of_kind = Shape(*(each.T[numbers, :, None].astype(views.solid_angle.dtype) for each in shape))
        values = function(kind, of_kind, views.pairs)
        if found is None:
            found = np.empty((*values.shape[:-4], len(kinds), *views.solid_angle.shape), views.solid_angle.dtype)
        found[..., numbers, :, :, :] = values
    assert found is not None
    return found


def _multiply_azimuthal_basis(views: OutgoingDirections, values: RealArray) -> RealArray:
    """Values of lobes times the phases of their colours: (views, lobes, phases, azimuths, n)."""
    phases = views.azimuthal_basis.astype(values.dtype).T[..., None] * (views.solid_angle > 0)[:, None]
    return np.asarray(np.swapaxes(values, 0, 1)[:, :, None] * phases[:, None])


def _weighted_rows(views: OutgoingDirections, columns: RealArray, weight: float = 1.0) -> RealArray:
    """`OutgoingDirections.rows` of lobes whose closures have a weight: (views, lobes * phases, rows)."""
    weights = weight * views.azimuthal_basis.T.astype(columns.dtype)
    rows = views.rows(columns, np.broadcast_to(weights, columns.shape[:-1]))
    return np.asarray(rows.reshape(len(rows), -1, rows.shape[-1]))


def _radiance(columns: RealArray, colour: FloatArray) -> RealArray:
    """The sum of lobes with their colours, (views, lobes, phases, channels): (views, channels, azimuths, n)."""
    flat = columns.reshape(len(columns), -1, columns.shape[3] * columns.shape[4])
    colours = np.swapaxes(colour.reshape(len(colour), -1, colour.shape[-1]), 1, 2).astype(columns.dtype)
    return np.asarray(colours @ flat).reshape(len(flat), -1, *columns.shape[3:])


def _absolute_error_weights(views: OutgoingDirections, left: RealArray, floor: float) -> RealArray:
    """Weights of squared errors, (views, channels, rows), whose sum is the absolute error by importance, with those of
    the albedo: the best approximation of a peak beside the measured one would else be none; and of the weights."""
    azimuths = len(views.azimuthal_basis)
    weight = np.abs(left).reshape(*left.shape[:2], azimuths, -1)
    weight += (floor * views.brightness / (np.pi * left.shape[1]))[:, None, None, None].astype(left.dtype)
    np.divide(views.weight, weight[..., :-2], out=weight[..., :-2])
    weight[..., -2:] = np.array([_FIRMNESS, _THRIFT]) / views.brightness[:, None, None, None] ** 2
    weight /= azimuths
    return weight.reshape(left.shape)


_PAIRS = [np.triu_indices(count) for count in range(16)]


class _Lobes(NamedTuple):
    """Lobes of given shapes, whose colours are sought."""

    columns: RealArray              # (views, columns, rows)
    products: RealArray | None      # (views, pairs, rows), of each pair of columns, where these are few

    @classmethod
    def make(cls, views: OutgoingDirections, columns: RealArray) -> "_Lobes":
        flat = _weighted_rows(views, columns)
        first, second = _PAIRS[flat.shape[1]]
        return cls(flat, flat[:, first] * flat[:, second])

    def normal(self, weight: RealArray) -> FloatArray:
        """The normal equations of weighted squares: (views, channels, columns, columns)."""
        if self.products is None:
            weighted = weight[:, :, None] * self.columns[:, None]
            return np.asarray((weighted @ np.swapaxes(self.columns, 1, 2)[:, None]).astype(float))
        count = self.columns.shape[1]
        pair = np.zeros((count, count), int)
        pair[_PAIRS[count]] = np.arange(self.products.shape[1])
        sums = np.swapaxes(self.products @ np.swapaxes(weight, 1, 2), 1, 2).astype(float)
        return np.asarray(sums[..., np.maximum(pair, pair.T)])


class _Solution(NamedTuple):
    """Colours for given shapes."""

    lobes: _Lobes
    colour: FloatArray          # (views, columns, channels)
    residual: RealArray             # (views, channels, rows)


def _solve(views: OutgoingDirections, lobes: _Lobes, weight: RealArray, like: _Solution | None = None) -> _Solution:
    """The colours, none negative, of the least weighted squares; those that are not 0 are probably those of `like`."""
    target, count = views.target_rows, lobes.columns.shape[1]
    normal = lobes.normal(weight)
    weighted = weight * target
    right = np.swapaxes(lobes.columns @ np.swapaxes(weighted, 1, 2), 1, 2).astype(float)
    albedo = np.maximum(views.albedo.mean(axis=(1, 2)), _LEAST_DIVISOR)[:, None]
    ridge = _RIDGE * np.einsum("vcr,vcr->vc", weighted, target) / albedo ** 2
    normal += (ridge[..., None, None] + _LEAST_DIVISOR) * np.eye(count)
    colour = nonnegative_least_squares(normal, right, None if like is None else np.swapaxes(like.colour, 1, 2) > 0)
    left = target - colour.astype(target.dtype) @ lobes.columns
    return _Solution(lobes, np.swapaxes(colour, 1, 2), left)


def _colours(views: OutgoingDirections, columns: RealArray) -> FloatArray:
    """The colours of the least absolute error, by reweighted least squares: (views, lobes, phases, channels)."""
    lobes = _Lobes.make(views, columns)
    found = _solve(views, lobes, _absolute_error_weights(views, views.target_rows, _ERROR_FLOOR))
    for _ in range(_REWEIGHTINGS):
        found = _solve(views, lobes, _absolute_error_weights(views, found.residual, _LAST_FLOOR), found)
    return found.colour.reshape(len(found.colour), *columns.shape[1:3], -1)


def _candidates(engine: Engine, turned: bool) -> list[_Lobe]:
    """Lobes to choose from: kind, roughness, tilt, anisotropy."""
    roughness, tilts = (_TURNED_ROUGHNESS, _TURNED_TILTS) if turned else (_FACET_WIDTHS, _TILTS)
    anisotropies = _ANISOTROPIES if turned and engine.anisotropic else (0.0,)
    found: list[_Lobe] = [
        (kind, rough, tilt, anisotropy) for kind in FACETS if kind in engine.kinds
        for rough in roughness for tilt in tilts for anisotropy in anisotropies]
    if "sheen" in engine.kinds:
        found += [("sheen", sigma, 0.0, 0.0) for sigma in _SHEEN_ROUGHNESSES]
    if "diffuse" in engine.kinds:
        found += [("diffuse", 1.0, tilt, 0.0) for tilt in _DIFFUSE_TILTS]
    return [each for each in found if engine.normal_offsets[0] <= each[2] <= engine.normal_offsets[1]]


def _least_tilt(theta: FloatArray, engine: Engine) -> FloatArray:
    """The least tilt at polar angles, (views, 1): the viewer must see the normal of the lobe well."""
    cosine = np.cos(theta)
    return np.maximum(engine.normal_offsets[0], -(1 - _TILTED_COSINE) * cosine / np.maximum(1 - cosine, 1e-9))[:, None]


def _shapes(lobes: Sequence[_Lobe], theta: FloatArray, engine: Engine) -> tuple[tuple[Kind, ...], Shape]:
    """Kinds and shapes of candidates, at polar angles."""
    kinds, *numbers = zip(*lobes, strict=True)
    rough, tilt, anisotropy = (np.ones((len(theta), 1)) * np.array(each) for each in numbers)
    least = _least_tilt(theta, engine)
    return kinds, Shape(rough, np.maximum(tilt, np.minimum(least, 0)), anisotropy)


def _choose(views: OutgoingDirections, engine: Engine, turned: bool) -> list[_Lobe]:
    """The lobes, by backward elimination: of all candidates, without those whose absence increases the error least."""
    candidates: list[_Lobe] = [("diffuse", 1.0, 0.0, 0.0), *_candidates(engine, turned)]
    kinds, shapes = _shapes(candidates, views.theta, engine)
    flat = _weighted_rows(views, _columns(views, kinds, shapes))
    columns = flat.reshape(len(flat), len(kinds), -1, flat.shape[-1])
    # begin with all candidates
    chosen = np.arange(len(kinds))
    weight = _absolute_error_weights(views, views.target_rows, _ERROR_FLOOR)
    best, error = chosen, np.inf
    found: _Solution | None = None
    while True:
        few = columns[:, chosen].reshape(len(flat), -1, flat.shape[-1])
        found = _solve(views, _Lobes(few, None), weight, found)
        lobes = len(chosen) - 1
        weight = _absolute_error_weights(views, found.residual, _ERROR_FLOOR / 2)
        # few enough: settle the weights, and keep the set unless one more lobe was worth its error
        if lobes <= engine.lobes:
            for _ in range(_CHOICE_REWEIGHTINGS):
                found = _solve(views, found.lobes, weight, found)
                weight = _absolute_error_weights(views, found.residual, _ERROR_FLOOR / 2)
            now = _squared_error(weight, found) / len(views.theta)
            if lobes == engine.lobes or now <= error + _WORTH * (len(best) - len(chosen)):
                best, error = chosen, now
        if lobes <= 1:
            break
        # eliminate those whose absence increases the error least, many at once while there are many
        worth = _error_growth(found, weight).reshape(len(chosen), -1).sum(axis=1)
        worth[0] = np.inf           # the first diffuse lobe
        fewer = max((lobes - engine.lobes) // 2, 1) if lobes > engine.lobes else 1
        kept = np.sort(np.argsort(worth)[fewer:])
        chosen = chosen[kept]
        colour = found.colour.reshape(len(flat), len(worth), -1, found.colour.shape[-1])[:, kept]
        found = found._replace(colour=colour.reshape(len(flat), -1, colour.shape[-1]))
    return [candidates[number] for number in best]


def _error_growth(found: _Solution, weight: RealArray) -> FloatArray:
    """By how much the weighted squared error grows without each column, (columns,), the others staying positive."""
    colour = np.swapaxes(found.colour, 1, 2)
    used = colour > 0
    normal = np.where(used[..., :, None] & used[..., None, :], found.lobes.normal(weight), 0)
    size = np.einsum("vckk->vck", normal) * _RIDGE + ~used + _LEAST_DIVISOR
    inverse = np.linalg.inv(normal + size[..., None] * np.eye(size.shape[-1]))
    return np.asarray((colour ** 2 / np.einsum("vckk->vck", inverse)).sum(axis=(0, 1)))


class _Variables:
    """The shapes as numbers that the refinement changes, (stops, variables), of all lobes but the first: the logarithm
    of the roughness, the tilt, and minus the logarithm of 1 less the anisotropy's size, with its sign."""

    def __init__(self, kinds: Sequence[Kind], theta: FloatArray, engine: Engine) -> None:
        numbers = range(1, len(kinds))
        facets = [number for number in numbers if kinds[number] in FACETS]
        tilted = [number for number in numbers if kinds[number] != "sheen"]
        rough = [number for number in numbers if kinds[number] != "diffuse"]
        self.places = ([(0, number) for number in rough] + [(1, number) for number in tilted]
                       + ([(2, number) for number in facets] if engine.anisotropic else []))
        sheerest = np.where(np.array(kinds) == "sheen", _SHEEREST, _LEAST_FACET_ROUGHNESS)
        bend = -np.log(1 - _MOST_ANISOTROPIC)
        ones, least = np.ones((len(theta), len(kinds))), _least_tilt(theta, engine)
        self.lower = np.stack([ones * np.log(sheerest), ones * least, -bend * ones])
        self.upper = np.stack([0 * ones, engine.normal_offsets[1] * ones, bend * ones])

    def pack(self, shape: Shape) -> FloatArray:
        bent = -np.sign(shape.anisotropy) * np.log(1 - np.abs(shape.anisotropy))
        return np.stack([np.log(shape.roughness), shape.normal_offset, bent])

    @staticmethod
    def shape(variables: FloatArray) -> Shape:
        rough, tilt, bent = variables
        return Shape(np.exp(rough), tilt, np.sign(bent) * (1 - np.exp(-np.abs(bent))))

    def step_variables(self, variables: FloatArray, step: FloatArray) -> FloatArray:
        """Variables after a step, (stops, variables)."""
        after = variables.copy()
        for number, (kind, lobe) in enumerate(self.places):
            after[kind, :, lobe] += np.clip(step[:, number], -_LONGEST, _LONGEST)
        return np.clip(after, self.lower, self.upper)

    def flatten(self, variables: FloatArray) -> FloatArray:
        """The variables, (stops, variables)."""
        return np.stack([variables[kind, :, lobe] for kind, lobe in self.places], axis=1)


def _refine(views: OutgoingDirections, kinds: tuple[Kind, ...], shape: Shape, engine: Engine) -> Shape:
    """Shapes of the least penalised error, by variable projection with steps of Levenberg and Marquardt."""
    variables = _Variables(kinds, views.theta, engine)
    now = variables.pack(shape)
    bending = np.diff(np.eye(len(views.theta)), n=2, axis=0)
    bending = _STIFFNESS * bending.T @ bending
    found = _solve(views, _Lobes.make(views, _columns(views, kinds, shape)),
                   _absolute_error_weights(views, views.target_rows, _ERROR_FLOOR))
    damping = 1e-2
    for floor in progress.each((_ERROR_FLOOR, _ERROR_FLOOR / 3)):
        for _ in range(_REFINEMENTS):
            weight = _absolute_error_weights(views, found.residual, floor)
            found = _solve(views, found.lobes, weight, found)
            before = _penalised_error(weight, found, bending, variables.flatten(now))
            curvature, slope = _eliminate_colours(views, kinds, variables, now, found, weight)
            for _ in range(_TRIES):
                step = _step(curvature, slope, bending, variables.flatten(now), damping)
                then = variables.step_variables(now, step)
                tried = _solve(views, _Lobes.make(views, _columns(views, kinds, variables.shape(then))), weight, found)
                after = _penalised_error(weight, tried, bending, variables.flatten(then))
                if after < before:
                    now, found, damping = then, tried, max(damping / 3, 1e-4)
                    break
                damping = min(5 * damping, 1e3)
            if before - after < _SETTLED * before:
                break
    return variables.shape(now)


def _penalised_error(weight: RealArray, found: _Solution, bending: FloatArray, variables: FloatArray) -> float:
    return _squared_error(weight, found) + float((variables * (bending @ variables)).sum())


def _squared_error(weight: RealArray, found: _Solution) -> float:
    """The weighted squared error."""
    return float(np.einsum("vcr,vcr,vcr->v", weight, found.residual, found.residual).astype(float).sum())


def _eliminate_colours(views: OutgoingDirections, kinds: tuple[Kind, ...], variables: _Variables, now: FloatArray,
                       found: _Solution, weight: RealArray) -> tuple[FloatArray, FloatArray]:
    """The normal equations of the variables, (views, variables, variables) and (views, variables), alone."""
    columns = found.lobes.columns.shape[1]
    phases, lobes = views.azimuthal_basis.shape[1], [lobe for _, lobe in variables.places]
    # derivatives of the rows by each variable, beside the rows themselves
    changed = sorted(set(lobes))
    gradients = _evaluate_lobes(node_lobes.gradient, views, [kinds[lobe] for lobe in changed],
                                Shape(*(each[:, changed] for each in variables.shape(now))))
    derivatives = gradients[[variable for variable, _ in variables.places], [changed.index(lobe) for lobe in lobes]]
    slopes = _weighted_rows(views, _multiply_azimuthal_basis(views, derivatives), 0.0)
    both = np.concatenate([found.lobes.columns, slopes], axis=1)
    weighted = both[:, None] * weight[:, :, None]
    normal = (weighted @ np.swapaxes(both, 1, 2)[:, None]).astype(float)
    right = weighted @ found.residual[..., None]
    # from derivatives of lobes to those of what is reflected: (views, channels, columns and derivatives, variables)
    colour = np.swapaxes(found.colour, 1, 2)
    coloured = np.zeros((*colour.shape[:2], both.shape[1], columns + len(lobes)))
    coloured[..., :columns, :columns] = np.eye(columns)
    for number, lobe in enumerate(lobes):
        at = slice(columns + number * phases, columns + (number + 1) * phases)
        coloured[..., at, columns + number] = colour[..., lobe * phases:(lobe + 1) * phases]
    transposed = np.swapaxes(coloured, -1, -2)
    normal, right = transposed @ normal @ coloured, (transposed @ right)[..., 0]
    # eliminate the colours that are not 0: the Schur complement of their block
    free = (colour > 0).astype(float)
    inner = normal[..., :columns, :columns] * free[..., None] * free[..., None, :]
    size = np.einsum("vcll->vc", inner)[..., None] / columns + _LEAST_DIVISOR
    inner += np.eye(columns) * (1e-9 * size + (1 - free) * size)[..., None]
    mixed = normal[..., :columns, columns:] * free[..., None]
    gone = np.linalg.solve(inner, mixed)
    curvature = normal[..., columns:, columns:] - np.swapaxes(mixed, -1, -2) @ gone
    slope = right[..., columns:] - (np.swapaxes(gone, -1, -2) @ (right[..., :columns] * free)[..., None])[..., 0]
    return curvature.sum(axis=1), slope.sum(axis=1)


def _step(curvature: FloatArray, slope: FloatArray, bending: FloatArray, variables: FloatArray,
          damping: float) -> FloatArray:
    """A step of Levenberg and Marquardt for all stops at once, (stops, variables)."""
    stops, count = slope.shape
    whole = np.zeros((stops, count, stops, count))
    every = np.arange(stops)
    diagonal = damping * np.einsum("vkk->vk", curvature) + 1e-6
    whole[every, :, every] = curvature + diagonal[:, :, None] * np.eye(count)
    for number in range(count):
        whole[:, number, :, number] += bending
    right = slope - bending @ variables
    return np.asarray(np.linalg.solve(whole.reshape(stops * count, -1), right.ravel()).reshape(stops, count))


def _albedo_scales(views: OutgoingDirections, stops: FloatArray, columns: RealArray, colour: FloatArray) -> FloatArray:
    """Factors of the colours, (stops, 1, phases, channels), that give them the albedo of the fit at all angles."""
    share = _interpolate(stops, views.theta, np.eye(len(stops)))                # (views, stops)
    white = np.einsum("van,vlpan->valp", views.solid_angle, columns)
    reflected = np.einsum("vs,valp,slpc->vaspc", share, white, colour, optimize=True)
    albedo = views.albedo
    mean = np.maximum(albedo.mean(axis=-1, keepdims=True), _LEAST_DIVISOR)
    count, phases, channels = len(stops), colour.shape[2], colour.shape[3]
    scales = np.ones((count, 1, phases, channels))
    for channel in range(channels):
        matrix = (reflected[..., channel] / mean[..., None]).reshape(-1, count * phases)
        wanted = ((albedo[..., channel] / mean[..., 0]) - matrix.sum(axis=1).reshape(albedo.shape[:2])).ravel()
        firm = 1e-3 * np.eye(count * phases)
        change = np.linalg.lstsq(np.concatenate([matrix, firm]), np.concatenate([wanted, 0 * firm[0]]), rcond=None)[0]
        scales[:, 0, :, channel] = np.clip(1 + change, *_SCALES).reshape(count, phases)
    return scales
