"""Least squares without negative coefficients, and the shares with which densities are best sampled.

All arrays may have more axes in front, of views that are solved at once.
"""

import numpy as np
from numpy.typing import NDArray

_ITERATIONS = 30                # of the shares, which then change by less than a percent
_LEAST_SHARE = 0.01             # so that every density gets sampled


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


def shares(magnitude: NDArray[np.float64], density: NDArray[np.float64],
           solid_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The best probability of sampling each of some densities.

    It minimises the second moment of the estimate under an even light, the integral of R^2 / sum_k s_k p_k, by a
    fixed-point iteration that keeps the shares positive.

    Parameters
    ----------
    magnitude : (..., n)
        |R|, at points of the hemisphere.
    density : (..., densities, n)
        p_k, per solid angle.
    solid_angle : (..., n)

    Returns
    -------
    (..., densities), of sum 1
    """
    squared = magnitude ** 2 * solid_angle
    found = np.full(density.shape[:-1], 1 / density.shape[-2])
    for _ in range(_ITERATIONS):
        together = np.maximum((found[..., None, :] @ density)[..., 0, :], 1e-9)
        found = found * np.sqrt((density @ (squared / together ** 2)[..., None])[..., 0])
        found = np.maximum(found / np.maximum(found.sum(axis=-1, keepdims=True), 1e-12), _LEAST_SHARE)
    return np.asarray(found / found.sum(axis=-1, keepdims=True))
