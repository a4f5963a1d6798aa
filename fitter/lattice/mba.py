"""Multilevel B-spline approximation of scattered data in three dimensions.

S. Lee, G. Wolberg, S. Y. Shin: Scattered Data Interpolation with Multilevel B-Splines, IEEE TVCG 3(3), 1997; taken to
reflectance in Nusselt coordinates by Kameya and Lewis 2002. The samples are fitted together with their mirror images,
which makes every lattice symmetric and lets `dense` store a quarter of it.
"""

import numpy as np

from . import dense

_CHUNK = 32768              # points at a time: their 64 taps take 100 MB


def mirror_images(x, level):
    """The samples and those of their mirror images that the stored quarter of the lattice feels.

    Parameters
    ----------
    x : (n, 3) float64
        Nusselt coordinates.

    Returns
    -------
    points : (m, 3) float64
    of : (m,) int
        Which sample each point is an image of; the first n are the samples themselves.
    """
    bilateral = x * [1, 1, -1] + [0, 0, 1]
    half_turn = x * [-1, -1, 1] + [1, 1, 0]
    both = x * [-1, -1, -1] + 1
    points = np.concatenate([x, bilateral, half_turn, both])
    of = np.tile(np.arange(len(x)), 4)
    first = np.floor(points * dense.cells(level)) - 1 - dense.origin(level)
    felt = (first[:, 0] > -4) & (first[:, 2] > -4)
    felt[:len(x)] = True
    return points[felt], of[felt]


def basis_approximation(x, z, level):
    """BA: the lattice that each sample pulls toward its value, and the weights with which they do.

    Parameters
    ----------
    x : (n, 3) float64
        Nusselt coordinates.
    z : (n, channels) float64

    Returns
    -------
    lattice.shape(level) + (channels,) float64
        Control points: the w^2-weighted mean of what their samples ask for, 0 where there are none
        (Lee, Wolberg and Shin 1997, section 3.1, equations 3 to 5).
    """
    points, of = mirror_images(x, level)
    omega = np.zeros(np.prod(dense.shape(level)))
    delta = np.zeros((len(omega), z.shape[1]))
    for start in range(0, len(points), _CHUNK):
        tap, w, cube = _taps(points[start:start + _CHUNK], level)
        omega += np.bincount(tap, (w * w).ravel(), minlength=len(omega))
        for channel, values in enumerate(z[of[start:start + _CHUNK]].T):
            delta[:, channel] += np.bincount(tap, (cube * values[:, None]).ravel(), minlength=len(omega))
    inverse = np.divide(1, omega, out=np.zeros_like(omega), where=omega > 0)
    return (delta * inverse[:, None]).reshape(*dense.shape(level), -1)


def _taps(points, level):
    """The 64 control points of each point, their weights w and w^3 / sum(w^2): (64 m,), (m, 64) and (m, 64)."""
    first, (wa, wb, wc) = dense.locate(points, level)
    box = np.array(dense.shape(level))
    index = first[:, None, :] + np.arange(4)[:, None]                   # (m, 4, 3)
    stored = (index >= 0) & (index < box)
    index = np.where(stored, index, 0)
    w_squared = 1.0
    for w in (wa, wb, wc):
        w_squared = w_squared * (w * w).sum(axis=1)

    # taps outside the box get weight 0: their control points are mirror images of stored ones
    wa, wb, wc = (np.where(stored[:, :, axis], w, 0) for axis, w in enumerate((wa, wb, wc)))
    tap = ((index[:, :, None, None, 0] * box[1] + index[:, None, :, None, 1]) * box[2]
           + index[:, None, None, :, 2]).ravel()
    w = (wa[:, :, None, None] * wb[:, None, :, None] * wc[:, None, None, :]).reshape(len(points), 64)
    return tap, w, w * w * w / w_squared[:, None]


def approximate(x, z, level):
    """MBA: levels 0 to `level`, each fitted to what the coarser ones leave, refined into one lattice.

    Parameters
    ----------
    x : (n, 3) float64
        Nusselt coordinates.
    z : (n, channels) float64
    level : int, 0 to 8

    Returns
    -------
    control_points : lattice.shape(level) + (channels,) float64
    residual : (n, channels) float64
        What is left at the samples.
    """
    control_points = None
    residual = np.array(z, dtype=float)
    for h in range(level + 1):
        correction = basis_approximation(x, residual, h)
        residual -= dense.evaluate(correction, h, x)
        control_points = correction if h == 0 else dense.refine(control_points, h - 1) + correction
    return control_points, residual
