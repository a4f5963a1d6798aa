"""The density from which the shader draws incident directions: a table that follows the fit.

For each of `VIEWS` outgoing angles, evenly spaced from the normal to the horizon, half of the unit disk onto which the
hemisphere projects is divided into `RINGS` x `SECTORS` cells of equal area, evenly spaced in r^2 and in azimuth from
that of the outgoing direction. A cell is drawn with a probability that follows the mean of the fit over it; the rest of
it is done by `osl/draw.h`.
"""

import numpy as np

VIEWS = 24
RINGS = 32
SECTORS = 24
UNIFORM = 0.1               # this share is spread evenly, so that no direction is drawn too rarely
_SUBSAMPLES = 2


def draw_table(fit):
    """Cumulated probabilities of the cells, by rings and within them by sectors: (VIEWS, RINGS * SECTORS) float32."""
    theta_o = np.linspace(0, np.pi / 2, VIEWS)
    theta_i = np.arcsin(np.sqrt(_midpoints(RINGS)))
    azimuth = _midpoints(SECTORS) * np.pi
    shape = np.broadcast_shapes((VIEWS, 1, 1), (1, len(theta_i), 1), (1, 1, len(azimuth)))
    value = fit.evaluate(theta_i[:, None], azimuth, theta_o[:, None, None], 0).reshape(*shape, -1)
    value = np.maximum(value, 0).sum(axis=-1)
    value = value.reshape(VIEWS, RINGS, _SUBSAMPLES, SECTORS, _SUBSAMPLES).sum(axis=(2, 4)).reshape(VIEWS, -1)
    total = value.sum(axis=1, keepdims=True)
    share = np.divide(value, total, out=np.full_like(value, 1 / value.shape[1]), where=total > 0)
    table = np.cumsum((1 - UNIFORM) * share + UNIFORM / share.shape[1], axis=1)
    table[:, -1] = 1
    return table.astype(np.float32)


def _midpoints(cells):
    count = cells * _SUBSAMPLES
    return (np.arange(count) + 0.5) / count
