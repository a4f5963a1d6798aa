"""Gaussian process regression of scattered samples, also known as kriging, with the kernel of greatest likelihood
(docs/fitting.md, step 4).

Equations are those of C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning, 2006: the regression
2.25, the explicit linear basis 2.40 with a finite variance, the Matern kernel of smoothness 5/2 4.17, the likelihood
5.8. The variance of the field has its most likely value in each channel; it cancels in the regression. Of four axes
exchanging the directions is a mirror image.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import FloatArray
from ..coordinates import ISOTROPIC_AXES
from ..lattice.dense import MIRRORS
from ..lattice.positive_definite import inverse_root

TREND = 0.3                 # variance of the constant, and of the slope along each axis but those that an exchange of
                            # the directions reflects
RECIPROCITIES = 0.9, 1.0    # correlations between a pair of directions and its reciprocal
LENGTHS = 0.7, 1.0, 1.75, 2.8, 4.5              # ranges of the kernel
NOISES = 1e-5, 1e-4, 1e-3, 1e-2, 1e-1           # variances of noise; of these three the likelihood takes one each
_TINY = 1e-7                # added to every variance of noise: makes the covariance invertible
_ROUNDS = 2                 # over all that is chosen
_KERNEL_ROWS = 256          # rows of the kernel matrix at a time: bounds the memory, and fits the processor's cache


@dataclass(frozen=True)
class Kernel:
    """The covariance of a field, over coordinates in [-1, 1]."""

    length: float = LENGTHS[len(LENGTHS) // 2]      # its range
    noise: float = 1e-4                             # the variance of a sample's noise, relative to that of the field
    # the correlation between a pair of directions and its reciprocal, of three axes
    reciprocity: float = RECIPROCITIES[0]

    def gram(self, mu: FloatArray) -> FloatArray:
        """Covariance of the field between points, half of which is computed: (n, axes) to (n, n)."""
        total = np.empty((len(mu), len(mu)))
        for start in range(0, len(mu), _KERNEL_ROWS):
            rows = slice(start, start + _KERNEL_ROWS)
            total[rows, :rows.stop] = self.covariance(mu[rows], mu[:rows.stop])
            total[:rows.stop, rows] = total[rows, :rows.stop].T
        return total

    def covariance(self, mu: FloatArray, other: FloatArray) -> FloatArray:
        """Covariance of the field between points: (n, axes) and (m, axes) to (n, m)."""
        total = TREND * (1 + (mu * self._slopes(mu.shape[1])) @ other.T)
        scaled = math.sqrt(5) / self.length
        apart = [{sign: np.subtract.outer(scaled * a, sign * scaled * b) ** 2 for sign in (1, -1)}
                 for a, b in zip(mu.T, other.T, strict=True)]
        for weight, signs in _images(mu.shape[1], self.reciprocity):
            first, *others = (axis[sign] for axis, sign in zip(apart, signs, strict=True))
            kernel = _matern(sum(others, first))
            kernel *= weight
            total += kernel
        return total

    def _slopes(self, axes: int) -> FloatArray:
        """The variance of the trend's slope along each axis, over `TREND`."""
        return np.array((1.0, 1 - self.reciprocity, 1.0) if axes == ISOTROPIC_AXES else (1.0, 1.0, 0.0, 0.0))


def _images(axes: int, reciprocity: float) -> Iterator[tuple[float, tuple[int, ...]]]:
    """The weight of each image of a point, and the signs of its coordinates."""
    mirrors = ((1,) * axes, *MIRRORS[axes])
    exchanges: tuple[tuple[float, tuple[int, ...]], ...] = (1.0, (1,) * axes),
    if axes == ISOTROPIC_AXES:
        exchanges = (1 - 0.5 * reciprocity, (1, 1, 1)), (0.5 * reciprocity, (1, -1, 1))
    for mirror in mirrors:
        for weight, exchange in exchanges:
            yield weight / len(mirrors), tuple(a * b for a, b in zip(mirror, exchange, strict=True))


@dataclass(frozen=True)
class Field:
    """The mean of a Gaussian process given samples. It tends to the trend far from all of them."""

    kernel: Kernel
    mu: FloatArray              # the samples' coordinates, (n, axes)
    weights: FloatArray         # K^-1 z, with the samples' covariance K and values z, (n, channels)
    at_samples: FloatArray      # the samples' values without what is known to be noise, (n, channels)

    def predict(self, mu: FloatArray) -> FloatArray:
        """The field at points: (m, axes) to (m, channels)."""
        return np.concatenate([self.weights[:0], *(
            self.kernel.covariance(mu[start:start + _KERNEL_ROWS], self.mu) @ self.weights
            for start in range(0, len(mu), _KERNEL_ROWS))])


def krige(mu: FloatArray, z: FloatArray, kernel: Kernel, known: FloatArray) -> tuple[Field, FloatArray]:
    """Simple kriging: the mean of a Gaussian process given samples, and its leave-one-out predictions, (n, channels)
    (Rasmussen and Williams, equation 5.12). Samples have coordinates mu = 2 x - 1, (n, axes), values z, (n, channels),
    and a variance of noise beyond that of the kernel that is known, (n,), relative to that of the field."""
    noise = kernel.noise + _TINY + known
    covariance = kernel.gram(mu)
    covariance[np.diag_indices(len(mu))] += noise
    root = inverse_root(covariance)
    weights = root.T @ (root @ z)
    of_inverse = np.einsum("ij,ij->j", root, root)
    return Field(kernel, mu, weights, z - known[:, None] * weights), z - weights / of_inverse[:, None]


class MaximumLikelihood(NamedTuple):
    """Under what samples are likeliest."""

    value: float    # log-likelihood of each value, less what the prior's parameters cost; constants are left out
    kernel: Kernel
    system: int     # the number of the coordinates,
    prior: int      # and of the prior


@dataclass
class Search:
    """A search for the coordinates, the kernel and the prior under which samples are likeliest."""

    encoded: Sequence[FloatArray]                       # the samples' coordinates (n, axes), in [-1, 1], in each system
    candidates: Sequence[FloatArray]                    # the samples' values above each prior, (n, channels)
    penalties: Sequence[float]  # taken from the log-likelihood of each value: a prior was fitted to the same samples
    known: FloatArray                                   # variance of noise beyond that of the kernel, (n,)
    reciprocities: Sequence[float] = RECIPROCITIES      # among which it chooses

    def __post_init__(self) -> None:
        self._covariances: dict[tuple[int, Kernel], FloatArray] = {}
        self._innovations: dict[tuple[int, Kernel], tuple[FloatArray, FloatArray]] = {}

    def maximise(self, systems: Sequence[int]) -> MaximumLikelihood:
        """The maximum likelihood in some systems, by coordinate ascent over prior, system, length and reciprocity."""
        likeliest = self._maximise_noise(systems[len(systems) // 2], Kernel(reciprocity=self.reciprocities[0]),
                                         len(self.candidates) - 1)
        for turn in range(_ROUNDS):
            before = likeliest
            progress.report(turn / _ROUNDS)
            likeliest = max((self._maximise_noise(likeliest.system, likeliest.kernel, prior)
                             for prior in range(len(self.candidates))), key=attrgetter("value"))
            likeliest = max((self._maximise_noise(system, likeliest.kernel, likeliest.prior) for system in systems),
                            key=attrgetter("value"))
            progress.report((turn + 0.5) / _ROUNDS)
            for number, choices in {"length": LENGTHS, "reciprocity": self.reciprocities}.items():
                kernels = [replace(likeliest.kernel, **{number: each}) for each in choices]
                likeliest = max((self._maximise_noise(likeliest.system, kernel, likeliest.prior) for kernel in kernels),
                                key=attrgetter("value"))
            if likeliest == before:
                break
        return likeliest

    def _maximise_noise(self, system: int, kernel: Kernel, prior: int) -> MaximumLikelihood:
        """The maximum likelihood over the noise, all else given: hill climbing along `NOISES` from that of a kernel."""
        likeliest, first = self._evaluate_noise(system, kernel, prior), NOISES.index(kernel.noise)
        for noises in (NOISES[first + 1:], NOISES[:first][::-1]):
            for noise in noises:
                other = self._evaluate_noise(system, replace(kernel, noise=noise), prior)
                if other.value <= likeliest.value:
                    break
                likeliest = other
        return likeliest

    def _evaluate_noise(self, system: int, kernel: Kernel, prior: int) -> MaximumLikelihood:
        variances, errors = self._predict(system, kernel)
        first = sum(each.shape[1] for each in self.candidates[:prior])
        of_prior = errors[:, first:first + self.candidates[prior].shape[1]]
        return MaximumLikelihood(likelihood(variances, of_prior ** 2) - self.penalties[prior], kernel, system, prior)

    def _predict(self, system: int, kernel: Kernel) -> tuple[FloatArray, FloatArray]:
        """Each sample's variance given those before it, (n,), and the error of its prediction from these, (n, channels
        of all candidates), which are uncorrelated: the diagonal and the rows of a Cholesky factor."""
        if (system, kernel) not in self._innovations:
            z = np.concatenate(self.candidates, axis=1)
            count, size = z.shape
            bordered = np.zeros((count + size,) * 2)
            bordered[:count, :count] = self._covariance(system, replace(kernel, noise=0.0))
            bordered[np.diag_indices(count)] += kernel.noise
            bordered[count:, :count] = z.T
            # no more than the samples can take away, so that the whole is positive definite
            bordered[np.arange(count, count + size), np.arange(count, count + size)] = (
                2 * (z ** 2).sum() / kernel.noise + 1)
            factor = np.linalg.cholesky(bordered)
            deviations = np.diag(factor)[:count]
            self._innovations[system, kernel] = deviations ** 2, factor[count:, :count].T * deviations[:, None]
        return self._innovations[system, kernel]

    def _covariance(self, system: int, kernel: Kernel) -> FloatArray:
        if (system, kernel) not in self._covariances:
            mu = self.encoded[system]
            covariance = kernel.gram(mu)
            covariance[np.diag_indices(len(mu))] += self.known
            self._covariances[system, kernel] = covariance
        return self._covariances[system, kernel]


def likelihood(variances: FloatArray, squares: FloatArray) -> float:
    """The log-likelihood of each of uncorrelated values: (n,) variances up to a factor, the most likely one of each
    channel, and (n, channels) squared values; constants are left out."""
    factor = np.maximum((squares / variances[:, None]).mean(axis=0), np.finfo(float).tiny)
    return float(-0.5 * np.log(factor).mean() - 0.5 * np.log(variances).mean())


def _matern(q2: FloatArray) -> FloatArray:
    """The Matern kernel of smoothness 5/2, of q^2 = 5 (distance / length)^2, which is overwritten."""
    q = np.sqrt(q2)
    q2 /= 3
    q2 += q
    q2 += 1
    q2 *= np.exp(np.negative(q, out=q), out=q)
    return q2
