"""Least squares without negative coefficients, and the shares with which closures are best picked.

All arrays may have more axes in front, of views that are solved at once.
"""

import numpy as np
from numpy.typing import NDArray

_FLOOR = 0.1                    # relative errors count in full above this fraction of the mean reflected radiance
_OVER = 5.0                     # weight of errors where the sum exceeds the target
_REWEIGHTINGS = 6               # of the errors where the sum exceeds the target
_LAST_STEPS = 150               # of the least squares
_ITERATIONS = 30                # of the shares, which then change by less than a percent
_LEAST_SHARE = 0.01             # so that every closure gets sampled


def weights(target: NDArray[np.float64], solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the squared errors, relative to the target above a floor: (n, channels) and (n,) to (n, channels)."""
    mean = solid_angle[..., None, :] @ target / np.pi
    return np.asarray(solid_angle[..., None] / (target + _FLOOR * mean + 1e-12))


def solve(basis: NDArray[np.float64], target: NDArray[np.float64], solid_angle: NDArray[np.float64],
          steps: int = _LAST_STEPS, reweightings: int = _REWEIGHTINGS) -> NDArray[np.float64]:
    """Coefficients of basis functions, none negative, whose sum is close to a target.

    Least squares of errors relative to the target; those where the sum exceeds it count `_OVER` times. D. D. Lee, H. S.
    Seung: Algorithms for Non-negative Matrix Factorization, NIPS 2000, have the steps, which keep coefficients positive
    and suit weights that change.

    Parameters
    ----------
    basis : (n, columns)
    target : (n, channels)
    solid_angle : (n,)
        Of each point; 0 for one that does not count.
    steps, reweightings : int

    Returns
    -------
    (columns, channels)
    """
    transposed = np.swapaxes(basis, -1, -2)
    weight = weights(target, solid_angle)
    scale = np.sqrt(transposed ** 2 @ weight.mean(axis=-1)[..., None]) + 1e-12
    basis = basis / np.swapaxes(scale, -1, -2)
    transposed = np.swapaxes(basis, -1, -2)
    x = np.full((*scale.shape[:-1], target.shape[-1]), 1e-3)
    reflected, found = (solid_angle[..., None, :] @ values for values in (target, basis @ x))
    x *= (reflected + 1e-12) / np.maximum(found, 1e-12)
    for _ in range(reweightings):
        w = weight * np.where(basis @ x > target, _OVER, 1.0)
        normal = np.stack([transposed @ (basis * w[..., c, None]) for c in range(w.shape[-1])], axis=-3)
        right = transposed @ (w * target)
        for _ in range(steps // reweightings):
            product = np.matmul(normal, np.swapaxes(x, -1, -2)[..., None])[..., 0]
            x *= (right + 1e-15) / (np.swapaxes(product, -1, -2) + 1e-15)
    largest = scale.max(axis=-2, keepdims=True)
    return np.asarray(np.where(scale > 1e-9 * largest, x / scale, 0))


def coordinate_descent(normal: NDArray[np.float64], right: NDArray[np.float64],
                       start: NDArray[np.float64] | None, sweeps: int) -> NDArray[np.float64]:
    """Least squares without negative coefficients, from normal equations of few unknowns.

    Parameters
    ----------
    normal : (..., k, k)
    right : (..., k)
    start : (..., k), optional
    sweeps : int
        Over the unknowns; each is set to its best value in turn.

    Returns
    -------
    (..., k)

    Examples
    --------
    >>> coordinate_descent(np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([1.0, -1.0]), None, 5)
    array([0.5, 0. ])
    """
    diagonal = np.einsum("...kk->...k", normal)
    x = np.maximum(right / diagonal, 0) / right.shape[-1] if start is None else start.copy()
    for _ in range(sweeps):
        for k in range(right.shape[-1]):
            slope = right[..., k] - (normal[..., k, :] * x).sum(axis=-1)
            x[..., k] = np.maximum(x[..., k] + slope / diagonal[..., k], 0)
    return np.asarray(x)


def shares(mixture: NDArray[np.float64], density: NDArray[np.float64],
           solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The best probability of picking each closure.

    It minimises the second moment of the estimate under an even light, the integral of M^2 / sum_k s_k p_k, by a
    fixed-point iteration that keeps the shares positive.

    Parameters
    ----------
    mixture : (n, channels)
        M, at points of the hemisphere.
    density : (closures, n)
        p_k, with which Cycles samples each closure, per solid angle.
    solid_angle : (n,)

    Returns
    -------
    (closures,), of sum 1
    """
    squared = mixture.mean(axis=-1) ** 2 * solid_angle
    found = np.full(density.shape[:-1], 1 / density.shape[-2])
    for _ in range(_ITERATIONS):
        together = np.maximum((found[..., None, :] @ density)[..., 0, :], 1e-9)
        found = found * np.sqrt((density @ (squared / together ** 2)[..., None])[..., 0])
        found = np.maximum(found / np.maximum(found.sum(axis=-1, keepdims=True), 1e-12), _LEAST_SHARE)
    return np.asarray(found / found.sum(axis=-1, keepdims=True))
