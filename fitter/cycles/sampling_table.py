"""The density from which the shader draws incident directions: a table that follows what the closure mixture leaves.

A cell of `directions.grid` is drawn with a probability that follows what is left in it; what remains to be done is in
`osl/draw.h`.
"""

import numpy as np

from .direction_grid import RINGS, SECTORS, SUBSAMPLES


def draw_table(rest, solid_angle, uniform):
    """Cumulated probabilities of the cells, by rings and within them by sectors.

    Parameters
    ----------
    rest : (VIEWS, n)
        Magnitude of what is to be drawn, at the points of `directions.grid`.
    solid_angle : (n,)
    uniform : float
        This share is spread evenly over the hemisphere, so that no direction is drawn too rarely.

    Returns
    -------
    (VIEWS, RINGS * SECTORS) float32
    """
    share, even = _cells(rest * solid_angle), _cells(solid_angle[None])
    share = np.where(share.sum(axis=1, keepdims=True) > 0, share, even)
    share, even = share / share.sum(axis=1, keepdims=True), even / even.sum()
    table = np.cumsum((1 - uniform) * share + uniform * even, axis=1)
    table[:, -1] = 1
    return table.astype(np.float32)


def _cells(values):
    return values.reshape(-1, RINGS, SUBSAMPLES, SECTORS, SUBSAMPLES).sum(axis=(2, 4)).reshape(len(values), -1)
