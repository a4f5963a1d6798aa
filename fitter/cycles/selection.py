"""Selection probabilities of densities. Arrays may have more axes in front, of views that are solved at once."""

import numpy as np

from ..arrays import FloatArray, RealArray

_SELECTION_ITERATIONS = 30      # of the shares, which then change by less than a percent
_LEAST_SHARE = 0.01             # so that every density gets sampled


def selection_probabilities(magnitude: RealArray, density: RealArray, solid_angle: RealArray) -> FloatArray:
    """Selection probabilities, all positive, of densities p_k, (..., densities, n) per solid angle, of the least second
    moment under an even light, the integral of R^2 / sum_k s_k p_k, by fixed-point iteration: of |R|, (..., n), at
    points of the hemisphere of solid angles (..., n)."""
    squared = magnitude ** 2 * solid_angle
    found = np.full(density.shape[:-1], 1 / density.shape[-2])
    for _ in range(_SELECTION_ITERATIONS):
        together = np.maximum((found[..., None, :] @ density)[..., 0, :], 1e-9)
        found = found * np.sqrt((density @ (squared / together ** 2)[..., None])[..., 0])
        found = np.maximum(found / np.maximum(found.sum(axis=-1, keepdims=True), 1e-12), _LEAST_SHARE)
    return np.asarray(found / found.sum(axis=-1, keepdims=True))
