"""A stretch of half vectors (x, y) in the unit disk, and of difference vectors: their length r becomes ``asinh(k r) /
asinh(k)``. Near 0, at mirror or at retro-reflection, it is magnified k / asinh(k) times, and far away it is nearly the
logarithm of r: a highlight takes as much of a lattice as its tail. The map is smooth, as asinh is odd."""

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import LEAST_LENGTH

NO_STRETCH = 0.0
LEAST_STRETCH, LARGEST_STRETCH = 0.1, 1000.0     # of others: below, single precision shows


def stretch_half_vector(x: FloatArray, y: FloatArray, k: float) -> tuple[FloatArray, FloatArray]:
    """Stretch half vectors: two (...) arrays to two (...) arrays."""
    if not k:
        return x, y
    radius = np.hypot(x, y)
    near = radius < LEAST_LENGTH
    factor = np.where(near, k, np.arcsinh(k * radius) / np.where(near, 1, radius)) / np.arcsinh(k)
    return x * factor, y * factor


def unstretch_half_vector(x: FloatArray, y: FloatArray, k: float) -> tuple[FloatArray, FloatArray]:
    """The inverse of `stretch_half_vector`."""
    if not k:
        return x, y
    radius, scale = np.hypot(x, y), np.arcsinh(k)
    near = radius < LEAST_LENGTH
    factor = np.where(near, scale, np.sinh(scale * radius) / np.where(near, 1, radius)) / k
    return x * factor, y * factor
