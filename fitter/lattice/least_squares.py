"""Choosing the control points of a sparse lattice, and making up for those that are dropped.

The paper keeps the largest coefficients of a lattice that was fitted with all of them. Here the kept ones are fitted
once more, all together, by least squares: far fewer do as well.
"""

import numpy as np

from . import dense, mba, perfect_hash
from .sparse import SparseLattice

RIDGE = 1e-2                # relative to the mean of the diagonal of the normal equations: keeps near samples of
                            # different values from pulling their surroundings apart
_CHUNK = 2048


def sparse_fit(x, z, weights, level, count):
    """The sparse lattice of `count` control points that fits weighted samples best.

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in the stored quarter of the lattice.
    z : (n, channels) float64
    weights : (n,) float64
        How much an error at each sample counts.
    level : int
    count : int
        Control points to keep, mirror images counted: at most this many.

    Returns
    -------
    SparseLattice
    """
    # a lattice with the symmetries has equal control points at mirror images: they are kept, and fitted, together
    stands_for = dense.representative(level).ravel()
    first, keys = _largest(mba.basis_approximation(x, z * weights[:, None], level), stands_for, count)
    unknown = np.full(len(stands_for), -1)
    unknown[first] = np.arange(len(first))
    unknown = unknown[stands_for]
    solution = _least_squares(x, z, weights, level, unknown, len(first))
    index = perfect_hash.build(keys)
    return SparseLattice(level, index, solution[unknown[index.keys]].astype(np.float32))


def _largest(control_points, stands_for, count):
    """The largest control points, by those that stand for them, and the keys of all of their images."""
    magnitude = np.abs(control_points).max(axis=-1).ravel()
    copies = np.bincount(stands_for, minlength=len(magnitude))
    order = np.argsort(-magnitude * (copies > 0), kind="stable")
    order = order[:np.count_nonzero(magnitude[copies > 0])]
    first = order[:np.searchsorted(np.cumsum(copies[order]), count, side="right")]
    chosen = np.zeros(len(magnitude), dtype=bool)
    chosen[first] = True
    return first, np.flatnonzero(chosen[stands_for])


def _least_squares(x, z, weights, level, unknown, count):
    """Solve for `count` unknowns, `unknown` giving that of each control point or -1: (count, channels) float64."""
    if len(x) <= count:         # fewer equations than unknowns: the same solution from the smaller system
        design = _design(x, weights, level, unknown, count)
        gram = design @ design.T
        gram[np.diag_indices(len(x))] += _ridge(np.trace(gram), count)
        return design.T @ np.linalg.solve(gram, z * weights[:, None])
    normal, moment = np.zeros((count, count)), np.zeros((count, z.shape[1]))
    for start in range(0, len(x), _CHUNK):
        part = slice(start, start + _CHUNK)
        design = _design(x[part], weights[part], level, unknown, count)
        normal += design.T @ design
        moment += design.T @ (z[part] * weights[part, None])
    normal[np.diag_indices(count)] += _ridge(np.trace(normal), count)
    return np.linalg.solve(normal, moment)


def _design(x, weights, level, unknown, count):
    """What each unknown adds to the weighted spline at the samples: (n, count) float64."""
    _, rows, columns = dense.shape(level)
    corner = ((np.arange(4)[:, None, None] * rows + np.arange(4)[:, None]) * columns + np.arange(4)).ravel()
    cell, (wa, wb, wc) = dense.locate(x, level)
    tap = unknown[((cell[:, 0] * rows + cell[:, 1]) * columns + cell[:, 2])[:, None] + corner]
    basis = (wa[:, :, None, None] * wb[:, None, :, None] * wc[:, None, None, :]).reshape(len(tap), 64)
    at = np.arange(len(tap))[:, None] * (count + 1) + np.where(tap < 0, count, tap)
    design = np.bincount(at.ravel(), basis.ravel(), len(tap) * (count + 1)).reshape(len(tap), -1)[:, :count]
    return design * weights[:, None]


def _ridge(trace, count):
    return RIDGE * max(trace / max(count, 1), np.finfo(float).tiny)
