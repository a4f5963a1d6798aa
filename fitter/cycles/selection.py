"""The shares with which densities are best sampled.

All arrays may have more axes in front, of views that are solved at once.
"""

import numpy as np

from ..arrays import FloatArray, RealArray

_SELECTION_ITERATIONS = 30      # of the shares, which then change by less than a percent
_LEAST_SHARE = 0.01             # so that every density gets sampled


def selection_probabilities(magnitude: RealArray, density: RealArray, solid_angle: RealArray) -> FloatArray:
    """Selection probabilities of densities, (..., densities), of the least second moment, by fixed-point iteration.

    It minimises the second moment of the estimate under an even light, the integral of R^2 / sum_k s_k p_k, and keeps
    the shares positive: of |R|, (..., n), at points of the hemisphere, p_k, (..., densities, n), per solid angle, and
    solid angles, (..., n).
    """
    squared = magnitude ** 2 * solid_angle
    found = np.full(density.shape[:-1], 1 / density.shape[-2])
    for _ in range(_SELECTION_ITERATIONS):
        together = np.maximum((found[..., None, :] @ density)[..., 0, :], 1e-9)
        found = found * np.sqrt((density @ (squared / together ** 2)[..., None])[..., 0])
        found = np.maximum(found / np.maximum(found.sum(axis=-1, keepdims=True), 1e-12), _LEAST_SHARE)
    return np.asarray(found / found.sum(axis=-1, keepdims=True))
