"""Multilevel B-spline approximation (MBA) of scattered data in three dimensions.

S. Lee, G. Wolberg, S. Y. Shin: Scattered Data Interpolation with Multilevel B-Splines, IEEE TVCG 3(3), 1997; applied to
reflectance by Kameya and Lewis 2002. The samples are fitted together with their mirror images, so that every lattice is
symmetric, and `dense` can store a quarter of it.
"""

import math

import numpy as np

from ..arrays import FloatArray, IntArray
from . import dense

_CHUNK = 32768              # points at a time: their 64 control points take 100 MB


def mirror_images(x: FloatArray, level: int) -> tuple[FloatArray, IntArray]:
    """The samples, and those of their mirror images that influence a stored control point.

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in the stored quarter of the cube.

    Returns
    -------
    points : (m, 3) float64
        The first n are the samples.
    of : (m,) int
        Index of the sample whose image a point is.

    Examples
    --------
    Of a sample near ``lambda = 1/2``, the bilateral mirror image is near too; its other images are far.

    >>> points, of = mirror_images(np.array([[0.9, 0.3, 0.51]]), 4)
    >>> points.round(9).tolist(), of.tolist()
    ([[0.9, 0.3, 0.51], [0.9, 0.3, 0.49]], [0, 0])
    """
    bilateral = x * [1, 1, -1] + [0, 0, 1]
    half_turn = x * [-1, -1, 1] + [1, 1, 0]
    both = x * [-1, -1, -1] + 1
    points = np.concatenate([x, bilateral, half_turn, both])
    of = np.tile(np.arange(len(x)), 4)
    first = np.floor(points * dense.cells(level)) - 1 - dense.origin(level)
    near = (first[:, 0] > -4) & (first[:, 2] > -4)
    near[:len(x)] = True
    return points[near], of[near]


def basis_approximation(x: FloatArray, z: FloatArray, level: int) -> FloatArray:
    """B-spline approximation (BA) of samples on one level (Lee, Wolberg and Shin 1997, section 3.1).

    Each sample proposes a value for the 64 control points that it reads (equation 3); a control point takes the mean of
    its proposals with weights w^2 (equation 5), or 0 without any.

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in the stored quarter of the cube.
    z : (n, channels) float64

    Returns
    -------
    dense.shape(level) + (channels,) float64

    Examples
    --------
    A single sample is interpolated.

    >>> x = np.array([[0.9, 0.3, 0.8]])
    >>> dense.evaluate(basis_approximation(x, np.array([[0.3]]), 4), 4, x).round(9).tolist()
    [[0.3]]
    """
    points, of = mirror_images(x, level)
    omega = np.zeros(math.prod(dense.shape(level)))
    delta = np.zeros((len(omega), z.shape[1]))
    for start in range(0, len(points), _CHUNK):
        tap, w, cube = _taps(points[start:start + _CHUNK], level)
        omega += np.bincount(tap, (w * w).ravel(), minlength=len(omega))
        for channel, values in enumerate(z[of[start:start + _CHUNK]].T):
            delta[:, channel] += np.bincount(tap, (cube * values[:, None]).ravel(), minlength=len(omega))
    inverse = np.divide(1, omega, out=np.zeros_like(omega), where=omega > 0)
    return (delta * inverse[:, None]).reshape(*dense.shape(level), -1)


def _taps(points: FloatArray, level: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """The 64 control points of each of m points, and their weights.

    Returns
    -------
    tap : (64 m,) int
        Positions in the flattened box.
    w : (m, 64) float64
    cube : (m, 64) float64
        w^3 / sum(w^2): times z, the numerator of equation 5.
    """
    first, (wa, wb, wc) = dense.locate(points, level)
    box = np.array(dense.shape(level))
    index = first[:, None, :] + np.arange(4)[:, None]                   # (m, 4, 3)
    stored = (index >= 0) & (index < box)
    index = np.where(stored, index, 0)
    w_squared = np.ones(len(points))
    for w in (wa, wb, wc):
        w_squared *= (w * w).sum(axis=1)

    # control points outside the box get weight 0: they are mirror images of stored ones
    wa, wb, wc = (np.where(stored[:, :, axis], w, 0) for axis, w in enumerate((wa, wb, wc)))
    tap = ((index[:, :, None, None, 0] * box[1] + index[:, None, :, None, 1]) * box[2]
           + index[:, None, None, :, 2]).ravel()
    w = (wa[:, :, None, None] * wb[:, None, :, None] * wc[:, None, None, :]).reshape(len(points), 64)
    return tap, w, w * w * w / w_squared[:, None]


def approximate(x: FloatArray, z: FloatArray, level: int) -> tuple[FloatArray, FloatArray]:
    """MBA: fit each level from 0 up to the residual of the coarser ones (Lee, Wolberg and Shin 1997, section 4).

    Parameters
    ----------
    x : (n, 3) float64
        Coordinates in the stored quarter of the cube.
    z : (n, channels) float64
    level : int, 0 to 8

    Returns
    -------
    control_points : dense.shape(level) + (channels,) float64
        The sum of all levels, refined to the finest.
    residual : (n, channels) float64
        z less the spline at the samples.

    Examples
    --------
    Where no two samples share a cell of the finest level, that level leaves no residual.

    >>> x, z = np.array([[0.6, 0.2, 0.6], [0.9, 0.8, 0.7]]), np.array([[1.0], [2.0]])
    >>> control_points, residual = approximate(x, z, 5)
    >>> bool(np.allclose(residual, 0)), bool(np.allclose(dense.evaluate(control_points, 5, x), z))
    (True, True)
    """
    control_points = basis_approximation(x, z, 0)
    residual = np.asarray(z, dtype=float) - dense.evaluate(control_points, 0, x)
    for h in range(1, level + 1):
        correction = basis_approximation(x, residual, h)
        residual -= dense.evaluate(correction, h, x)
        control_points = dense.refine(control_points, h - 1) + correction
    return control_points, residual
