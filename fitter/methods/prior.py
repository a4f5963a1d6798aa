"""Fitting a model of lobes to samples: the prior of `regression_kriging` (docs/fitting.md, step 3).

The model adds what the samples alone do not tell: the height of a peak that no sample hit, and the growth of a lobe
toward grazing incidence. Lobes are added one by one, each time the one that helps most.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import itemgetter

import numpy as np

from ..arrays import FloatArray
from ..least_squares import damped_step, levenberg_marquardt
from ..model.microfacet import (
    NARROWEST,
    NO_GAMMA,
    STEEPEST_TAIL,
    Geometry,
    Kind,
    Microfacet,
    SurfaceComponents,
    geometry,
    lobe,
    lobe_with_slopes,
    surface_components,
)
from ..model.transform import bounded_log
from ..samples import Samples

_STARTS: tuple[tuple[Kind, float, float], ...] = (     # kind, alpha and f0 of a lobe that is added
    ("mirror", 0.01, 0.08), ("mirror", 0.03, 0.08), ("mirror", 0.12, 0.08), ("mirror", 0.4, 0.08),
    ("retro", 0.05, 0.9), ("retro", 0.3, 0.9), ("sheen", 1.0, 0.9))
_ANISOTROPIC_STARTS: tuple[tuple[Kind, float, float], ...] = (("fibre", 0.15, 0.9),)
_MOST = 3                   # lobes
_DIP = 0.1                  # at which fibres start
_NARROWEST_FIBRE = 0.02     # narrower ones are what noise looks like between samples at a few rotations
_PARAMETERS = 3             # of a lobe's shape
_ANISOTROPIC_PARAMETERS = 5     # of an anisotropic lobe's shape
_START_AZIMUTHS = np.radians((0, 45, 90, 135))  # at which lobes start to have two widths
_ASPECT = 3.0                           # the ratio of these widths
WEIGHT = 1 / 3              # errors of the logarithm weigh (f + offset) to this power, in all steps: they then count
                            # as much as those of the cube root of f, by which fits are judged
_FIRST_ITERATIONS, _PROMISING = 8, 2     # from every start, and how many starts are followed further
_PRIOR_ITERATIONS = 40
_CLIP = 25.0                # bound of every parameter of the search: logarithms, and logits of F0
_REGULARISATION = 1e-2                # of every parameter toward its start: holds what the samples do not determine
_COLOURLESS = 0.1           # of a lobe's strengths toward their mean: no channel loses a lobe that the others have


def lambertian(values: FloatArray) -> Microfacet:
    """The model without lobes: the median of each channel of values (n, channels), 1/sr."""
    kd = np.maximum(np.median(values, axis=0), 0)
    return Microfacet(kd, np.zeros((0, len(kd))), np.zeros(0), np.zeros(0), np.zeros(0))


def parameter_count(model: Microfacet) -> int:
    """The number of parameters of a model, over all channels."""
    return model.kd.size + model.ks.size + sum(map(len, model.shapes))


def candidates(samples: Samples, typical: FloatArray, offset: float) -> list[Microfacet]:
    """The Lambertian of typical values, (m, channels), 1/sr, and the least-squares fits of log(f + offset), the offset
    positive, 1/sr, with one lobe, two lobes, and so on, up to as many parameters as a quarter of the values."""
    models = [lambertian(typical)]
    if not np.ptp(samples.values):
        return models
    problem = _Problem(geometry(*samples.directions), samples.values / offset,
                       None if samples.isotropic else surface_components(*samples.directions))
    current = replace(models[0], kd=np.maximum(np.quantile(problem.values, 0.3, axis=0), 1e-4))
    for _ in range(_MOST):
        starts = _STARTS if problem.surface_components is None else (*_STARTS, *_ANISOTROPIC_STARTS)
        larger = [model for start in starts for model in _add_lobe(current, problem, *start)]
        if parameter_count(larger[0]) > samples.values.size / 4:
            break
        best = problem.best_model(larger)
        if problem.surface_components is not None and best[0].kinds[-1] == "mirror":
            best = min(best, problem.best_model(_elongate(best[0])), key=itemgetter(1))
        current = best[0]
        models.append(replace(current, kd=current.kd * offset, ks=current.ks * offset))
    return models


def _add_lobe(model: Microfacet, problem: "_Problem", kind: Kind, alpha: float, f0: float) -> list[Microfacet]:
    """Models with another lobe, as strong as the model falls short where it is brightest; fibres along azimuths."""
    models = []
    for turn in _START_AZIMUTHS if kind == "fibre" else (0.0,):
        across = _DIP if kind == "fibre" else alpha
        shape = lobe(kind, problem.at, problem.surface_components, alpha, NO_GAMMA, f0, across, turn)
        brightest = np.argsort(shape)[-max(3, len(shape) // 100):]
        value = model.evaluate_geometry(problem.at, problem.surface_components)
        lacking = np.maximum(problem.values - value, 0)[brightest]
        strength = (lacking * shape[brightest, None]).sum(axis=0) / max((shape[brightest] ** 2).sum(), 1e-300)
        larger = Microfacet(model.kd, np.concatenate([model.ks, [np.maximum(strength, 1e-3 * model.kd)]]),
                            np.append(model.alpha, alpha), np.append(model.gamma, NO_GAMMA), np.append(model.f0, f0),
                            (*model.kinds, kind))
        if problem.surface_components is not None:
            larger = replace(larger, across=np.append(model.across, across), turn=np.append(model.turn, turn))
        models.append(larger)
    return models


def _elongate(model: Microfacet) -> list[Microfacet]:
    """A model whose last lobe, a mirror, has two widths, along several azimuths."""
    mean = np.sqrt(model.alpha[-1] * model.across[-1])
    return [replace(model, alpha=np.append(model.alpha[:-1], mean / np.sqrt(_ASPECT)),
                    across=np.append(model.across[:-1], mean * np.sqrt(_ASPECT)), turn=np.append(model.turn[:-1], turn))
            for turn in _START_AZIMUTHS]


@dataclass(frozen=True)
class _Problem:
    """The least-squares problem of samples: geometry, and values (n, channels) in units of the offset.

    The parameters of the search are, for each lobe, log alpha, log(gamma - 1) and the logit of f0, and for an
    anisotropic material log across and the turn; then the logarithms of the strengths of all lobes; then those of kd.
    """

    at: Geometry
    values: FloatArray
    surface_components: SurfaceComponents | None = None

    def best_model(self, starts: list[Microfacet]) -> tuple[Microfacet, float]:
        """The best model near several starts, and its sum of squares."""
        found = sorted((self.minimise(start, _FIRST_ITERATIONS) for start in starts), key=itemgetter(1))
        return min((self.minimise(model, _PRIOR_ITERATIONS) for model, _ in found[:_PROMISING]), key=itemgetter(1))

    def minimise(self, start: Microfacet, iterations: int) -> tuple[Microfacet, float]:
        """The model of the least regularised squares near a start, and its sum of squares."""
        channels, kinds = self.values.shape[1], start.kinds
        count = _PARAMETERS if self.surface_components is None else _ANISOTROPIC_PARAMETERS
        target = bounded_log(self.values, 1.0)
        weight = (np.maximum(self.values.mean(axis=1), 0) + 1) ** WEIGHT
        weight /= np.sqrt(np.mean(weight ** 2))
        shapes = count * len(kinds)
        first = _pack(start)
        pull, bounds = _regularisation_forms(len(kinds), count, channels), _bounds(kinds, count, channels)

        def cost(residual: FloatArray, p: FloatArray) -> float:
            return float((residual ** 2).sum() + (p - first) @ pull[0] @ (p - first) + p @ pull[1] @ p)

        def residuals_at(p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
            strength = np.exp(np.clip(p[shapes:], -_CLIP, _CLIP)).reshape(len(kinds) + 1, channels)
            lobes = [self._shape(kind, p[count * k:count * (k + 1)]) for k, kind in enumerate(kinds)]
            parts = np.stack([*(value for value, _ in lobes), np.ones(len(target))])
            slopes = np.concatenate([each for _, each in lobes]) if lobes else parts[:0]
            total = strength.T @ parts + 1
            return (np.log(total) - target.T) * weight, weight / total, np.concatenate([slopes, parts]), strength

        def evaluate(p: FloatArray) -> tuple[float, tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
            there = residuals_at(p)
            return cost(there[0], p), there

        def linearise(p: FloatArray, there: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
                      ) -> Callable[[float], FloatArray]:
            residual, scale, columns, strength = there
            normal, slope = pull[0] + pull[1], pull[0] @ (p - first) + pull[1] @ p
            of_lobes = np.repeat(strength[:-1], count, axis=0)
            for channel in range(channels):
                # by the slopes of all lobes, and by the strengths of this channel
                mine = np.concatenate([np.arange(shapes), np.arange(shapes + channel, len(p), channels)])
                factor = np.concatenate([of_lobes[:, channel], strength[:, channel]])
                jacobian = columns * scale[channel]
                normal[mine[:, None], mine] += jacobian @ jacobian.T * factor[:, None] * factor
                slope[mine] += jacobian @ residual[channel] * factor
            return lambda damping: np.clip(p - damped_step(normal, slope, damping), *bounds)

        p, _, (residual, *_) = levenberg_marquardt(first, evaluate, linearise, steps=iterations, tries=8, grow=4,
                                                   shrink=4, enough=1e-6)
        return _unpack(p, kinds, count, channels), float((residual ** 2).sum())

    def _shape(self, kind: Kind, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """A lobe, (n,), and its derivatives by its parameters of the search, (parameters, n)."""
        alpha, gamma, f0, *rest = _numbers(p, kind)
        value, slopes = lobe_with_slopes(kind, self.at, self.surface_components, alpha, gamma, f0, *rest)
        derivatives = np.array(slopes())
        by_parameter = np.array([1.0, gamma - 1, f0 * (1 - f0), 1.0, 1.0])[:len(derivatives), None]
        return value, by_parameter * derivatives


def _regularisation_forms(lobes: int, shape: int, channels: int) -> tuple[FloatArray, FloatArray]:
    """The quadratic forms that pull all parameters toward their start, and a lobe's strengths toward their mean."""
    count = shape * lobes + channels * (lobes + 1)
    apart = np.eye(channels) - 1 / channels
    colour = np.zeros((count, count))
    for k in range(lobes):
        at = slice(shape * lobes + k * channels, shape * lobes + (k + 1) * channels)
        colour[at, at] = _COLOURLESS ** 2 * apart
    return _REGULARISATION ** 2 * np.eye(count), colour


def _bounds(kinds: tuple[Kind, ...], shape: int, channels: int) -> FloatArray:
    """The least and the largest of all parameters: (2, parameters). Within them each has a slope."""
    bounds = np.full((2, shape * len(kinds) + channels * (len(kinds) + 1)), _CLIP)
    bounds[0] *= -1
    for k, kind in enumerate(kinds):
        for place in (0, 1, 3) if shape == _ANISOTROPIC_PARAMETERS else (0, 1):         # the widths, and the tail
            bounds[:, shape * k + place] = np.log([NARROWEST, STEEPEST_TAIL])
        if kind == "fibre":
            bounds[0, shape * k] = np.log(_NARROWEST_FIBRE)
    return bounds


def _numbers(p: FloatArray, kind: Kind) -> tuple[float, ...]:
    """alpha, gamma and f0 of the parameters of a lobe, and across and turn of an anisotropic one."""
    p = np.clip(p, -_CLIP, _CLIP)
    alpha, tail, across = np.clip(np.exp([*p[:2], p[-2]]), NARROWEST, STEEPEST_TAIL).tolist()
    alpha = max(alpha, _NARROWEST_FIBRE) if kind == "fibre" else alpha
    numbers = alpha, 1 + tail, float(1 / (1 + np.exp(-p[2])))
    return numbers if len(p) == _PARAMETERS else (*numbers, across, float((p[-1] + np.pi) % (2 * np.pi) - np.pi))


def _pack(model: Microfacet) -> FloatArray:
    """The parameters of the search."""
    f0 = np.clip(model.f0, 1e-9, 1 - 1e-9)
    shapes = [np.log(model.alpha), np.log(model.gamma - 1), np.log(f0 / (1 - f0))]
    if len(model.across):
        shapes += [np.log(model.across), model.turn]
    strengths = np.concatenate([model.ks.ravel(), model.kd])
    return np.concatenate([np.stack(shapes, axis=1).ravel(), np.log(np.maximum(strengths, 1e-9))])


def _unpack(p: FloatArray, kinds: tuple[Kind, ...], count: int, channels: int) -> Microfacet:
    """The model of parameters of the search."""
    shapes = count * len(kinds)
    numbers = np.array([_numbers(each, kind) for each, kind in zip(p[:shapes].reshape(-1, count), kinds, strict=True)])
    numbers = numbers.reshape(-1, count)
    strength = np.exp(np.clip(p[shapes:], -_CLIP, _CLIP)).reshape(-1, channels)
    alpha, gamma = numbers[:, 0], np.where([kind == "sheen" for kind in kinds], NO_GAMMA, numbers[:, 1])
    model = Microfacet(strength[-1], strength[:-1], alpha, gamma, numbers[:, 2], kinds)
    if count == _PARAMETERS:
        return model
    turned = [kind in ("mirror", "fibre") for kind in kinds]
    return replace(model, across=np.where(turned, numbers[:, 3], alpha), turn=np.where(turned, numbers[:, 4], 0.0))
