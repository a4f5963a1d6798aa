"""Fresnel's equations of a dielectric."""

import numpy as np

from ..arrays import FloatArray


def fresnel(eta: float, cosine: FloatArray) -> FloatArray:
    """The unpolarised reflectance of a dielectric of index eta at an angle of incidence of this cosine, (...)."""
    g = np.sqrt(np.maximum(eta ** 2 - 1 + cosine ** 2, 0))
    ratio = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return np.asarray(0.5 * ((g - cosine) / (g + cosine)) ** 2 * (1 + ratio ** 2))


def reflectance_to_index(reflectance: FloatArray) -> FloatArray:
    """The index of refraction of a dielectric by its reflectance at normal incidence, (...): the inverse of `fresnel`
    at a cosine of 1.

    Examples
    --------
    >>> reflectance_to_index(np.array([0.0, 0.04])).round(6).tolist()
    [1.0, 1.5]
    """
    root = np.sqrt(reflectance)
    return np.asarray((1 + root) / (1 - root))
