"""The sampling table: the density from which the shader samples incident directions.

Each cell of `direction_grid.grid` gets a probability in proportion to what the sampled directions have to carry there.
`osl/sampling_table.h` samples the cells.
"""

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import RINGS, SECTORS
from . import direction_grid

_BESIDE = 0.1               # the least density of a cell, in that of a cell beside it
_SMALLEST = 1e-12           # solid angle of a cell (numerical)


def sampling_table(carried: NDArray[np.float64], solid_angle: NDArray[np.float64], reachable: NDArray[np.float64],
                   uniform: float) -> NDArray[np.float32]:
    """Cumulative probabilities of the cells, ring by ring and within a ring by sectors.

    Parameters
    ----------
    carried : (VIEWS, n)
        Magnitude of the radiance that the sampled directions carry, at the points of `direction_grid.grid`.
    solid_angle, reachable : (VIEWS, n)
        As `direction_grid.Directions` has them.
    uniform : float
        The share of the probability that is spread evenly over the hemisphere, so that no density is too low.

    Returns
    -------
    (VIEWS, RINGS * SECTORS) float32
    """
    size = _cells(reachable)
    density = _cells(carried * solid_angle) / np.maximum(size, _SMALLEST)
    share, even = _spread(density) * size, size / size.sum(axis=1, keepdims=True)
    total = share.sum(axis=1, keepdims=True)
    share = np.where(total > 0, share / np.where(total > 0, total, 1), even)
    table = np.cumsum((1 - uniform) * share + uniform * even, axis=1)
    table /= table[:, -1:]
    return table.astype(np.float32)


def _spread(density: NDArray[np.float64]) -> NDArray[np.float64]:
    """Densities of cells, (views, RINGS * SECTORS), none much below that of a cell beside it: a peak that is narrower
    than a cell may reach there."""
    by_axis = density.reshape(-1, RINGS, SECTORS)
    padded = np.pad(by_axis, ((0, 0), (1, 1), (1, 1)), mode="edge")
    beside = np.max([padded[:, :-2, 1:-1], padded[:, 2:, 1:-1], padded[:, 1:-1, :-2], padded[:, 1:-1, 2:]], axis=0)
    return np.asarray(np.maximum(by_axis, _BESIDE * beside).reshape(density.shape))


def _cells(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum over each cell: (views, n) to (views, RINGS * SECTORS)."""
    return np.stack([direction_grid.cells(view).sum(axis=1) for view in values])
