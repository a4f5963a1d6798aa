"""Normal equations of least-squares fits of lattices to many samples. All samples in one cell have nearly the same
control points, so that a cell adds a small matrix, the product of its samples' basis functions: each sample costs the
same, however many control points there are. The equations take the square of these in memory, and their solution the
cube in time."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from . import dense

_SAMPLES_TOGETHER = 1 << 14  # samples whose basis functions are computed at a time
_RIM = 1e-4                 # of the mean diagonal, added to that of each control point's gain


class NormalEquations:
    """The least-squares fit of a sum of lattices to samples at coordinates (n, axes) in their stored part. Control
    points at mirror images are equal: they are one unknown. Of each lattice are given its level, and the control points
    that it has, mirror images included: positions in the flattened box, (k,), or None for all of them."""

    def __init__(self, x: FloatArray, parts: Sequence[tuple[int, IntArray | None]]) -> None:
        self._grids, self._keys, images, size = [], [], [], 0
        for level, keys in parts:
            representative = dense.representative(level, x.shape[1]).ravel()
            keys = np.arange(len(representative)) if keys is None else keys
            images.append(size + representative[keys])
            self._grids.append(dense.Grid(x, level))
            self._keys.append(keys)
            size += len(representative)
        first, unknown = np.unique(np.concatenate(images), return_inverse=True)
        self._size, self._unknowns = len(first), np.split(unknown, np.cumsum([len(keys) for keys in self._keys])[:-1])
        # of each control point of a part its unknown, or -1
        self._columns = [np.full(math.prod(dense.shape(level, x.shape[1])), -1) for level, _ in parts]
        for column, keys, unknown in zip(self._columns, self._keys, self._unknowns, strict=True):
            column[keys] = unknown
        # samples in the order of the cells of the coarsest lattice: those in one share most control points of all
        coarsest = min(range(len(parts)), key=lambda part: parts[part][0])
        cells = self._grids[coarsest].first
        self._order = np.argsort(cells, kind="stable")
        starts = np.flatnonzero(np.diff(cells[self._order], prepend=-1)).tolist()
        self._cells = list(zip(starts, [*starts[1:], len(x)], strict=True))

    def solve(self, weights: FloatArray, z: FloatArray, norms: Sequence[FloatArray] = (),
              ridge: float = 1e-9) -> list[FloatArray]:
        """The control points of each lattice, (k, channels), that minimise the squares of weights (n,) times errors of
        z, (n, channels), and the lattices' norms: a quadratic form of the control points, (k, k), or its diagonal,
        (k,). The ridge is a share of the mean diagonal."""
        matrix, moment = self.reduced_system(weights, z, norms)
        if not len(matrix):
            return [moment]
        added = max(ridge * np.trace(matrix) / len(matrix), np.finfo(float).tiny)
        matrix[np.diag_indices(len(matrix))] += added
        solution = np.linalg.solve(matrix, moment)
        return [solution[unknowns] for unknowns in self._unknowns]

    def reduced_system(self, weights: FloatArray, z: FloatArray, norms: Sequence[FloatArray] = (),
                       ) -> tuple[FloatArray, FloatArray]:
        """The system of `solve`, one unknown for all mirror images of a control point: matrix and right side."""
        matrix, moment = np.zeros((self._size, self._size)), np.zeros((self._size, z.shape[1]))
        # the norms
        for norm, unknowns in zip(norms, self._unknowns, strict=False):
            if norm.ndim == 1:
                matrix[np.diag_indices(self._size)] += np.bincount(unknowns, norm, self._size)
            else:
                at, folded = _fold_form(norm, unknowns)
                matrix[at[:, None], at] = folded
        present, place = np.zeros(self._size + 1, dtype=bool), np.zeros(self._size + 1, dtype=int)
        # the samples, by cell
        for _, together in itertools.groupby(self._cells, lambda cell: cell[0] // _SAMPLES_TOGETHER):
            group = list(together)
            rows = self._order[group[0][0]:group[-1][1]]
            weight = weights[rows, None]
            basis = np.concatenate([grid.basis(rows) for grid in self._grids], axis=1) * weight
            wanted = z[rows] * weight
            taps = np.concatenate([column[grid.taps(rows[:, None])]
                                   for grid, column in zip(self._grids, self._columns, strict=True)], axis=1)
            for start, stop in group:
                part = slice(start - group[0][0], stop - group[0][0])
                # the basis functions of the unknowns of this cell, images together; what is not stored comes last
                present[taps[part]] = True
                present[-1] = False
                used = np.flatnonzero(present)
                present[used] = False
                place[used], place[-1] = np.arange(len(used)), len(used)
                at = place[taps[part]] + (len(used) + 1) * np.arange(stop - start)[:, None]
                of_cell = np.bincount(at.ravel(), basis[part].ravel(), (stop - start) * (len(used) + 1))
                of_cell = of_cell.reshape(stop - start, -1)[:, :-1]
                matrix[used[:, None], used] += of_cell.T @ of_cell
                moment[used] += of_cell.T @ wanted[part]
        return matrix, moment


def _fold_form(norm: FloatArray, unknowns: IntArray) -> tuple[IntArray, FloatArray]:
    """A quadratic form of control points as one of their unknowns: (k, k) and (k,) to those that it has and (u, u)."""
    used = np.flatnonzero(np.diagonal(norm))            # it is positive semidefinite: rows of the others are 0
    order = used[np.argsort(unknowns[used])]
    first = np.flatnonzero(np.diff(unknowns[order], prepend=-1))
    ordered = norm[order[:, None], order]
    if len(first) < len(order):
        ordered = np.add.reduceat(np.add.reduceat(ordered, first, axis=0), first, axis=1)
    return unknowns[order[first]], ordered


def gains(x: FloatArray, level: int, weights: FloatArray, z: FloatArray) -> FloatArray:
    """By how much each control point alone, with its mirror images, can lower the weighted squared error: the flattened
    box, (points,), for samples at x (n, axes) of weights (n,), where the lattice is to approximate z (n, channels)."""
    grid, size = dense.Grid(x, level), math.prod(dense.shape(level, x.shape[1]))
    moment, diagonal = np.zeros((size, z.shape[1])), np.zeros(size)
    for start in range(0, len(x), _SAMPLES_TOGETHER):
        rows = np.arange(start, min(start + _SAMPLES_TOGETHER, len(x)))
        basis = grid.basis(rows) * weights[rows, None]
        taps = grid.taps(rows[:, None]).ravel()
        diagonal += np.bincount(taps, (basis ** 2).ravel(), size)
        for channel, column in enumerate((z[rows] * weights[rows, None]).T):
            moment[:, channel] += np.bincount(taps, (basis * column[:, None]).ravel(), size)
    representative = dense.representative(level, x.shape[1]).ravel()
    diagonal = np.bincount(representative, diagonal, size).astype(float)
    moment = np.stack([np.bincount(representative, column, size) for column in moment.T], axis=1)
    # a control point at the rim of the samples would have to be huge to do anything
    gain = (moment ** 2).sum(axis=1) / (diagonal + _RIM * diagonal.mean() + np.finfo(float).tiny)
    return np.asarray(gain[representative])


def select_largest(magnitude: FloatArray, representative: IntArray, count: int) -> IntArray:
    """The largest of a lattice's control points that are not 0, at most `count` with their mirror images: ascending
    positions in the flattened box, of magnitudes (points,), of which only those of `dense.representative` count."""
    copies = np.bincount(representative, minlength=len(magnitude))
    order = np.argsort(-magnitude * (copies > 0), kind="stable")
    order = order[:np.count_nonzero(magnitude[copies > 0])]
    chosen = np.zeros(len(magnitude), dtype=bool)
    chosen[order[:np.searchsorted(np.cumsum(copies[order]), count, side="right")]] = True
    return np.flatnonzero(chosen[representative])
