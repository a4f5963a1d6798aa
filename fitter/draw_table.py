"""The density from which the shader draws incident directions: a table that follows what the closure mixture leaves.

A cell of `directions.grid` is drawn with a probability that follows what is left in it; what remains to be done is in
`osl/draw.h`.
"""

import numpy as np

from .directions import RINGS, SECTORS, SUBSAMPLES

UNIFORM = 0.1               # this share is spread evenly over the hemisphere, so that no direction is drawn too rarely


def draw_table(rest, solid_angle):
    """Cumulated probabilities of the cells, by rings and within them by sectors.

    Parameters
    ----------
    rest : (VIEWS, n)
        Magnitude of what is to be drawn, at the points of `directions.grid`.
    solid_angle : (n,)

    Returns
    -------
    (VIEWS, RINGS * SECTORS) float32
    """
    share, uniform = _cells(rest * solid_angle), _cells(solid_angle[None])
    share = np.where(share.sum(axis=1, keepdims=True) > 0, share, uniform)
    share, uniform = share / share.sum(axis=1, keepdims=True), uniform / uniform.sum()
    table = np.cumsum((1 - UNIFORM) * share + UNIFORM * uniform, axis=1)
    table[:, -1] = 1
    return table.astype(np.float32)


def _cells(values):
    return values.reshape(-1, RINGS, SUBSAMPLES, SECTORS, SUBSAMPLES).sum(axis=(2, 4)).reshape(len(values), -1)
