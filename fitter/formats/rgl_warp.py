"""The map between half vectors u and the grid s of an RGL table: that which makes a tabulated density p uniform
(docs/layouts.md, RGL) ::

    s_x = int_0^{u_x} p(x, u_y) dx / m(u_y),    s_y = int_0^{u_y} m(y) dy,    m(y) = int p(x, y) dx
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Warp:
    """Densities over the unit square, in units of a cell, and their integrals."""

    density: FloatArray     # (slices, ny, nx), each of which integrates to 1
    along: FloatArray       # (slices, ny, nx), the integral along x from the row's start
    marginal: FloatArray    # (slices, ny), the integral over the rows up to this one


def warp(density: FloatArray) -> Warp:
    """Normalise densities (slices, ny, nx) and integrate them; every slice must have a positive sum."""
    along = _integral(density)
    marginal = _integral(along[..., -1])
    total = marginal[:, -1]
    return Warp(density / total[:, None, None], along / total[:, None, None], marginal / total[:, None])


def to_grid(warp: Warp, slices: Sequence[tuple[IntArray, FloatArray]], x: FloatArray,
            y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The place in the grid, s, (n,) each, of points u = (x, y), (n,); both in the unit square.

    The densities of `slices` are blended by their weights, which sum to 1, (n,) each. s_x is 0 where the density of a
    whole row is 0.
    """
    rows, columns = warp.density.shape[1:]
    j, b = cell(y, rows)
    i, a = cell(x, columns)

    def blend_slices(table: FloatArray, *place: IntArray) -> FloatArray:
        return sum((weight * table[(index, *place)] for index, weight in slices), np.zeros(1))

    def interpolate_table(table: FloatArray, column: IntArray) -> FloatArray:
        return (1 - b) * blend_slices(table, j, column) + b * blend_slices(table, j + 1, column)

    last = np.full_like(i, columns - 1)
    left, right = interpolate_table(warp.density, i), interpolate_table(warp.density, i + 1)
    row = interpolate_table(warp.along, last)
    part = interpolate_table(warp.along, i) + a * (left + a * (right - left) / 2)
    low, high = blend_slices(warp.along, j, last), blend_slices(warp.along, j + 1, last)
    s_y = blend_slices(warp.marginal, j) + b * (low + b * (high - low) / 2)
    return np.divide(part, row, out=np.zeros_like(part), where=row > 0), s_y


def from_grid(warp: Warp, index: int, s_x: FloatArray, s_y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The points u, (rows, columns) and (rows,), of a grid of places s, (columns,) and (rows,), for one slice; the
    inverse of `to_grid`.
    """
    density, along, marginal = warp.density[index], warp.along[index], warp.marginal[index]
    j = np.clip(np.searchsorted(marginal, s_y) - 1, 0, len(marginal) - 2)
    b = _crossing(along[j, -1], along[j + 1, -1], s_y - marginal[j])
    density, along = ((1 - b)[:, None] * table[j] + b[:, None] * table[j + 1] for table in (density, along))
    part = s_x * along[:, -1:]
    i = np.clip((along[:, None, :] < part[..., None]).sum(axis=-1) - 1, 0, along.shape[1] - 2)
    start, end, before = (np.take_along_axis(table, column, axis=1)
                          for table, column in ((density, i), (density, i + 1), (along, i)))
    return (i + _crossing(start, end, part - before)) / (along.shape[1] - 1), (j + b) / (len(marginal) - 1)


def cell(x: FloatArray, nodes: int) -> tuple[IntArray, FloatArray]:
    """The cell of a row of nodes over 0 to 1 in which x is, and the place in it, 0 to 1."""
    x = x * (nodes - 1)
    index = np.clip(x.astype(np.int64), 0, nodes - 2)
    return index, x - index


def _integral(density: FloatArray) -> FloatArray:
    """The integral of a linear interpolation along the last axis, up to each node."""
    return np.concatenate([np.zeros((*density.shape[:-1], 1)),
                           np.cumsum((density[..., 1:] + density[..., :-1]) / 2, axis=-1)], axis=-1)


def _crossing(start: FloatArray, end: FloatArray, integral: FloatArray) -> FloatArray:
    """How far into a cell, 0 to 1, a density that is linear from start to end has a given integral."""
    root = np.sqrt(np.maximum(start ** 2 + 2 * (end - start) * integral, 0))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.clip(np.nan_to_num(2 * integral / (start + root)), 0, 1)
