"""Thin-plate splines of scattered samples, smoothed as much as predicts left-out samples best.

J. Duchon: Splines Minimizing Rotation-Invariant Semi-Norms in Sobolev Spaces, 1977; the smoothing and its left-out
predictions are in G. Wahba: Spline Models for Observational Data, 1990, chapters 2 and 4. The spline is ::

    s(mu) = p(mu) + sum_k a_k r_k^2 log r_k,    r_k = |mu - mu_k|

with a polynomial p of the first degree. Unlike a Gaussian process it has no length scale, and it continues a trend.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from .gaussian_process import squared_distance

SMOOTHINGS = (1e-6, 1e-4, 1e-3, 1e-2, 3e-2, 1e-1, 0.3, 1.0)
_LOOSE = 1e-8               # of the polynomial, instead of 0: the samples need not determine it
_CHUNK = 256                # points at a time: bounds the memory


@dataclass(frozen=True)
class Spline:
    """A thin-plate spline.

    Attributes
    ----------
    mu : (n, 3) float64
        The samples' coordinates.
    weights : (n + 4, channels) float64
        Of the samples, and of the polynomial 1, mu.
    """

    mu: FloatArray
    weights: FloatArray

    def at(self, mu: FloatArray) -> FloatArray:
        """The spline at points: (m, 3) to (m, channels)."""
        return np.concatenate([
            np.concatenate([_kernel(part, self.mu), _polynomial(part)], axis=1) @ self.weights
            for part in (mu[start:start + _CHUNK] for start in range(0, len(mu), _CHUNK))])


def fit(mu: FloatArray, z: FloatArray, smoothing: float, noise: FloatArray) -> tuple[Spline, FloatArray]:
    """Fit a spline to samples.

    Parameters
    ----------
    mu : (n, 3) float64
    z : (n, channels) float64
    smoothing : float
        Positive; the weight of roughness against deviations.
    noise : (n,) float64
        Added to it, for each sample.

    Returns
    -------
    spline : Spline
    left_out : (n, channels) float64
        What the spline of all other samples is at each sample.

    Examples
    --------
    It reproduces polynomials of the first degree, also where there are no samples.

    >>> mu = np.random.default_rng(0).random((30, 3))
    >>> spline, left_out = fit(mu, 1 + 2 * mu[:, :1], 0.1, np.zeros(30))
    >>> float(spline.at(np.array([[3.0, 0, 0]]))[0, 0].round(3)), bool(np.allclose(left_out, 1 + 2 * mu[:, :1]))
    (7.0, True)
    """
    n, polynomial = len(mu), _polynomial(mu)
    matrix = np.zeros((n + 4, n + 4))
    matrix[:n, :n] = _kernel(mu, mu) + np.diag(smoothing + noise)
    matrix[:n, n:], matrix[n:, :n] = polynomial, polynomial.T
    matrix[n:, n:] = -_LOOSE * np.eye(4)
    inverse = np.linalg.inv(matrix)
    weights = inverse[:, :n] @ z
    return Spline(mu, weights), z - weights[:n] / np.diag(inverse)[:n, None]


def _kernel(a: FloatArray, b: FloatArray) -> FloatArray:
    """r^2 log r: (n, 3) and (m, 3) to (n, m)."""
    r2 = squared_distance(a, b)
    return np.asarray(0.5 * r2 * np.log(np.maximum(r2, np.finfo(float).tiny)))


def _polynomial(mu: FloatArray) -> FloatArray:
    """1 and mu: (n, 3) to (n, 4)."""
    return np.column_stack([np.ones(len(mu)), mu])
