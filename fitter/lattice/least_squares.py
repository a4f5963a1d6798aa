"""Least-squares fits of sparse lattices.

Kameya and Lewis (2002, section 4.1) keep the largest control points of a full lattice as they are. Here the kept ones
are fitted again, all together, by least squares; far fewer then reach the same error.
"""

import numpy as np

from ..arrays import FloatArray, IntArray
from . import dense, mba, perfect_hash
from .sparse import SparseLattice

RIDGE = 1e-2                # relative to the mean diagonal of the normal equations: keeps the spline from overshooting
                            # between close samples of different values


def sparse_fit(x: FloatArray, z: FloatArray, weights: FloatArray, level: int, count: int) -> SparseLattice:
    """Fit some thousands of weighted samples by a sparse lattice: coordinates (n, 3) in its stored quarter, values (n,
    channels), and weights (n,) of their errors. At most `count` control points are kept, mirror images included."""
    # control points at mirror images are equal: they are kept, and fitted, as one unknown
    representative = dense.representative(level).ravel()
    magnitude = np.abs(mba.basis_approximation(x, z * weights[:, None], level)).max(axis=-1).ravel()
    first, keys = select_largest(magnitude, representative, count)
    unknown = np.full(len(representative), -1)
    unknown[first] = np.arange(len(first))
    unknown = unknown[representative]
    solution = _least_squares(_design(x, weights, level, unknown, len(first)), z * weights[:, None])
    index = perfect_hash.build(keys)
    return SparseLattice(level, index, solution[unknown[index.keys]].astype(np.float32))


def select_largest(magnitude: FloatArray, representative: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Choose the largest of a lattice's control points that are not 0, at most `count` with their mirror images.

    Takes the magnitude, at least 0, of each point of the flattened box, (points,), of which only those of
    representatives count, and the representative of each, (points,), as `dense.representative` has them. Returns the
    chosen representatives, largest first, (unknowns,), and these with their mirror images, in ascending order, (k,).
    """
    copies = np.bincount(representative, minlength=len(magnitude))
    order = np.argsort(-magnitude * (copies > 0), kind="stable")
    order = order[:np.count_nonzero(magnitude[copies > 0])]
    first = order[:np.searchsorted(np.cumsum(copies[order]), count, side="right")]
    chosen = np.zeros(len(magnitude), dtype=bool)
    chosen[first] = True
    return first, np.flatnonzero(chosen[representative])


def _least_squares(design: FloatArray, z: FloatArray) -> FloatArray:
    """The solution of a ridge regression, (unknowns, channels): of a design matrix (n, unknowns) and (n, channels)."""
    samples, unknowns = design.shape
    # with fewer equations than unknowns, the dual system is smaller
    gram = design @ design.T if samples <= unknowns else design.T @ design
    gram[np.diag_indices(len(gram))] += RIDGE * max(np.trace(gram) / max(unknowns, 1), np.finfo(float).tiny)
    if samples <= unknowns:
        return np.asarray(design.T @ np.linalg.solve(gram, z), dtype=float)
    return np.asarray(np.linalg.solve(gram, design.T @ z), dtype=float)


def _design(x: FloatArray, weights: FloatArray, level: int, unknown: IntArray, count: int) -> FloatArray:
    """The design matrix, (n, count): the weighted basis function of each unknown at the samples; `unknown` holds each
    control point's, or -1."""
    grid, samples = dense.Grid(x, level), np.arange(len(x))
    tap, basis = unknown[grid.taps(samples[:, None])], grid.basis(samples)
    at = samples[:, None] * (count + 1) + np.where(tap < 0, count, tap)
    design = np.bincount(at.ravel(), basis.ravel(), len(tap) * (count + 1)).reshape(len(tap), -1)[:, :count]
    return design * weights[:, None]
