"""Lattices fitted to more samples than a Gaussian process can take, by penalised least squares.

Here the samples determine the lattices, and what is between them is smooth because curvature is penalised (P. H. C.
Eilers, B. D. Marx: Flexible Smoothing with B-splines and Penalties, Statistical Science 11(2), 1996). What is minimised
is the squared error of the cube root of f + offset times a cosine, by which fits are judged, by Gauss-Newton steps
(J. Nocedal, S. J. Wright: Numerical Optimization, 2006, section 10.3) that are shortened until they help:

1. Of all coordinates and stretches, and then of all priors, take those with which a dense lattice fits best.
2. Fit the dense lattice.
3. Keep the control points of the sparse lattice that would help most, and fit both lattices together.

Each penalty counts as a number of samples, that are spread evenly over the lattice and have the prior's brightness.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import FloatArray, IntArray
from ..coordinates import ISOTROPIC_AXES
from ..coordinates.anisotropic_rusinkiewicz import AnisotropicRusinkiewicz
from ..coordinates.half_difference import HalfDifference
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..lattice import dense, perfect_hash
from ..lattice.dense import DenseLattice
from ..lattice.least_squares import largest
from ..lattice.normal_equations import NormalEquations, Penalty, asymmetry, curvature, gains
from ..lattice.sparse import SparseLattice
from ..model.microfacet import Microfacet
from ..model.transform import LogRelative, bounded_log
from ..samples import Samples, subset
from ..shader_constants import STEEPEST
from . import prior
from .gaussian_process import choice
from .levels import Levels

MOST = 50_000               # samples fitted: of a few thousand control points more say no more
STRETCHES = 5.0, 12.0, 33.0, 100.0, 300.0, 1000.0
STIFFNESSES = 1.0, 30.0, 1000.0
_OF_PRIORS = 8000           # samples to which lobes are fitted
# by the number of axes: the level of a dense lattice that tries arrangements; and that of the largest whose equations
# are solved, which tries the best. A finer one is refined from it, ...
_COARSE = {3: 3, 4: 1}
_FINEST = {3: 4, 4: 2}
_TRIED = 3000               # samples that this is fitted to
_TRIED_AGAIN = 3            # of the arrangements
_STEPS_TRIED = 4
_POWER = 1 / 3              # of f + offset, whose error is minimised
_FAR = 1.0                  # of a logarithm: where a fit is farther off, steps are those of the logarithm
# weights of penalties: of a field's curvature, and of what it changes when the directions are exchanged, as shares of
# the samples; of each sparse control point, in samples
_STRAIGHT, _RECIPROCAL, _SMALL = 1e-4, 1e-2, 0.1
_STEPS = 8
_LENGTHS = 1.0, 0.5, 0.25, 0.1  # of a step, that are tried
_LEAST_GAIN = 0.02          # of the error, for another step
_FINER = 3000               # ... and then only as many of its control points are fitted
_MOST_SPARSE = 4500         # control points of the sparse lattice: their equations take the square of them in memory
_MOST_BATCHES = 3           # of four axes, as many lots of them are fitted one after the other
_MOST_ELONGATED = 10        # ratio of the stretches of an anisotropic half vector
_PRECISE = 0.02             # deviation of a sample, relative to it, up to which it is trusted like any other


class Arrangement(NamedTuple):
    """What a field is a function of, what it is relative to, and how smooth it is."""

    coordinates: HalfDifference | Rusinkiewicz | AnisotropicRusinkiewicz
    transform: LogRelative
    stiffness: float = 1.0
    """By which penalties are multiplied."""


def arranged(samples: Samples, offset: float, ceiling: FloatArray) -> Arrangement:
    """The coordinates, stretch and prior with which a dense lattice comes closest to many samples.

    A coarse lattice tries coordinates and stretches, and all priors with the best of these; a finer lattice tries the
    best of all. The stiffness is the one that then predicts best.

    Parameters
    ----------
    samples : Samples
    offset : float
    ceiling : (channels,) float64
        Of the transform.
    """
    with progress.part(0.0, 0.1, "Fitting lobes"):
        *others, richest = prior.candidates(subset(samples, choice(len(samples), _OF_PRIORS)), offset)
    transform = LogRelative(richest, offset, ceiling)
    systems = [Arrangement(system, transform) for system in (
        [system(stretch=stretch) for stretch in STRETCHES for system in (HalfDifference, Rusinkiewicz)]
        if samples.isotropic else _anisotropic_systems(richest))]
    axes = len(systems[0].coordinates.axes)
    few, some = (subset(samples, choice(len(samples), count)) for count in (_TRIED, 2 * _TRIED))

    def by_error(level: int, tried: Samples, arrangements: list[Arrangement]) -> list[Arrangement]:
        def error(arrangement: Arrangement) -> float:
            return _Search(_problem(tried, arrangement), arrangement, level).improved(_STEPS_TRIED).error

        errors = [error(arrangement) for arrangement in progress.each(arrangements)]
        return [arrangements[at] for at in np.argsort(errors, kind="stable")[:_TRIED_AGAIN]]

    with progress.part(0.1, 0.35, "Choosing coordinates"):
        best = by_error(_COARSE[axes], few, systems)
    with progress.part(0.35, 0.55, "Choosing a model"):
        best = by_error(_COARSE[axes], few, best + [each._replace(transform=replace(transform, prior=model))
                                              for each in best for model in others])
    with progress.part(0.55, 0.95):
        found = by_error(_FINEST[axes], some, best)[0]
    with progress.part(0.95, 1.0, "Choosing how smooth it is"):
        return found._replace(stiffness=_stiffness(some, found))


def _anisotropic_systems(model: Microfacet) -> list[AnisotropicRusinkiewicz]:
    """Coordinates along those of the axes, and along those of the narrowest anisotropic lobe of a model."""
    systems = [AnisotropicRusinkiewicz(stretch, stretch) for stretch in STRETCHES]
    if not model.isotropic:
        narrowest = int(np.argmin(np.where(model.across == model.alpha, np.inf, np.minimum(model.alpha, model.across))))
        alpha, across = model.alpha[narrowest], model.across[narrowest]
        least = max(min(alpha, across), max(alpha, across) / _MOST_ELONGATED)
        shares = least / max(alpha, least), least / max(across, least)      # at most 1, but for rounding
        systems += [AnisotropicRusinkiewicz(stretch * min(shares[0], 1.0), stretch * min(shares[1], 1.0),
                                            float(model.turn[narrowest])) for stretch in STRETCHES]
    return systems


def _stiffness(samples: Samples, arrangement: Arrangement) -> float:
    """The stiffness whose fit of half of the samples predicts the others best: the larger, the more noise they have."""
    halves = np.array_split(np.random.default_rng(0).permutation(len(samples)), 2)
    problem, others = (_problem(subset(samples, half), arrangement) for half in halves)
    level = _COARSE[problem.x.shape[1]]

    def error(stiffness: float) -> float:
        search = _Search(problem, arrangement._replace(stiffness=stiffness), level).improved(_STEPS_TRIED)
        (_, box), = search.boxes()
        return others.error(dense.evaluate(box, level, others.x))

    errors = [error(stiffness) for stiffness in progress.each(STIFFNESSES)]
    return STIFFNESSES[int(np.argmin(errors))]


def lattices(samples: Samples, arrangement: Arrangement, levels: Levels) -> tuple[DenseLattice, SparseLattice | None]:
    """Fit the lattices of a field to many samples.

    Parameters
    ----------
    samples : Samples
    arrangement : Arrangement
    levels : Levels
        At most `_MOST_SPARSE` control points are kept, whatever the compression.
    """
    used = subset(samples, choice(len(samples), MOST))
    axes = len(arrangement.coordinates.axes)
    finest = _FINEST[axes]
    with progress.part(0.0, 0.4 if levels.specular is not None else 0.7, "Fitting the dense lattice"):
        search = _Search(_problem(used, arrangement), arrangement, min(levels.diffuse, finest)).improved()
    if levels.diffuse > finest:
        with progress.part(0.4, 0.6):
            search.add(levels.diffuse, _FINER)
            search.improved().hold()
    dense_parts = len(search.boxes())
    if levels.specular is not None:
        counts = _batches(levels.kept_of(axes), axes)
        begin = 0.4 if levels.diffuse <= finest else 0.6
        for number, count in enumerate(counts):
            progress.report(begin, "Fitting the sparse lattice")
            if len(counts) > 1 or count > _FINER:
                search.hold()
            search.add(levels.specular, count)
            end = begin + (1 - begin) / (len(counts) - number)
            with progress.part(begin, end):
                search.improved()
            begin = end
    boxes = search.boxes()
    level, control_points = boxes[0]
    while level < levels.diffuse:
        control_points, level = dense.refine(control_points, level), level + 1
    if levels.diffuse > finest:
        control_points = control_points + boxes[1][1]
    specular = None
    if levels.specular is not None:
        index = perfect_hash.build(np.concatenate(search.keys()[dense_parts:]))
        every = np.sum([box for _, box in boxes[dense_parts:]], axis=0)
        coefficients = every.reshape(-1, control_points.shape[-1])[index.keys]
        specular = SparseLattice(levels.specular, index, coefficients.astype(np.float32), axes)
    return DenseLattice(levels.diffuse, control_points.astype(np.float32)), specular


def _batches(kept: int, axes: int) -> list[int]:
    """The numbers of control points of the sparse lattice that are fitted together, one batch after the other."""
    if axes == ISOTROPIC_AXES or kept <= _MOST_SPARSE:
        return [min(kept, _MOST_SPARSE)]
    batches = min(-(-kept // _MOST_SPARSE), _MOST_BATCHES)
    return [min(kept // batches, _MOST_SPARSE)] * batches


@dataclass(frozen=True, eq=False)
class _Problem:
    """Samples that a field above a prior is to follow.

    Attributes
    ----------
    x : (n, axes) float64
        Coordinates.
    reference : (n, channels) float64
        Of the prior, + offset; 1/sr.
    wanted : (n, channels) float64
        f + offset.
    trust : (n,) float64
        Errors are multiplied by these.
    most : (channels,) float64
        The largest f + offset.
    """

    x: FloatArray
    reference: FloatArray
    wanted: FloatArray
    trust: FloatArray
    most: FloatArray

    def error(self, field: FloatArray) -> float:
        """The sum of the squared errors of (f + offset)^_POWER, over _POWER^2."""
        errors = self._value(field) ** _POWER - self.wanted ** _POWER
        return float(((errors * self.trust[:, None]) ** 2).sum()) / _POWER ** 2

    def linearised(self, field: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The weights (n,) and targets (n, channels) of the least-squares problem whose solution is the next step."""
        value = self._value(field)
        larger = np.maximum(value, self.wanted)
        weights = larger.max(axis=1) ** _POWER
        distance = np.log(self.wanted / self.reference) - field
        slope = value ** _POWER
        near = slope * (self.wanted ** _POWER - slope) / _POWER
        far = larger ** (2 * _POWER) * distance
        return weights * self.trust, np.where(np.abs(distance) > _FAR, far, near) / weights[:, None] ** 2

    def _value(self, field: FloatArray) -> FloatArray:
        return np.asarray(np.minimum(self.reference * np.exp(np.minimum(field, STEEPEST)), self.most))


def _problem(samples: Samples, arrangement: Arrangement) -> _Problem:
    coordinates, transform, _ = arrangement
    directions = samples.directions
    trust = np.cos(samples.theta_o) ** _POWER           # reflectance is seen times its cosine
    if samples.deviation is not None:
        trust /= np.hypot(1, samples.deviation / _PRECISE)
    return _Problem(coordinates.encode(*directions), transform.prior.evaluate(*directions) + transform.offset,
                    np.exp(bounded_log(samples.values, transform.offset)), trust,
                    transform.ceiling + transform.offset)


class _Search:
    """The control points of lattices that follow a problem more and more closely.

    Attributes
    ----------
    field : (n, channels) float64
    error : float
        The squared errors of the problem, and the penalties.
    """

    def __init__(self, problem: _Problem, arrangement: Arrangement, level: int) -> None:
        self._problem, self._arrangement, self._axes = problem, arrangement, problem.x.shape[1]
        self._parts: list[tuple[int, IntArray | None]] = [(level, None)]
        self._points = [np.zeros((math.prod(dense.shape(level, self._axes)), problem.wanted.shape[1]))]
        bright = arrangement.stiffness * self._brightness(level) * len(problem.x) / len(self._points[0])
        self._penalties = [[curvature(level, _STRAIGHT * bright, self._axes)]]
        if self._axes == ISOTROPIC_AXES:        # of four, control points of exchanged directions are the same
            self._penalties[0].append(asymmetry(level, _RECIPROCAL * bright))
        self._held = 0
        self._equations = NormalEquations(problem.x, self._parts)
        self.field = np.zeros(problem.wanted.shape)
        self.error = problem.error(self.field)

    def add(self, level: int, count: int) -> None:
        """Add the control points of another lattice that help most, at most as many."""
        weights, z = self._problem.linearised(self.field)
        same = dense.representative(level, self._axes).ravel()
        _, keys = largest(gains(self._problem.x, level, weights, z), same, count)
        self._parts.append((level, keys))
        self._points.append(np.zeros((len(keys), z.shape[1])))
        weights = _SMALL * self._arrangement.stiffness * self._brightness(level)[keys]
        self._penalties.append([Penalty(np.arange(len(keys))[:, None], np.ones(1), weights)])
        self._equations = NormalEquations(self._problem.x, self._parts[self._held:])

    def hold(self) -> None:
        """Leave the lattices so far as they are."""
        self._held = len(self._parts)

    def keys(self) -> list[IntArray]:
        """The control points of each lattice; of one that has all, none."""
        return [np.zeros(0, int) if keys is None else keys for _, keys in self._parts]

    def improved(self, steps: int = _STEPS) -> "_Search":
        """Take steps, until one gains little, and return this search."""
        for step in range(steps):
            progress.report(step / steps)
            before = self.error
            held = self._points[:self._held]
            move = self._equations.solve(*self._problem.linearised(self.field), self._penalties[self._held:],
                                         self._points[self._held:])
            for length in _LENGTHS:
                points = held + [now + length * each for now, each in zip(self._points[self._held:], move, strict=True)]
                field = sum((dense.evaluate(box, level, self._problem.x) for level, box in self.boxes(points)),
                            np.zeros(1))
                error = self._problem.error(field) + sum(
                    penalty.value(each) for of_lattice, each in zip(self._penalties, points, strict=True)
                    for penalty in of_lattice)
                if error < self.error:
                    self.error, self.field, self._points = error, field, points
                    break
            if self.error > (1 - _LEAST_GAIN) * before:
                break
        return self

    def _brightness(self, level: int) -> FloatArray:
        """The weight of a sample at each control point: (points,)."""
        shape, origin = dense.shape(level, self._axes), dense.origin(level, self._axes)
        at = np.moveaxis(np.indices(shape), 0, -1).reshape(-1, self._axes) + np.array(origin)
        directions = self._arrangement.coordinates.decode(np.clip(at / dense.cells(level), 0, 1))
        transform = self._arrangement.transform
        return np.asarray((transform.prior.evaluate(*directions) + transform.offset).mean(axis=1) ** (2 * _POWER))

    def boxes(self, points: Sequence[FloatArray] | None = None) -> list[tuple[int, FloatArray]]:
        """The level of each lattice, and all its control points, shape(level) + (channels,); of `points` if given."""
        boxes = []
        for (level, keys), each in zip(self._parts, self._points if points is None else points, strict=True):
            shape = dense.shape(level, self._axes)
            box = np.zeros((math.prod(shape), each.shape[1]))
            box[slice(None) if keys is None else keys] = each
            boxes.append((level, box.reshape(*shape, -1)))
        return boxes
