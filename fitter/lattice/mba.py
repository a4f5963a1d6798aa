"""Multilevel B-spline approximation (MBA) of scattered data in three and four dimensions (S. Lee, G. Wolberg, S. Y.
Shin: Scattered Data Interpolation with Multilevel B-Splines, IEEE TVCG 3(3), 1997). The samples are fitted together
with their mirror images, so that every lattice is symmetric, and `dense` can store a part of it."""

import math

import numpy as np

from .. import progress
from ..arrays import FloatArray, IntArray
from . import dense

_CONTROL_POINTS_READ = 1 << 21  # control points that are read at a time: they take 100 MB


def mirror_images(x: FloatArray, level: int) -> tuple[FloatArray, IntArray]:
    """The samples, (n, axes) in the stored part of the cube, and those of their mirror images that influence a stored
    control point: points (m, axes), of which the first n are the samples, and of each the index of its sample, (m,)."""
    axes = x.shape[1]
    images = [x, *(np.where(np.array(signs) > 0, x, 1 - x) for signs in dense.MIRRORS[axes])]
    points, of = np.concatenate(images), np.tile(np.arange(len(x)), len(images))
    first = np.floor(points * dense.cells(level)) - 1 - dense.origin(level, axes)
    near = (first[:, list(dense.HALVED[axes])] > -4).all(axis=1)
    near[:len(x)] = True
    return points[near], of[near]


def basis_approximation(x: FloatArray, z: FloatArray, level: int) -> FloatArray:
    """B-spline approximation (BA) of samples on one level (Lee, Wolberg and Shin 1997, section 3.1): coordinates (n,
    axes) in the stored part of the cube and values (n, channels) to dense.shape(level, axes) + (channels,). A control
    point takes the mean of what its samples propose (equation 3) with weights w^2 (equation 5), or 0 without any."""
    points, of = mirror_images(x, level)
    box = dense.shape(level, x.shape[1])
    omega = np.zeros(math.prod(box))
    delta = np.zeros((len(omega), z.shape[1]))
    chunk = _CONTROL_POINTS_READ >> 2 * x.shape[1]
    for start in range(0, len(points), chunk):
        tap, w, cube = _taps(points[start:start + chunk], level)
        omega += np.bincount(tap, (w * w).ravel(), minlength=len(omega))
        for channel, values in enumerate(z[of[start:start + chunk]].T):
            delta[:, channel] += np.bincount(tap, (cube * values[:, None]).ravel(), minlength=len(omega))
    delta *= np.divide(1, omega, out=np.zeros_like(omega), where=omega > 0)[:, None]
    return delta.reshape(*box, -1)


def _taps(points: FloatArray, level: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """The t = 4^axes control points of each of m points: positions in the flattened box, (t m,), their weights w, (m,
    t), and w^3 / sum(w^2), (m, t): times z, the numerator of equation 5."""
    first, along = dense.locate(points, level)
    axes = points.shape[1]
    index = first[:, None, :] + np.arange(4)[:, None]                   # (m, 4, axes)
    stored = (index >= 0) & (index < np.array(dense.shape(level, axes)))
    position = np.where(stored, index, 0) * dense.strides(level, axes)
    w_squared = np.ones(len(points))
    for w in along:
        w_squared *= (w * w).sum(axis=1)
    # control points outside the box get weight 0: they are mirror images of stored ones
    w = dense.tensor([np.where(stored[:, :, axis], w, 0) for axis, w in enumerate(along)])
    tap = position[:, :, 0]
    for axis in range(1, axes):
        tap = (tap[:, :, None] + position[:, None, :, axis]).reshape(len(points), -1)
    return tap.ravel(), w, w * w * w / w_squared[:, None]


def approximate(x: FloatArray, z: FloatArray, level: int) -> tuple[FloatArray, FloatArray]:
    """MBA (Lee, Wolberg and Shin 1997, section 4) of coordinates (n, axes) in the stored part of the cube and values
    (n, channels): the sum of all levels from 0 up, refined to the finest, dense.shape(level, axes) + (channels,), and
    the residual, (n, channels)."""
    control_points = basis_approximation(x, z, 0)
    residual = np.asarray(z, dtype=float) - dense.evaluate(control_points, 0, x)
    for h in range(1, level + 1):
        progress.report(2.0 ** (h - level - 1))         # a level takes about as long as all before it
        correction = basis_approximation(x, residual, h)
        residual -= dense.evaluate(correction, h, x)
        control_points = dense.refine(control_points, h - 1) + correction
    return control_points, residual
