"""Speed and size against error: the paper's fit at every (D, S, C) of a grid."""

import itertools

from ..model.fit import notation
from .comparison import compare
from .methods import levels

GRID = tuple(itertools.product((1, 4), (5, 6, 7), (90, 95, 99)))


def table(samples, grid=GRID):
    """The rows of `compare` for each (D, S, C), each with `levels` and `best` (see `mark_best`)."""
    rows = compare(samples, {notation(*choice): levels(*choice) for choice in grid})
    for row, choice in zip(rows, grid, strict=True):
        row["levels"] = choice
    return mark_best(rows)


def mark_best(rows, cost="bytes", error="held_out_cube_root_rmse"):
    """Set `best` in each row: whether no other is at least as good in cost and error, and better in one of them."""
    for row in rows:
        row["best"] = not any(other[cost] <= row[cost] and other[error] <= row[error]
                              and (other[cost], other[error]) != (row[cost], row[error]) for other in rows)
    return rows
