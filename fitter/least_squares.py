"""Least squares: linear ones without negative coefficients, and nonlinear ones by damped Gauss-Newton."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np

from .arrays import BoolArray, FloatArray

_ROUNDED = 1e-12           # what is rounding, of the largest right side, and of a diagonal element
_ROUNDS = 30                # of pivoting, at most
_LEAST_DIAGONAL = 1e-9      # of normal equations


def nonnegative_least_squares(normal: FloatArray, right: FloatArray, positive: BoolArray | None = None) -> FloatArray:
    """Nonnegative least squares by block principal pivoting, from normal equations of few unknowns, (..., k, k),
    positive semidefinite with no diagonal element 0, and (..., k): (..., k). Axes in front are of problems that are
    solved at once.

    All unknowns that are on the wrong side change it at once or, where that did not lower their number twice, the last
    of them alone (L. F. Portugal, J. J. Judice, L. N. Vicente: A Comparison of Block Pivoting and Interior-Point
    Algorithms for Linear Least Squares Problems with Nonnegative Variables, Mathematics of Computation 63, 1994). To
    know which are probably `positive`, (..., k), costs fewer rounds.
    """
    unknowns = right.shape[-1]
    scale = 1 / np.sqrt(np.einsum("...kk->...k", normal)).reshape(-1, unknowns)
    matrix = normal.reshape(-1, unknowns, unknowns) * scale[:, :, None] * scale[:, None] + _ROUNDED * np.eye(unknowns)
    target = right.reshape(-1, unknowns) * scale
    small = _ROUNDED * np.abs(target).max(axis=1, keepdims=True)
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


_State = TypeVar("_State")


def levenberg_marquardt(start: FloatArray, evaluate: Callable[[FloatArray], tuple[float, _State]],
                        linearise: Callable[[FloatArray, _State], Callable[[float], FloatArray]], *, steps: int,
                        tries: int, grow: float, shrink: float, enough: float, damping: float = 1e-2,
                        ) -> tuple[FloatArray, float, _State]:
    """Nonlinear least squares by damped Gauss-Newton (K. Levenberg, Quarterly of Applied Mathematics 2(2), 1944; D. W.
    Marquardt, Journal of the Society for Industrial and Applied Mathematics 11(2), 1963): where the cost is least,
    (n,), the cost, and what else `evaluate` returned there.

    `linearise` takes that and returns the function of the damping to what is tried next, (n,): `damped_step`, perhaps
    within bounds. There are so many `steps`, linearisations, and `tries`, dampings, in each. The damping grows by a
    factor where a step is no better, and shrinks where it is; a step that lowers the cost by less than a share,
    `enough`, is the last.
    """
    x, (cost, state) = start, evaluate(start)
    for _ in range(steps):
        step, before = linearise(x, state), cost
        for _ in range(tries):
            tried = step(damping)
            after, there = evaluate(tried)
            if after < cost:
                x, cost, state, damping = tried, after, there, damping / shrink
                break
            damping *= grow
        if not before - cost > enough * before:
            break
    return x, cost, state


def damped_step(normal: FloatArray, right: FloatArray, damping: float) -> FloatArray:
    """The step of normal equations (n, n) and (n,), whose diagonal is larger by a share."""
    return np.asarray(np.linalg.solve(normal + damping * np.diag(np.diag(normal) + _LEAST_DIAGONAL), right))
