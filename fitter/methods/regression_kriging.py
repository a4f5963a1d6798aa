"""Regression kriging: a model of lobes, a Gaussian process of its residuals, and splines that store the result.

In geostatistics, regression kriging is a regression whose residuals are interpolated by a Gaussian process (T. Hengl,
G. B. M. Heuvelink, D. G. Rossiter: About regression-kriging, Computers & Geosciences 33(10), 2007). Here it has five
steps:

1. Fit priors of none to three lobes to the samples (`prior`).
2. In each of two systems of coordinates, choose the prior and the kernel under which the samples are likeliest, and
   interpolate the field of `LogRelative`, the samples' log-ratio to the prior, by a Gaussian process
   (`gaussian_process`). Beside these two experts, a thin-plate spline of the samples' logarithm (`thin_plate`) assumes
   neither lobes nor a length. Take the mean of the three whose weights predict left-out samples best.
3. Interpolate that field by the dense lattice, which so has values where there are no samples.
4. Fit the sparse lattice to what the dense one lacks, at the samples and at directions between them, by weighted least
   squares (`lattice.least_squares`).
5. Where the fit reflects more light than it receives, lower the field (`energy`).
"""

import itertools
import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from .. import progress
from ..arrays import BoolArray, Directions, FloatArray, IntArray
from ..coordinates.half_difference import SOFTENING, HalfDifference
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..lattice import dense, least_squares
from ..lattice.dense import DenseLattice
from ..lattice.sparse import SparseLattice
from ..model.fit import Fit
from ..model.transform import LEAST_OFFSET, LogRelative, bounded_log
from ..quality import cross_validation
from ..samples import Samples, subset
from . import energy, gaussian_process, many_samples, prior, thin_plate
from .levels import Levels
from .many_samples import Arrangement

_SYSTEMS: tuple[type[HalfDifference | Rusinkiewicz], ...] = (HalfDifference, Rusinkiewicz)
CEILING = 4.0               # a fit is at most 4 times the largest sample
_DROPOUT_NOISE = 10.0       # variance, relative to the field's: a dropout hardly influences the field
_MOST_DROPOUTS = 0.01       # of the samples: of more, the lobes are wrong and not the samples
_SEARCHED = 450             # samples of which the likelihood is computed
_PENALTY = 3.0              # of the log-likelihood, for each parameter of a prior
_STEPS = 4                  # of the weights of the experts
_OFFSET_OF_SPLINE = 0.1     # of the thin-plate spline's logarithm, relative to that of the others
_LARGEST_LOG = 80.0         # beyond any reflectance
_FARTHEST_APART = math.log(4)   # by which another expert can differ from the first: between far samples of a narrow
                                # peak a spline has no bounds
_CHUNK = 1024               # points at a time: bounds the memory
_TYPICAL = 200              # samples, far from each other, whose median is the offset
_REACH = 0.15               # from the nearest sample, in coordinates from -1 to 1, in which the spline is trusted
_AZIMUTHS = 16              # averaged over at exact retro-reflection
_ROUNDS = 3                 # of weighted least squares
_BETWEEN = 3000             # directions between the samples at which the sparse lattice follows the field
_NOISY = 1e-3               # noise from which on the fit follows the field at the samples, and not their values
_BETWEEN_WEIGHT = 200.0     # of all these directions, in samples; at most a share of that of all samples
_BETWEEN_SHARE = 0.05
_WEIGHT = 0.5               # errors of the field weigh (f + offset) to this power: 1 would minimise those of f, 1/3
                            # those of its cube root
_FEW = 500                  # samples, up to which their left-out errors alone do not decide between experts ...
_SPLINES_SHARE = 0.5        # ... but the spline has at least this weight ...
_FAR_WORSE = 4.0            # ... unless its error is as many times larger


class Expert(Protocol):
    """A prediction of the reflectance."""

    def log_value(self, directions: Directions) -> FloatArray:
        """log(f + offset) at directions (n,): (n, channels)."""
        ...


@dataclass(frozen=True)
class Kriged:
    """A prior and the interpolated field above it, in one system of coordinates."""

    coordinates: HalfDifference | Rusinkiewicz
    transform: LogRelative
    field: gaussian_process.Field

    def log_prior(self, directions: Directions) -> FloatArray:
        """log(prior + offset) at directions (n,): (n, channels)."""
        return np.asarray(np.log(self.transform.prior.evaluate(*directions) + self.transform.offset))

    def log_value(self, directions: Directions) -> FloatArray:
        """log(f + offset) at directions (n,): (n, channels)."""
        return self.field.at(2 * self.coordinates.encode(*directions) - 1) + self.log_prior(directions)


@dataclass(frozen=True)
class Smoothed:
    """A thin-plate spline of log(f + own_offset), in half and difference coordinates without a stretch."""

    coordinates: HalfDifference
    spline: thin_plate.Spline
    own_offset: float
    offset: float

    def log_value(self, directions: Directions) -> FloatArray:
        """log(f + offset) at directions (n,): (n, channels)."""
        return self.converted(self.spline.at(2 * self.coordinates.encode(*directions) - 1))

    def converted(self, field: FloatArray) -> FloatArray:
        """log(f + offset), given log(f + own_offset)."""
        return np.asarray(np.log(np.exp(np.minimum(field, _LARGEST_LOG)) + (self.offset - self.own_offset)))


class Estimate:
    """The prior and the interpolated field of samples: most of the work, which fits of several levels share.

    Of the experts that are Gaussian processes, the one that predicts each sample best from the others gives prior and
    coordinates; the field is that of the mean of all experts whose weights predict best.

    Parameters
    ----------
    samples : Samples
    softening : float
        The softening radius delta of the coordinates.

    Attributes
    ----------
    transform : LogRelative
    coordinates : HalfDifference or Rusinkiewicz
    at_samples : (n, channels) float64, or None
        The field at the samples, without the noise of those that have much; None if none has.
    left_out : (n, channels) float64
        Each sample as the others predict it, 1/sr; the prior was fitted to all of them.
    """

    def __init__(self, samples: Samples, softening: float = SOFTENING) -> None:
        offset = _offset(samples)
        ceiling = _ceiling(samples, offset)
        with progress.part(0.0, 0.15, "Fitting lobes"):
            transforms = [LogRelative(model, offset, ceiling) for model in prior.candidates(samples, offset)]
        richest = transforms[-1].prior
        noise, lost = _known_noise(samples, transforms[-1]), np.zeros(len(samples), bool)
        if richest.kinds:
            lost = _dropouts(samples.values, richest.evaluate(*samples.directions))
            noise[lost] = _DROPOUT_NOISE
        judge = _Judge(samples, transforms[0], ~lost)
        some = gaussian_process.choice(len(samples), _SEARCHED)
        searched = subset(samples, some)
        fields = [transform.field(searched.values, *searched.directions) for transform in transforms]
        penalties = [_PENALTY * prior.parameter_count(each.prior) / searched.values.size for each in transforms]
        kernel, kriged = gaussian_process.Kernel(), []
        for begin, system in zip((0.15, 0.5), _SYSTEMS, strict=True):
            def encode(stretch: float, system: type[HalfDifference | Rusinkiewicz] = system) -> FloatArray:
                return 2 * system(softening, stretch).encode(*searched.directions) - 1

            with progress.part(begin, begin + 0.25, "Choosing a model"):
                _, kernel, number = gaussian_process.Search(encode, fields, penalties, noise[some]).best(kernel)
            progress.report(begin + 0.25, "Interpolating the samples")
            coordinates, transform = system(softening, kernel.stretch), transforms[number]
            field, left_out = gaussian_process.krige(
                2 * coordinates.encode(*samples.directions) - 1, transform.field(samples.values, *samples.directions),
                kernel, kernel.noise + noise)
            expert = Kriged(coordinates, transform, field)
            kriged.append((expert, left_out + expert.log_prior(samples.directions)))
        kriged.sort(key=lambda each: judge.error(each[1]))
        with progress.part(0.85, 1.0, "Bending a thin plate"):
            smoothed = _smoothed(samples, judge, some, noise, softening)
        found: list[tuple[Expert, FloatArray]] = [*kriged, smoothed]
        self._own = kriged[0][0]
        weights = judge.weights([left_out for _, left_out in found], _least_share(judge, found))
        self.left_out = judge.values(sum((weight * one for weight, (_, one) in zip(weights, found, strict=True)),
                                         np.zeros(1)))
        self._others = [(weight, expert) for weight, (expert, _) in zip(weights[1:], found[1:], strict=True) if weight]
        self._places = 2 * HalfDifference().encode(*samples.directions) - 1
        self._farthest = max(samples.theta_i.max(), samples.theta_o.max())
        self.coordinates, self.transform = self._own.coordinates, self._own.transform
        noisy = self._own.field.kernel.noise + np.where(lost, 0, noise) >= _NOISY
        self.at_samples = None
        if noisy.any():
            self.at_samples = np.where(noisy[:, None], self.field_at(samples.directions),
                                       self.transform.field(samples.values, *samples.directions))
        self._at_nodes: dict[int, FloatArray] = {}

    def field_at(self, directions: Directions) -> FloatArray:
        """The field at directions (n,): (n, channels)."""
        return self._blended(self._own.field.at(2 * self.coordinates.encode(*directions) - 1), directions)

    def at_nodes(self, level: int) -> FloatArray:
        """The field at the nodes of the dense lattice of a level: (a, b, c, channels) float64."""
        if level not in self._at_nodes:
            nodes = dense.nodes(level)
            mu = 2 * nodes.reshape(-1, 3) - 1
            values = self._blended(self._own.field.at(mu), self.coordinates.decode((mu + 1) / 2))
            values = values.reshape(*nodes.shape[:-1], -1)
            if level > 0:
                values[0] = self._azimuthal_mean(2 * nodes[0] - 1)
            self._at_nodes[level] = values
        return self._at_nodes[level]

    def _blended(self, own: FloatArray, directions: Directions) -> FloatArray:
        """The mean of the experts, given the field of the first; beyond the samples they differ as at the last."""
        if not self._others:
            return own
        theta_i, phi_i, theta_o, phi_o = directions
        near = (np.minimum(theta_i, self._farthest), phi_i, np.minimum(theta_o, self._farthest), phi_o)
        log_value = self._own.log_value(near)
        difference = sum(weight * _FARTHEST_APART * np.tanh((other.log_value(near) - log_value) / _FARTHEST_APART)
                         for weight, other in self._others)
        return np.asarray(own + self._trust(near)[:, None] * difference)

    def _trust(self, directions: Directions) -> FloatArray:
        """How far the others are trusted at directions (n,): 1 near samples or their reciprocals, elsewhere less."""
        mu = 2 * HalfDifference().encode(*directions) - 1
        distance = np.sqrt(np.minimum(_nearest(mu, self._places), _nearest(mu * [1, -1, 1], self._places)))
        return np.asarray(np.exp(-np.maximum(distance / _REACH - 1, 0) ** 2))

    def _azimuthal_mean(self, mu: FloatArray) -> FloatArray:
        """The mean of the field over all azimuths of the half vector: (b, c, 3) to (b, c, channels).

        For the nodes at d = 0, which no pair of directions reaches. They only influence how the fit interpolates
        between samples near retro-reflection; equal values at all azimuths keep it from oscillating there.
        """
        radius, which = np.unique(np.round(np.hypot(mu[..., 1], mu[..., 2]), 9), return_inverse=True)
        angle = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / 2 / _AZIMUTHS)  # a quarter turn: the field is even in x and y
        ring = np.stack([np.zeros((len(radius), _AZIMUTHS)), np.outer(radius, np.cos(angle)),
                         np.outer(radius, np.sin(angle))], axis=-1).reshape(-1, 3)
        values = self._blended(self._own.field.at(ring), self.coordinates.decode((ring + 1) / 2))
        mean = values.reshape(len(radius), _AZIMUTHS, -1).mean(axis=1)
        return np.asarray(mean[which.reshape(mu.shape[:-1])])


@dataclass(frozen=True)
class _Judge:
    """Judges predictions of left-out samples by the error of the cube root of cosine-weighted values.

    Attributes
    ----------
    samples : Samples
    transform : LogRelative
        Its offset is that of the predictions, log(f + offset), and its ceiling bounds them.
    counted : (n,) bool
        The samples that are believed.
    """

    samples: Samples
    transform: LogRelative
    counted: BoolArray

    def error(self, log_value: FloatArray) -> float:
        """The mean square of the errors of predictions (n, channels)."""
        cubes = cross_validation.cube_root(self.samples.theta_o, self.values(log_value))
        return float(np.mean((cubes - self._measured)[self.counted] ** 2))

    def values(self, log_value: FloatArray) -> FloatArray:
        """Predictions (n, channels) as reflectance, 1/sr."""
        offset, ceiling = self.transform.offset, self.transform.ceiling
        return np.asarray(np.clip(np.exp(np.minimum(log_value, _LARGEST_LOG)) - offset, 0, ceiling))

    def weights(self, predictions: list[FloatArray], least: float) -> tuple[float, ...]:
        """The weights whose mean of the predictions has the least error: multiples of 1 / `_STEPS`.

        The last is not smaller than `least`.
        """
        steps = [each for each in itertools.product(range(_STEPS + 1), repeat=len(predictions))
                 if sum(each) == _STEPS and each[-1] >= least * _STEPS]
        best = min(steps, key=lambda each: self.error(
            sum((step / _STEPS * one for step, one in zip(each, predictions, strict=True)), np.zeros(1))))
        return tuple(step / _STEPS for step in best)

    @cached_property
    def _measured(self) -> FloatArray:
        return cross_validation.cube_root(self.samples.theta_o, self.samples.values)


def _nearest(points: FloatArray, places: FloatArray) -> FloatArray:
    """The squared distance of each point to the nearest of some places: (n, 3) and (m, 3) to (n,)."""
    return np.concatenate([gaussian_process.squared_distance(points[start:start + _CHUNK], places).min(axis=1)
                           for start in range(0, len(points), _CHUNK)])


def _least_share(judge: _Judge, found: list[tuple[Expert, FloatArray]]) -> float:
    """The least weight of the spline, the last expert.

    Of few samples each is far from the others, and a peak may be one sample alone. Left-out errors hardly tell then how
    well an expert continues what it has seen; lobes and kernels of greatest likelihood overdo it more than a spline.
    """
    kriged, spline = judge.error(found[0][1]), judge.error(found[-1][1])
    trusted = len(judge.samples) <= _FEW and spline < _FAR_WORSE ** 2 * kriged
    return _SPLINES_SHARE if trusted else 0.0


def _smoothed(used: Samples, judge: _Judge, some: IntArray, noise: FloatArray, softening: float,
              ) -> tuple[Smoothed, FloatArray]:
    """The expert that is a thin-plate spline, and its predictions of left-out samples.

    Its smoothing is the one that predicts best of some of the samples.
    """
    offset = judge.transform.offset
    own_offset = max(_OFFSET_OF_SPLINE * offset, LEAST_OFFSET)
    coordinates = HalfDifference(softening)
    mu, z = 2 * coordinates.encode(*used.directions) - 1, bounded_log(used.values, own_offset)
    part = _Judge(subset(used, some), judge.transform, judge.counted[some])

    def fitted(at: IntArray, smoothing: float) -> tuple[Smoothed, FloatArray]:
        spline, left_out = thin_plate.fit(mu[at], z[at], smoothing, noise[at])
        expert = Smoothed(coordinates, spline, own_offset, offset)
        return expert, expert.converted(left_out)

    errors = {smoothing: part.error(fitted(some, smoothing)[1]) for smoothing in progress.each(thin_plate.SMOOTHINGS)}
    smoothing = min(errors, key=lambda each: errors[each])
    return fitted(np.arange(len(used)), smoothing)


def prepare(samples: Samples) -> dict[str, Estimate | Arrangement]:
    """The options of `fit` that do not depend on the levels."""
    if samples.isotropic and len(samples) <= gaussian_process.MOST_SAMPLES:
        return {"estimated": Estimate(samples)}
    offset = _offset(subset(samples, gaussian_process.choice(len(samples))), float(np.abs(samples.values).max()))
    return {"estimated": many_samples.arranged(samples, offset, _ceiling(samples, offset))}


def fit(samples: Samples, levels: Levels, plausible: bool = True,
        estimated: Estimate | Arrangement | None = None) -> Fit:
    """Fit samples by regression kriging; many samples, and anisotropic ones, by `many_samples`.

    Parameters
    ----------
    samples : Samples
    levels : Levels
        For anisotropic samples, `Levels.of_four_axes` of them.
    plausible : bool
        Make the fit nowhere negative, with a directional albedo of at most 1. `Fit.changes` says what that changed.
    estimated : Estimate or Arrangement, optional
        What `prepare` returned for these samples.

    Returns
    -------
    Fit

    Examples
    --------
    A single measurement says nothing of other directions, so the fit is a Lambertian:

    >>> one = Samples([0.5], [0], [0.5], [0], [[0.2]])
    >>> float(fit(one, Levels(2, 3, 99.0)).evaluate(0, 0, 1.2, 2)[0])
    0.2
    """
    if estimated is None:
        with progress.part(0.0, 0.6):
            estimated = prepare(samples)["estimated"]
        with progress.part(0.6, 1.0):
            return fit(samples, levels, plausible, estimated)
    found = estimated
    transform = replace(found.transform, floor=0.0) if plausible else found.transform
    if isinstance(found, Arrangement):
        levels = levels if samples.isotropic else levels.of_four_axes()
        with progress.part(0.0, 0.95 if samples.isotropic else 0.55):
            diffuse, specular = many_samples.lattices(samples, found, levels)
    else:
        progress.report(0.0, "Fitting the dense lattice")
        control_points = dense.interpolate(found.at_nodes(levels.diffuse), levels.diffuse)
        diffuse, specular = DenseLattice(levels.diffuse, control_points.astype(np.float32)), None
        if levels.specular is not None:
            with progress.part(0.3, 0.9, "Fitting the sparse lattice"):
                specular = _specular(samples, found, transform, diffuse, levels.specular, levels.kept)
    fitted = Fit(found.coordinates, diffuse, specular, transform, levels.dropped, samples.channels, name=samples.name,
                 source=samples.source)
    with progress.part(0.95 if samples.isotropic else 0.55, 1.0, "Checking the energy"):
        return energy.conserved(fitted, transform, samples) if plausible else fitted


def _specular(samples: Samples, estimated: Estimate, transform: LogRelative, diffuse: DenseLattice, level: int,
              kept: int) -> SparseLattice:
    """Fit the sparse lattice to what the dense one lacks, at the samples and between them."""
    between = _between(samples)
    x = [estimated.coordinates.encode(*directions) for directions in (samples.directions, between)]
    at_samples = estimated.at_samples
    if at_samples is None:
        at_samples = transform.field(samples.values, *samples.directions)
    field = np.concatenate([at_samples, estimated.field_at(between)])
    directions = [np.concatenate(pair) for pair in zip(samples.directions, between, strict=True)]
    share = min(_BETWEEN_WEIGHT, _BETWEEN_SHARE * len(samples)) / len(x[1])
    trust = np.concatenate([np.ones(len(samples)), np.full(len(x[1]), np.sqrt(share))])
    x_all = np.concatenate(x)
    coarse = diffuse.evaluate(x_all)
    residual = field - coarse
    bright = np.maximum(transform.reflectance(field, *directions), 0)
    for _ in progress.each(range(_ROUNDS)):
        # an error of the field causes one of the reflectance in proportion to f + offset; f is the larger of the
        # measured and the fitted value, so that no dark sample is fitted too bright
        weights = trust * np.mean(bright + transform.offset, axis=1) ** _WEIGHT
        specular = least_squares.sparse_fit(x_all, residual, weights, level, kept)
        fitted = transform.reflectance(coarse + specular.evaluate(x_all), *directions)
        bright = np.maximum(bright, fitted)
    return specular


def _between(samples: Samples) -> Directions:
    """Random directions at which the field is followed, half of them near the mirror direction: four (n,) arrays.

    They reach as far as the samples do.
    """
    rng = np.random.default_rng(0)
    farthest = max(samples.theta_i.max(), samples.theta_o.max())
    theta_i, theta_o = farthest * np.sqrt(rng.random((2, _BETWEEN)))
    turn = np.pi * rng.random(_BETWEEN)
    near = slice(0, _BETWEEN // 2)
    # offsets from the mirror direction, in the plane of incidence and across it: from 0.1 to 30 degrees, evenly in the
    # logarithm
    size = np.radians(30) * 10 ** (-2.5 * rng.random(_BETWEEN // 2))
    angle = 2 * np.pi * rng.random(_BETWEEN // 2)
    theta_o[near] = np.clip(theta_i[near] + size * np.cos(angle), 0, farthest)
    turn[near] = np.pi - np.minimum(np.abs(size * np.sin(angle)) / np.maximum(np.sin(theta_i[near]), 0.1), np.pi)
    return theta_i, np.zeros(_BETWEEN), theta_o, turn


def _known_noise(samples: Samples, transform: LogRelative) -> FloatArray:
    """The variance of each sample's noise, as far as repeated measurements tell it, relative to the field's: (n,)."""
    if samples.deviation is None:
        return np.zeros(len(samples))
    field = transform.field(samples.values, *samples.directions)
    bright = np.abs(samples.values).mean(axis=1)
    in_field = samples.deviation * bright / (bright + transform.offset)
    return np.asarray(in_field ** 2 / max(np.mean(field ** 2), np.finfo(float).tiny))


def _dropouts(values: FloatArray, lobes: FloatArray) -> BoolArray:
    """The few samples that are nearly 0 where the lobes are bright, as if the detector had failed: (n,) bool."""
    median = np.median(np.abs(values))
    dark = np.abs(values).max(axis=1) < 0.1 * median
    found = dark & (lobes.max(axis=1) > 3 * median)
    return np.asarray(found & (np.mean(found) <= _MOST_DROPOUTS))


def _offset(samples: Samples, largest: float | None = None) -> float:
    """The offset of `LogRelative`: the median over the directions, at least a millionth of the largest sample; 1/sr.

    Not the median of the samples, of which most may lie in a peak. If these are some of more, `largest` is that of all.
    """
    largest = np.abs(samples.values).max() if largest is None else largest
    if not largest:
        return 1.0
    typical = samples.values[gaussian_process.spread(2 * HalfDifference().encode(*samples.directions) - 1, _TYPICAL)]
    return float(max(np.median(np.abs(typical)), 1e-6 * largest, LEAST_OFFSET))


def _ceiling(samples: Samples, offset: float) -> FloatArray:
    """The ceiling of `LogRelative`: (channels,), 1/sr."""
    return np.asarray(CEILING * np.maximum(samples.values.max(axis=0), 1e-6 * offset))
