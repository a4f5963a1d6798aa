"""Gaussian process regression of scattered samples, also known as kriging.

C. E. Rasmussen, C. K. I. Williams: Gaussian Processes for Machine Learning, 2006: the regression is equation 2.25, the
Matern kernel of smoothness 5/2 is equation 4.17. The kernel is the sum of two Matern kernels, of a short and a long
range, over half and difference coordinates. It is averaged over the mirror images of a sample, so that the field has
the symmetries of the lattice; and over the sample's reciprocal, with a slightly smaller weight, so that the field is
nearly reciprocal, but can follow samples that are not.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray

RECIPROCITY = 0.9           # correlation between a pair of directions and its reciprocal
NOISE = 1e-4                # variance of a sample's noise, relative to that of the field
MOST_SAMPLES = 2000         # larger sets are subsampled at random: the cost grows with the cube of the number
_LENGTHS = ((1 / 3, 0.3), (2 / 3, 1.0))     # share and correlation length of each kernel; coordinates are in [-1, 1]
_IMAGES = ([1, 1, 1], [1, 1, -1], [-1, -1, 1], [-1, -1, -1])
_CHUNK = 256                # rows of the kernel matrix at a time: bounds the memory


@dataclass(frozen=True)
class Field:
    """The mean of a Gaussian process given samples.

    Attributes
    ----------
    mu : (n, 3) float64
        The samples' coordinates.
    weights : (n, channels) float64
        K^-1 z, with the samples' covariance K and values z.
    """

    mu: FloatArray
    weights: FloatArray

    def at(self, mu: FloatArray) -> FloatArray:
        """The field at points: (m, 3) to (m, channels)."""
        return np.concatenate([correlation(mu[start:start + _CHUNK], self.mu) @ self.weights
                               for start in range(0, len(mu), _CHUNK)])


def krige(mu: FloatArray, z: FloatArray, noise: FloatArray) -> Field:
    """Fit the field to samples.

    Parameters
    ----------
    mu : (n, 3) float64
        2 x - 1 of half and difference coordinates x.
    z : (n, channels) float64
    noise : (n,) float64
        Variance of each sample's noise, relative to that of the field.

    Returns
    -------
    Field
        It tends to 0 far from all samples.

    Examples
    --------
    Without noise the field interpolates, also at the samples' mirror images.

    >>> mu = np.array([[0.2, 0.1, 0.3], [0.6, 0.0, 0.1]])
    >>> field = krige(mu, np.array([[1.0], [-2.0]]), np.zeros(2))
    >>> field.at(mu * [1, 1, -1])[:, 0].round(9).tolist()
    [1.0, -2.0]
    """
    covariance = np.empty((len(mu), len(mu)))
    for start in range(0, len(mu), _CHUNK):                  # `correlation` needs several times its result's memory
        covariance[start:start + _CHUNK] = correlation(mu[start:start + _CHUNK], mu)
    covariance[np.diag_indices(len(mu))] += noise
    return Field(mu, np.asarray(np.linalg.solve(covariance, z), dtype=float))


def correlation(mu: FloatArray, other: FloatArray) -> FloatArray:
    """Correlation of the field between points: (n, 3) and (m, 3) to (n, m)."""
    total = np.zeros((len(mu), len(other)))
    for image in _IMAGES:
        for exchange, weight in (([1, 1, 1], 0.5 + 0.5 * (1 - RECIPROCITY)), ([1, -1, 1], 0.5 * RECIPROCITY)):
            distance = _distance(mu, other * image * exchange)
            total += weight / len(_IMAGES) * sum(share * _matern(distance / length) for share, length in _LENGTHS)
    return total


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


def _distance(a: FloatArray, b: FloatArray) -> FloatArray:
    """Distances between points: (n, 3) and (m, 3) to (n, m)."""
    return np.sqrt(np.maximum((a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T, 0))


def _matern(distance: FloatArray) -> FloatArray:
    """The Matern kernel of smoothness 5/2 and length 1 (equation 4.17)."""
    r = np.sqrt(5) * distance
    return (1 + r + r * r / 3) * np.exp(-r)
