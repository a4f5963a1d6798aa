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

from ..arrays import FloatArray, IntArray
from ..coordinates.half_difference import HalfDifference
from ..coordinates.rusinkiewicz import Rusinkiewicz
from ..lattice import dense, perfect_hash
from ..lattice.dense import DenseLattice
from ..lattice.least_squares import largest
from ..lattice.normal_equations import NormalEquations, Penalty, asymmetry, curvature, gains
from ..lattice.sparse import SparseLattice
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
_COARSE = 3                 # level of a dense lattice that tries arrangements; the best are tried by one of `_FINEST`
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
_FINEST = 4                 # level of a dense lattice whose equations are solved; a finer one is refined from it, ...
_FINER = 3000               # ... and then only as many of its control points are fitted
_MOST_SPARSE = 4500         # control points of the sparse lattice: their equations take the square of them in memory
_PRECISE = 0.02             # deviation of a sample, relative to it, up to which it is trusted like any other


class Arrangement(NamedTuple):
    """What a field is a function of, what it is relative to, and how smooth it is."""

    coordinates: HalfDifference | Rusinkiewicz
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
    *others, richest = prior.candidates(subset(samples, choice(len(samples), _OF_PRIORS)), offset)
    transform = LogRelative(richest, offset, ceiling)
    systems = [Arrangement(system(stretch=stretch), transform)
               for stretch in STRETCHES for system in (HalfDifference, Rusinkiewicz)]
    few, some = (subset(samples, choice(len(samples), count)) for count in (_TRIED, 2 * _TRIED))

    def by_error(level: int, tried: Samples, arrangements: list[Arrangement]) -> list[Arrangement]:
        def error(arrangement: Arrangement) -> float:
            return _Search(_problem(tried, arrangement), arrangement, level).improved(_STEPS_TRIED).error

        return sorted(arrangements, key=error)[:_TRIED_AGAIN]

    best = by_error(_COARSE, few, systems)
    best = by_error(_COARSE, few, best + [each._replace(transform=replace(transform, prior=model))
                                          for each in best for model in others])
    found = by_error(_FINEST, some, best)[0]
    return found._replace(stiffness=_stiffness(some, found))


def _stiffness(samples: Samples, arrangement: Arrangement) -> float:
    """The stiffness whose fit of half of the samples predicts the others best: the larger, the more noise they have."""
    halves = np.array_split(np.random.default_rng(0).permutation(len(samples)), 2)
    problem, others = (_problem(subset(samples, half), arrangement) for half in halves)

    def error(stiffness: float) -> float:
        search = _Search(problem, arrangement._replace(stiffness=stiffness), _COARSE).improved(_STEPS_TRIED)
        (_, box), = search.boxes()
        return others.error(dense.evaluate(box, _COARSE, others.x))

    return min(STIFFNESSES, key=error)


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
    search = _Search(_problem(used, arrangement), arrangement, min(levels.diffuse, _FINEST)).improved()
    if levels.diffuse > _FINEST:
        search.add(levels.diffuse, _FINER)
        search.improved().hold()
    if levels.specular is not None:
        count = min(levels.kept, _MOST_SPARSE)
        if count > _FINER:
            search.hold()
        search.add(levels.specular, count)
        search.improved()
    boxes = search.boxes()
    level, control_points = boxes[0]
    while level < levels.diffuse:
        control_points, level = dense.refine(control_points, level), level + 1
    if levels.diffuse > _FINEST:
        control_points = control_points + boxes[1][1]
    specular = None
    if levels.specular is not None:
        index = perfect_hash.build(search.keys())
        coefficients = boxes[-1][1].reshape(-1, control_points.shape[-1])[index.keys]
        specular = SparseLattice(levels.specular, index, coefficients.astype(np.float32))
    return DenseLattice(levels.diffuse, control_points.astype(np.float32)), specular


@dataclass(frozen=True, eq=False)
class _Problem:
    """Samples that a field above a prior is to follow.

    Attributes
    ----------
    x : (n, 3) float64
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
        self._problem, self._arrangement = problem, arrangement
        self._parts: list[tuple[int, IntArray | None]] = [(level, None)]
        self._points = [np.zeros((math.prod(dense.shape(level)), problem.wanted.shape[1]))]
        bright = arrangement.stiffness * self._brightness(level) * len(problem.x) / len(self._points[0])
        self._penalties = [[curvature(level, _STRAIGHT * bright), asymmetry(level, _RECIPROCAL * bright)]]
        self._held = 0
        self._equations = NormalEquations(problem.x, self._parts)
        self.field = np.zeros(problem.wanted.shape)
        self.error = problem.error(self.field)

    def add(self, level: int, count: int) -> None:
        """Add the control points of another lattice that help most, at most as many."""
        weights, z = self._problem.linearised(self.field)
        _, keys = largest(gains(self._problem.x, level, weights, z), dense.representative(level).ravel(), count)
        self._parts.append((level, keys))
        self._points.append(np.zeros((len(keys), z.shape[1])))
        weights = _SMALL * self._arrangement.stiffness * self._brightness(level)[keys]
        self._penalties.append([Penalty(np.arange(len(keys))[:, None], np.ones(1), weights)])
        self._equations = NormalEquations(self._problem.x, self._parts[self._held:])

    def hold(self) -> None:
        """Leave the lattices so far as they are."""
        self._held = len(self._parts)

    def keys(self) -> IntArray:
        """The control points of the lattice that was added last."""
        return np.asarray(self._parts[-1][1])

    def improved(self, steps: int = _STEPS) -> "_Search":
        """Take steps, until one gains little, and return this search."""
        for _ in range(steps):
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
        at = np.moveaxis(np.indices(dense.shape(level)), 0, -1).reshape(-1, 3) + np.array(dense.origin(level))
        directions = self._arrangement.coordinates.decode(np.clip(at / dense.cells(level), 0, 1))
        transform = self._arrangement.transform
        return np.asarray((transform.prior.evaluate(*directions) + transform.offset).mean(axis=1) ** (2 * _POWER))

    def boxes(self, points: Sequence[FloatArray] | None = None) -> list[tuple[int, FloatArray]]:
        """The level of each lattice, and all its control points, shape(level) + (channels,); of `points` if given."""
        boxes = []
        for (level, keys), each in zip(self._parts, self._points if points is None else points, strict=True):
            box = np.zeros((math.prod(dense.shape(level)), each.shape[1]))
            box[slice(None) if keys is None else keys] = each
            boxes.append((level, box.reshape(*dense.shape(level), -1)))
        return boxes
