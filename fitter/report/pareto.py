"""Speed and size against error: the paper's fit at every (D, S, C) of a grid."""

import itertools
from collections.abc import Sequence

from ..model.fit import notation
from ..samples import Samples
from .comparison import compare
from .methods import levels
from .rows import Row

GRID = tuple(itertools.product((1, 4), (5, 6, 7), (90, 95, 99)))


def table(samples: Samples, grid: Sequence[tuple[int, int, float]] = GRID) -> list[Row]:
    """The rows of `compare` for each (D, S, C), with `levels` and `best` (see `mark_best`) added."""
    rows = compare(samples, {notation(*choice): levels(*choice) for choice in grid})
    for row, choice in zip(rows, grid, strict=True):
        row["levels"] = choice
    return mark_best(rows)


def mark_best(rows: list[Row], cost: str = "bytes", error: str = "held_out_cube_root_rmse") -> list[Row]:
    """Set `best` in each row that is Pareto optimal: no other row is better in cost or error, and as good in both.

    Examples
    --------
    >>> rows = [{"bytes": 1, "rmse": 3}, {"bytes": 2, "rmse": 1}, {"bytes": 3, "rmse": 2}]
    >>> [row["best"] for row in mark_best(rows, error="rmse")]
    [True, True, False]
    """
    for row in rows:
        row["best"] = not any(other[cost] <= row[cost] and other[error] <= row[error]
                              and (other[cost], other[error]) != (row[cost], row[error]) for other in rows)
    return rows
