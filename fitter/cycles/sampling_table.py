"""The sampling table: the density from which the shader samples incident directions.

Each cell of a grid gets a probability in proportion to what the sampled directions have to carry there. The shader
samples the cells: `osl/sampling_table.h`, and for an anisotropic fit `osl/half_vector_table.h`.
"""

import numpy as np
from numpy.typing import NDArray

from .direction_grid import CELLS, Cells

_BESIDE = 0.1               # the least density of a cell, in that of a cell beside it
_SMALLEST = 1e-12           # solid angle of a cell (numerical)


def sampling_table(carried: NDArray[np.float64], solid_angle: NDArray[np.float64], reachable: NDArray[np.float64],
                   uniform: float, of: Cells = CELLS) -> NDArray[np.float32]:
    """Cumulative probabilities of the cells, ring by ring and within a ring by sectors.

    Parameters
    ----------
    carried : (views, n)
        Magnitude of the radiance that the sampled directions carry, at the points of a grid.
    solid_angle, reachable : (views, n)
        As `direction_grid.Directions` has them.
    uniform : float
        The share of the probability that is spread evenly over the hemisphere, so that no density is too low.
    of : Cells
        Those of the grid.

    Returns
    -------
    (views, cells) float32
    """
    size = of.gather(reachable).sum(axis=-1)
    density = of.gather(carried * solid_angle).sum(axis=-1) / np.maximum(size, _SMALLEST)
    share, even = _spread(density, of) * size, size / size.sum(axis=1, keepdims=True)
    total = share.sum(axis=1, keepdims=True)
    share = np.where(total > 0, share / np.where(total > 0, total, 1), even)
    table = np.cumsum((1 - uniform) * share + uniform * even, axis=1)
    table /= table[:, -1:]
    return table.astype(np.float32)


def _spread(density: NDArray[np.float64], of: Cells) -> NDArray[np.float64]:
    """Densities of cells, (views, cells), none much below that of a cell beside it: a peak that is narrower than a cell
    may reach there."""
    by_axis = density.reshape(-1, of.rings, of.sectors)
    padded = np.pad(by_axis, ((0, 0), (1, 1), (0, 0)), mode="edge")
    padded = np.pad(padded, ((0, 0), (0, 0), (1, 1)), mode="wrap" if of.around else "edge")
    beside = np.max([padded[:, :-2, 1:-1], padded[:, 2:, 1:-1], padded[:, 1:-1, :-2], padded[:, 1:-1, 2:]], axis=0)
    return np.asarray(np.maximum(by_axis, _BESIDE * beside).reshape(density.shape))
