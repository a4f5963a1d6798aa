"""The sampling tables: the density from which the shader samples incident directions.

Each cell of `direction_grid.grid` gets a probability in proportion to what the sampled directions have to carry there.
`osl/sampling_table.h` samples the cells.
"""

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import RINGS, SECTORS
from .direction_grid import SUBSAMPLES


def sampling_table(carried: NDArray[np.float64], solid_angle: NDArray[np.float64],
                   uniform: float) -> NDArray[np.float32]:
    """Cumulative probabilities of the cells, ring by ring and within a ring by sectors.

    Parameters
    ----------
    carried : (VIEWS, n)
        Magnitude of the radiance that the sampled directions carry, at the points of `direction_grid.grid`.
    solid_angle : (n,)
    uniform : float
        The share of the probability that is spread evenly over the hemisphere, so that no density is too low.

    Returns
    -------
    (VIEWS, RINGS * SECTORS) float32
    """
    share, even = _cells(carried * solid_angle), _cells(solid_angle[None])
    share = np.where(share.sum(axis=1, keepdims=True) > 0, share, even)
    share, even = share / share.sum(axis=1, keepdims=True), even / even.sum()
    table = np.cumsum((1 - uniform) * share + uniform * even, axis=1)
    table[:, -1] = 1
    return table.astype(np.float32)


def _cells(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sum over each cell: (views, n) to (views, RINGS * SECTORS)."""
    return values.reshape(-1, RINGS, SUBSAMPLES, SECTORS, SUBSAMPLES).sum(axis=(2, 4)).reshape(len(values), -1)
