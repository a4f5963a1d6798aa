"""Normal equations of least-squares fits of lattices to many samples.

All samples in one cell of a lattice have the same control points, so that a cell adds a small matrix, the product of
its samples' basis functions, to the normal equations. Each sample costs the same, however many control points there
are. The equations take the square of these in memory, and their solution the cube in time.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from . import dense

_TOGETHER = 1 << 14         # samples whose basis functions are computed at a time
_TINY = 1e-9                # of the mean diagonal, that makes equations solvable
_RIM = 1e-4                 # of the mean diagonal, added to that of each control point's gain


class NormalEquations:
    """The least-squares fit of a sum of lattices to samples.

    Control points at mirror images are equal: they are one unknown.

    Parameters
    ----------
    x : (n, axes) float64
        Coordinates in the stored part of the lattices.
    parts : sequence of (int, (k,) int, or None)
        The level of each lattice, and the control points that it has: positions in the flattened box of `dense.shape`,
        mirror images included; None for all of them.
    """

    def __init__(self, x: FloatArray, parts: Sequence[tuple[int, IntArray | None]]) -> None:
        self._grids, self._columns, self._sizes, images = [], [], [], []
        size = 0
        for level, keys in parts:
            all_keys = np.arange(math.prod(dense.shape(level, x.shape[1])))
            keys = all_keys if keys is None else keys
            column = np.full(len(all_keys), -1)
            column[keys] = size + np.arange(len(keys))
            images.append(column[dense.representative(level, x.shape[1]).ravel()[keys]])
            self._grids.append(dense.Grid(x, level))
            self._columns.append(column)
            self._sizes.append(len(keys))
            size += len(keys)
        image_of = np.concatenate(images)
        self._first, self._unknown = np.unique(image_of, return_inverse=True)
        self._copies = _copies(image_of)
        # samples in the order of the cells of the finest lattice: those in one share the cells of all
        finest = max(range(len(parts)), key=lambda part: parts[part][0])
        cells = self._grids[finest].first
        self._order = np.argsort(cells, kind="stable")
        starts = np.flatnonzero(np.diff(cells[self._order], prepend=-1)).tolist()
        self._cells = list(zip(starts, [*starts[1:], len(x)], strict=True))

    def solve(self, weights: FloatArray, z: FloatArray, norms: Sequence[FloatArray]) -> list[FloatArray]:
        """The control points that minimise the weighted squared error and the lattices' norms.

        Parameters
        ----------
        weights : (n,) float64
            Errors are multiplied by these.
        z : (n, channels) float64
        norms : sequence of (k, k) float64
            Quadratic forms of the control points of each lattice.

        Returns
        -------
        list of (k, channels) float64
            Of each lattice.
        """
        matrix, moment = self.reduced(weights, z, norms)
        if not len(matrix):
            return [moment]
        matrix[np.diag_indices(len(matrix))] += max(_TINY * np.trace(matrix) / len(matrix), np.finfo(float).tiny)
        control_points = np.linalg.solve(matrix, moment)[self._unknown]
        return np.split(control_points, np.cumsum(self._sizes)[:-1])

    def reduced(self, weights: FloatArray, z: FloatArray, norms: Sequence[FloatArray] = (),
                ) -> tuple[FloatArray, FloatArray]:
        """The equations of `solve`, of one unknown for all images of a control point: matrix and right side."""
        matrix, moment = self._assembled(weights, z)
        first = 0
        for norm in norms:
            part = slice(first, first + len(norm))
            matrix[part, part] += norm
            first += len(norm)
        for originals, copies in self._copies:
            matrix[originals] += matrix[copies]
            matrix[:, originals] += matrix[:, copies]
            moment[originals] += moment[copies]
        return matrix[self._first[:, None], self._first], moment[self._first]

    def _assembled(self, weights: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The matrix and the right side, mirror images apart."""
        size = len(self._unknown)
        matrix, moment = np.zeros((size, size)), np.zeros((size, z.shape[1]))
        for _, together in itertools.groupby(self._cells, lambda cell: cell[0] // _TOGETHER):
            group = list(together)
            rows = self._order[group[0][0]:group[-1][1]]
            weight = weights[rows, None]
            bases, wanted = [grid.basis(rows) * weight for grid in self._grids], z[rows] * weight
            for start, stop in group:
                part = slice(start - group[0][0], stop - group[0][0])
                taps = np.concatenate([column[grid.taps(rows[part.start])]
                                       for grid, column in zip(self._grids, self._columns, strict=True)])
                stored = taps >= 0
                taps, basis = taps[stored], np.concatenate([each[part] for each in bases], axis=1)[:, stored]
                matrix[taps[:, None], taps] += basis.T @ basis
                moment[taps] += basis.T @ wanted[part]
        return matrix, moment


def gains(x: FloatArray, level: int, weights: FloatArray, z: FloatArray) -> FloatArray:
    """By how much each control point alone can lower the weighted squared error: the flattened box, (points,) float64.

    Its mirror images move with it.

    Parameters
    ----------
    x : (n, axes) float64
    weights : (n,) float64
    z : (n, channels) float64
        What the lattice is to approximate.
    """
    grid, size = dense.Grid(x, level), math.prod(dense.shape(level, x.shape[1]))
    moment, diagonal = np.zeros((size, z.shape[1])), np.zeros(size)
    for start in range(0, len(x), _TOGETHER):
        rows = np.arange(start, min(start + _TOGETHER, len(x)))
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


def _copies(image_of: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Those that are images of others, as lists of (originals, images) in which no original comes twice.

    Examples
    --------
    >>> [(a.tolist(), b.tolist()) for a, b in _copies(np.array([0, 1, 0, 1, 0, 5]))]
    [([0, 1], [2, 3]), ([0], [4])]
    """
    copies = np.flatnonzero(image_of != np.arange(len(image_of)))
    lists: list[tuple[IntArray, IntArray]] = []
    while len(copies):
        originals, at = np.unique(image_of[copies], return_index=True)
        lists.append((np.asarray(originals), copies[at]))
        copies = np.delete(copies, at)
    return lists
