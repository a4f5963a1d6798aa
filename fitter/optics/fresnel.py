"""Fresnel's equations of a dielectric."""

import numpy as np

from ..arrays import FloatArray


def fresnel(eta: float, cosine: FloatArray) -> FloatArray:
    """The unpolarised reflectance of a dielectric of index eta at an angle of incidence of this cosine, (...).

    Examples
    --------
    >>> fresnel(1.5, np.array([1.0, 0.0])).round(6).tolist()
    [0.04, 1.0]
    """
    g = np.sqrt(np.maximum(eta ** 2 - 1 + cosine ** 2, 0))
    ratio = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return np.asarray(0.5 * ((g - cosine) / (g + cosine)) ** 2 * (1 + ratio ** 2))
