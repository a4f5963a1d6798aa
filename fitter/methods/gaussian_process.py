"""Kernel regression of scattered samples: the smooth field that is likeliest given them.

Kriging, or Gaussian process regression (C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning,
2006, sections 2.2 and 4.2), with Matern kernels, twice differentiable, of a short and a long range over half and
difference coordinates. The kernel is the sum over the mirror images of a sample, so that the field has the symmetries
of the lattice, and over its reciprocal with nearly the same weight, so that the field is nearly reciprocal: as far as
the samples themselves are.
"""

from dataclasses import dataclass

import numpy as np

RECIPROCITY = 0.9           # correlation between a direction pair and its exchange
NOISE = 1e-4                # variance of the noise of a sample, relative to that of the field
MOST_SAMPLES = 2000         # beyond these a random choice: the cost grows with their cube
_LENGTHS = ((1 / 3, 0.3), (2 / 3, 1.0))     # share and correlation length of each part; coordinates run from -1 to 1
_IMAGES = ([1, 1, 1], [1, 1, -1], [-1, -1, 1], [-1, -1, -1])
_CHUNK = 256                # rows of the kernel at a time: more take more memory, and no less time


@dataclass(frozen=True)
class Field:
    """A fitted field: call `at`."""

    mu: np.ndarray
    weights: np.ndarray

    def at(self, mu):
        """(m, 3) to (m, channels)."""
        return np.concatenate([correlation(mu[start:start + _CHUNK], self.mu) @ self.weights
                               for start in range(0, len(mu), _CHUNK)])


def krige(mu, z, noise):
    """The field of least energy that passes the samples as near as their noise asks.

    Parameters
    ----------
    mu : (n, 3) float64
        2 x - 1 of half and difference coordinates x.
    z : (n, channels) float64
    noise : (n,) float64
        Variance of the noise of each sample, relative to that of the field.

    Returns
    -------
    Field
        It tends to 0 far from all samples.
    """
    covariance = np.empty((len(mu), len(mu)))
    for start in range(0, len(mu), _CHUNK):                  # `correlation` takes several times its result's memory
        covariance[start:start + _CHUNK] = correlation(mu[start:start + _CHUNK], mu)
    covariance[np.diag_indices(len(mu))] += noise
    return Field(mu, np.linalg.solve(covariance, z))


def correlation(mu, other):
    """Correlation of the field between points (n, 3) and (m, 3): (n, m)."""
    total = np.zeros((len(mu), len(other)))
    for image in _IMAGES:
        for exchange, weight in (([1, 1, 1], 0.5 + 0.5 * (1 - RECIPROCITY)), ([1, -1, 1], 0.5 * RECIPROCITY)):
            distance = _distance(mu, other * image * exchange)
            total += weight / len(_IMAGES) * sum(share * _matern(distance / length) for share, length in _LENGTHS)
    return total


def choice(count, most=MOST_SAMPLES, seed=0):
    """Which of `count` samples to use: all, or a random choice of `most`."""
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(seed).choice(count, most, replace=False))


def _distance(a, b):
    """Distances between (n, 3) and (m, 3)."""
    return np.sqrt(np.maximum((a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T, 0))


def _matern(distance):
    """Matern kernel of smoothness 5/2 and length 1."""
    r = np.sqrt(5) * distance
    return (1 + r + r * r / 3) * np.exp(-r)
