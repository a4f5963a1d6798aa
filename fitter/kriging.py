"""Kernel regression of scattered samples: the smooth field that is likeliest given them.

Kriging, or Gaussian process regression (C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning,
2006, sections 2.2 and 4.2), with a Matern kernel, twice differentiable, over half and difference coordinates. The
kernel is the sum over the mirror images of a sample, so that the field has the symmetries of the lattice, and over its
reciprocal with nearly the same weight, so that the field is nearly reciprocal: as far as the samples themselves are.
"""

from dataclasses import dataclass

import numpy as np

RECIPROCITY = 0.9           # correlation between a direction pair and its exchange
MOST_SAMPLES = 2000         # beyond these a random choice: the cost grows with their cube
_IMAGES = ([1, 1, 1], [1, 1, -1], [-1, -1, 1], [-1, -1, -1])
_CHUNK = 2048               # rows of the kernel at a time


@dataclass(frozen=True)
class Kernel:
    """How far samples speak for their surroundings.

    Attributes
    ----------
    along, across : float
        Correlation lengths along |D| and along H; the coordinates run from -1 to 1.
    noise : float
        Variance of the noise of a sample, relative to that of the field.
    """

    along: float
    across: float
    noise: float

    def matrix(self, mu, other):
        """Correlation of the field between points (n, 3) and (m, 3): (n, m)."""
        scale = 1 / np.array([self.along, self.across, self.across])
        total = np.zeros((len(mu), len(other)))
        for image in _IMAGES:
            for exchange, weight in (([1, 1, 1], 0.5 + 0.5 * (1 - RECIPROCITY)), ([1, -1, 1], 0.5 * RECIPROCITY)):
                total += weight / len(_IMAGES) * _matern(mu * scale, other * image * exchange * scale)
        return total


@dataclass(frozen=True)
class Field:
    """A fitted field: call `at`."""

    kernel: Kernel
    mu: np.ndarray
    weights: np.ndarray

    def at(self, mu):
        """(m, 3) to (m, channels)."""
        return np.concatenate([self.kernel.matrix(mu[start:start + _CHUNK], self.mu) @ self.weights
                               for start in range(0, len(mu), _CHUNK)])


def krige(mu, z, kernel):
    """The field of least energy that passes the samples as near as their noise asks.

    Parameters
    ----------
    mu : (n, 3) float64
        2 x - 1 of half and difference coordinates x.
    z : (n, channels) float64
    kernel : Kernel

    Returns
    -------
    Field
        It tends to 0 far from all samples.
    """
    matrix = kernel.matrix(mu, mu)
    matrix[np.diag_indices(len(mu))] += kernel.noise
    return Field(kernel, mu, np.linalg.solve(matrix, z))


def choice(count, most=MOST_SAMPLES, seed=0):
    """Which of `count` samples to use: all, or a random choice of `most`."""
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(seed).choice(count, most, replace=False))


def _matern(a, b):
    """Matern kernel of smoothness 5/2 of the distances between (n, 3) and (m, 3)."""
    squared = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T
    r = np.sqrt(5 * np.maximum(squared, 0))
    return (1 + r + r * r / 3) * np.exp(-r)
