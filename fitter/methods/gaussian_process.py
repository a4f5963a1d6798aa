"""Gaussian process regression of scattered samples, also known as kriging, with a kernel of greatest likelihood.

C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning, 2006: the regression is equation 2.25, the
Matern kernel of smoothness 5/2 equation 4.17, the likelihood equation 5.8. The kernel is the sum of two Matern kernels,
of a short and a long range, over half and difference coordinates. It is averaged over the mirror images of a sample, so
that the field has the symmetries of the lattice; and over the sample's reciprocal, with a slightly smaller weight, so
that the field is nearly reciprocal, but can follow samples that are not.

What the kernel is, how far it reaches, in which coordinates and above which prior, is chosen for each set of samples by
their likelihood. The variance of the field has its most likely value in each channel; it cancels in the regression.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .. import progress
from ..arrays import FloatArray, IntArray, SingleArray

RECIPROCITY = 0.9           # correlation between a pair of directions and its reciprocal
MOST_SAMPLES = 2000         # larger sets are subsampled at random: the cost grows with the cube of the number
_IMAGES = ([1, 1, 1], [1, 1, -1], [-1, -1, 1], [-1, -1, -1])
_CHUNK = 256                # rows of the kernel matrix at a time: bounds the memory
_AROUND = 12                # samples that bound the field at a point
_BEYOND = math.log(2)       # by which it can exceed their values

# the kernels among which the likelihood decides: each number of a kernel is one of these, in ascending order
CHOICES: dict[str, tuple[float, ...]] = {
    "stretch": (0.0, 2.0, 5.0, 12.0, 33.0),
    "length": (0.2, 0.3, 0.5, 0.8, 1.3),
    "elongation": (0.7, 1.0, 1.5, 2.5),
    "ratio": (2.0, 3.5, 6.0),
    "share": (0.05, 0.2, 0.5),
    "noise": (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)}
_LEAST_GAIN = 1e-4          # of a step's log-likelihood, for each value
_CANDIDATES = 50_000        # points among which the farthest are looked for
_ROUNDS = 2                 # over all numbers of a kernel


@dataclass(frozen=True)
class Kernel:
    """The covariance of a field, over coordinates in [-1, 1].

    Attributes
    ----------
    stretch : float
        Of the half vector; see `coordinates.stretch`.
    length : float
        The short range, along the half vector.
    elongation : float
        The range along the difference angle, relative to that.
    ratio : float
        The long range, relative to the short one.
    share : float
        The part of the variance that is of short range.
    noise : float
        The variance of a sample's noise, relative to that of the field.
    """

    stretch: float = 5.0
    length: float = 0.5
    elongation: float = 1.5
    ratio: float = 3.5
    share: float = 0.2
    noise: float = 1e-4

    def correlation(self, mu: FloatArray | SingleArray, other: FloatArray | SingleArray) -> Any:
        """Correlation of the field between points: (n, 3) and (m, 3) to (n, m), in their precision."""
        total = np.zeros((len(mu), len(other)), mu.dtype)
        for weight, squared in self._squared_distances(mu, other):
            distance = np.sqrt(squared)
            total += weight * (self.share * _matern(distance) + (1 - self.share) * _matern(distance / self.ratio))
        return total

    def nearest(self, mu: FloatArray, other: FloatArray, count: int) -> IntArray:
        """Indices of the samples nearest to points, in any of their images: (n, 3) and (m, 3) to (n, count)."""
        nearest = np.full((len(mu), len(other)), np.inf, np.float32)
        for _, squared in self._squared_distances(mu.astype(np.float32), other.astype(np.float32)):
            nearest = np.minimum(nearest, squared)
        return np.asarray(np.argpartition(nearest, count - 1, axis=1)[:, :count])

    def _squared_distances(self, mu: FloatArray | SingleArray, other: FloatArray | SingleArray,
                           ) -> Iterator[tuple[float, Any]]:
        """The weight of each image of the other points, and squared distances to it: (n, 3) and (m, 3) to (n, m)."""
        scale: Any = (self.length * np.array([self.elongation, 1, 1])).astype(mu.dtype)
        a, b = mu / scale, other / scale
        for image in _IMAGES:
            for exchange, weight in (([1, 1, 1], 1 - 0.5 * RECIPROCITY), ([1, -1, 1], 0.5 * RECIPROCITY)):
                factor: Any = (np.array(image) * exchange).astype(mu.dtype)
                yield weight / len(_IMAGES), squared_distance(a, b * factor)

    def neighbours(self) -> Iterator[tuple[str, int]]:
        """The steps of a search: a number's name, and the direction in which to change it."""
        for name in ("noise", "stretch", "length", "elongation", "share", "ratio"):
            yield name, 1
            yield name, -1

    def moved(self, name: str, step: int) -> "Kernel | None":
        """The kernel with the next larger or smaller choice of a number, if there is one."""
        at = CHOICES[name].index(getattr(self, name)) + step
        return replace(self, **{name: CHOICES[name][at]}) if 0 <= at < len(CHOICES[name]) else None


@dataclass(frozen=True)
class Field:
    """The mean of a Gaussian process given samples, bounded by those around.

    Between samples of very different values the mean overshoots. It is kept from exceeding the values of the nearest
    samples, and 0, by more than log 2.

    Attributes
    ----------
    kernel : Kernel
    mu : (n, 3) float64
        The samples' coordinates.
    weights : (n, channels) float64
        K^-1 z, with the samples' covariance K and values z.
    at_samples : (n, channels) float64
        The field at the samples: their values without what counts as noise.
    """

    kernel: Kernel
    mu: FloatArray
    weights: FloatArray
    at_samples: FloatArray

    def at(self, mu: FloatArray) -> FloatArray:
        """The field at points: (m, 3) to (m, channels)."""
        return np.concatenate([self._bounded(mu[start:start + _CHUNK]) for start in range(0, len(mu), _CHUNK)])

    def _bounded(self, mu: FloatArray) -> FloatArray:
        mean = self.kernel.correlation(mu, self.mu) @ self.weights
        around = self.at_samples[self.kernel.nearest(mu, self.mu, min(_AROUND, len(self.mu)))]
        return np.clip(mean, np.minimum(around.min(axis=1), 0) - _BEYOND, np.maximum(around.max(axis=1), 0) + _BEYOND)


def krige(mu: FloatArray, z: FloatArray, kernel: Kernel, noise: FloatArray) -> tuple[Field, FloatArray]:
    """Fit the field to samples.

    Parameters
    ----------
    mu : (n, 3) float64
        2 x - 1 of half and difference coordinates x.
    z : (n, channels) float64
    kernel : Kernel
    noise : (n,) float64
        Variance of each sample's noise, relative to that of the field.

    Returns
    -------
    field : Field
        It tends to 0 far from all samples.
    left_out : (n, channels) float64
        What the field of all other samples is at each sample (Rasmussen and Williams, equation 5.12).

    Examples
    --------
    Without noise the field interpolates, also at the samples' mirror images.

    >>> mu = np.array([[0.2, 0.1, 0.3], [0.6, 0.0, 0.1]])
    >>> field, _ = krige(mu, np.array([[1.0], [-2.0]]), Kernel(), np.zeros(2))
    >>> field.at(mu * [1, 1, -1])[:, 0].round(9).tolist()
    [1.0, -2.0]
    """
    inverse = np.linalg.inv(_covariance(mu, kernel, noise))
    weights = inverse @ z
    return Field(kernel, mu, weights, z - noise[:, None] * weights), z - weights / np.diag(inverse)[:, None]


def log_likelihood(covariance: FloatArray, z: FloatArray) -> float:
    """The log-likelihood of values (n, channels), a multiple of (n, n) their covariance, for each value.

    The multiple is the most likely one of each channel; constants are left out.

    Examples
    --------
    Of independent values it is minus the logarithm of their root mean square.

    >>> float(np.exp(-log_likelihood(np.eye(4), np.array([[0.5], [-0.5], [0.5], [0.5]]))).round(9))
    0.5
    """
    try:
        root = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        return -np.inf
    whitened = np.linalg.solve(root, z)
    variance = np.maximum(np.mean(whitened ** 2, axis=0), np.finfo(float).tiny)
    return float(-0.5 * np.log(variance).mean() - np.log(np.diag(root)).mean())


@dataclass
class Search:
    """A search for the kernel, and the prior, under which samples are likeliest.

    Attributes
    ----------
    encode : callable
        The samples' coordinates (n, 3), in [-1, 1], given a stretch.
    candidates : sequence of (n, channels) float64
        The samples' values under each prior.
    penalties : sequence of float
        Taken from the log-likelihood of each value: a prior was fitted to the same samples.
    noise : (n,) float64
        Variance of noise beyond that of the kernel, for each sample.
    """

    encode: Callable[[float], FloatArray]
    candidates: Sequence[FloatArray]
    penalties: Sequence[float]
    noise: FloatArray
    _shared: dict[Kernel, FloatArray] = field(default_factory=dict)
    _found: dict[tuple[Kernel, int], float] = field(default_factory=dict)

    def best(self, start: Kernel) -> tuple[float, Kernel, int]:
        """The best log-likelihood found, its kernel and the number of its prior, by steps of one number at a time."""
        kernel = start
        value, prior = self._best_prior(kernel)
        steps = list(kernel.neighbours())
        for turn in range(_ROUNDS):
            before = value
            for number, (name, step) in enumerate(steps):
                progress.report((turn + number / len(steps)) / _ROUNDS)
                while (trial := kernel.moved(name, step)) is not None:
                    found = self._value(trial, prior)
                    if found <= value + _LEAST_GAIN:
                        break
                    value, kernel = found, trial
            found, other = self._best_prior(kernel)
            if found > value:
                value, prior = found, other
            if value < before + _LEAST_GAIN:
                break
        return value, kernel, prior

    def _best_prior(self, kernel: Kernel) -> tuple[float, int]:
        return max((self._value(kernel, number), number) for number in range(len(self.candidates)))

    def _value(self, kernel: Kernel, prior: int) -> float:
        if (kernel, prior) not in self._found:
            noiseless = replace(kernel, noise=0.0)
            if noiseless not in self._shared:       # the last one only: each is large
                self._shared.clear()
                mu = self.encode(kernel.stretch).astype(np.float32)    # quicker, and exact enough to compare
                self._shared[noiseless] = _covariance(mu, noiseless, np.zeros(len(mu))).astype(float)
            covariance = self._shared[noiseless] + np.diag(kernel.noise + self.noise)
            self._found[kernel, prior] = log_likelihood(covariance, self.candidates[prior]) - self.penalties[prior]
        return self._found[kernel, prior]


def choice(count: int, most: int = MOST_SAMPLES, seed: int = 0) -> IntArray:
    """Indices of the samples to use of `count`: all, or a random choice of `most`, in ascending order.

    Examples
    --------
    >>> choice(4).tolist()
    [0, 1, 2, 3]
    >>> len(set(choice(100, 10).tolist()))
    10
    """
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(seed).choice(count, most, replace=False))


def spread(points: FloatArray, most: int) -> IntArray:
    """Indices of at most `most` of points (n, axes), each in turn the farthest from those before, in ascending order.

    Examples
    --------
    >>> spread(np.array([[0.0], [0.1], [1.0], [0.4]]), 3).tolist()
    [0, 2, 3]
    """
    if len(points) <= most:
        return np.arange(len(points))
    candidates = choice(len(points), _CANDIDATES)
    points = points[candidates]
    chosen = np.zeros(most, dtype=int)
    distance = np.full(len(points), np.inf)
    for k in range(1, most):
        distance = np.minimum(distance, ((points - points[chosen[k - 1]]) ** 2).sum(axis=1))
        chosen[k] = np.argmax(distance)
    return np.asarray(candidates[np.sort(chosen)])


def _covariance(mu: FloatArray | SingleArray, kernel: Kernel, noise: FloatArray) -> Any:
    covariance = np.empty((len(mu), len(mu)), mu.dtype)
    for start in range(0, len(mu), _CHUNK):                  # `correlation` needs several times its result's memory
        covariance[start:start + _CHUNK] = kernel.correlation(mu[start:start + _CHUNK], mu)
    covariance[np.diag_indices(len(mu))] += noise
    return covariance


def squared_distance(a: FloatArray | SingleArray, b: FloatArray | SingleArray) -> Any:
    """Squared distances between points: (n, 3) and (m, 3) to (n, m).

    Examples
    --------
    >>> squared_distance(np.array([[0.0, 0, 0]]), np.array([[3.0, 4, 0]])).tolist()
    [[25.0]]
    """
    return np.maximum((a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T, 0)


def _matern(distance: FloatArray | SingleArray) -> Any:
    """The Matern kernel of smoothness 5/2 and length 1 (equation 4.17)."""
    r = math.sqrt(5) * distance
    return (1 + r * (1 + r / 3)) * np.exp(-r)
