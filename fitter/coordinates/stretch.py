"""A stretch of half vectors, which gives the directions near the mirror's more room.

Both systems of half and difference coordinates have a half vector (x, y) in the unit disk, which is 0 at mirror
reflection; `half_angle` has a difference vector, which is 0 at retro-reflection. Its length r becomes ``asinh(k r) /
asinh(k)`` with the stretch k: near 0 it is magnified k / asinh(k) times, and far away it is nearly the logarithm of r.
A highlight so takes as much of a lattice as its tail, and a kernel of one length is short across the highlight and long
beyond it. The map is smooth, as asinh is odd.
"""

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
