"""Least squares without negative coefficients, and the shares with which densities are best sampled.

All arrays may have more axes in front, of views that are solved at once.
"""

import numpy as np
from numpy.typing import NDArray

from ..arrays import RealArray

_ITERATIONS = 30                # of the shares, which then change by less than a percent
_SMALL = 1e-12                  # what is rounding, of the largest right side, and of a diagonal element
_ROUNDS = 30                    # of pivoting, at most
_LEAST_SHARE = 0.01             # so that every density gets sampled


def nonnegative(normal: NDArray[np.float64], right: NDArray[np.float64],
                positive: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
    """Least squares without negative coefficients, from normal equations of few unknowns.

    By block principal pivoting: all unknowns that are on the wrong side change it at once or, where that did not
    lower their number twice, the last of them alone (L. F. Portugal, J. J. Judice, L. N. Vicente: A Comparison
    of Block Pivoting and Interior-Point Algorithms for Linear Least Squares Problems with Nonnegative Variables,
    Mathematics of Computation 63, 1994).

    Parameters
    ----------
    normal : (..., k, k)
        Positive semidefinite, no diagonal element 0.
    right : (..., k)
    positive : (..., k), optional
        Which are probably not 0, where that is known: it costs fewer rounds.

    Returns
    -------
    (..., k)

    Examples
    --------
    >>> nonnegative(np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([1.0, -1.0]))
    array([0.5, 0. ])
    """
    unknowns = right.shape[-1]
    scale = 1 / np.sqrt(np.einsum("...kk->...k", normal)).reshape(-1, unknowns)
    matrix = normal.reshape(-1, unknowns, unknowns) * scale[:, :, None] * scale[:, None] + _SMALL * np.eye(unknowns)
    target = right.reshape(-1, unknowns) * scale
    small = _SMALL * np.abs(target).max(axis=1, keepdims=True)
    free = target > 0 if positive is None else positive.reshape(target.shape).copy()
    fewest, patience = np.full(len(target), unknowns + 1), np.ones(len(target))
    for _ in range(_ROUNDS):
        equations = np.where(free[:, :, None] & free[:, None], matrix, np.eye(unknowns))
        found = np.linalg.solve(equations, np.where(free, target, 0)[..., None])[..., 0]
        slope = (matrix @ found[..., None])[..., 0] - target
        wrong = np.where(free, found, slope) < -small
        count = wrong.sum(axis=1)
        if not count.any():
            break
        fewer = count < fewest
        fewest, patience = np.where(fewer, count, fewest), np.where(fewer, 1, patience - 1)
        last = wrong & (np.cumsum(wrong, axis=1) == count[:, None])
        free ^= np.where((patience >= 0)[:, None], wrong, last)
    return np.asarray((np.maximum(found, 0) * scale).reshape(right.shape))


def shares(magnitude: RealArray, density: RealArray, solid_angle: RealArray) -> NDArray[np.float64]:
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
