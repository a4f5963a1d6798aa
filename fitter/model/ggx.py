"""Microfacets of GGX with height-correlated masking (E. Heitz: Understanding the Masking-Shadowing Function in
Microfacet-Based BRDFs, JCGT 3(2), 2014), each of which reflects all light."""

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import LEAST_LENGTH
from .microfacet import Geometry

_LEAST_RUN = 1e-9           # (numerical)


def ggx(at: Geometry, alpha: float, fresnel: FloatArray | float = 1.0) -> FloatArray:
    """F D G2 / (4 cos theta_i cos theta_o) of one width, 1/sr: (...)."""
    alpha2 = alpha * alpha
    steepness = (1 + at.tan2_h) / (1 + at.tan2_h / alpha2)
    long_i, long_o = (np.sqrt(cosine ** 2 * (1 - alpha2) + alpha2) for cosine in (at.cos_i, at.cos_o))
    visibility = 0.5 / np.maximum(at.cos_o * long_i + at.cos_i * long_o, LEAST_LENGTH)
    return np.asarray(steepness ** 2 / (np.pi * alpha2) * fresnel * visibility)


def reflect_at_visible_normals(view: FloatArray, along: float, across: float,
                               count: int) -> tuple[FloatArray, FloatArray]:
    """Reflection at normals as they are visible from a direction, (3,), by midpoints of `count` by `count` cells (E.
    Heitz: Sampling the GGX Distribution of Visible Normals, JCGT 7(4), 2018): of those that send light above the
    horizon G2 / G1, whose sum over all cells is the albedo, and the cosine of the difference angle, (n,) each."""
    stretch, middle = np.array([along, across, 1.0]), (np.arange(count) + 0.5) / count
    radius, angle = (each.ravel() for each in np.meshgrid(np.sqrt(middle), 2 * np.pi * middle))
    v = view * stretch / np.linalg.norm(view * stretch)
    run = np.hypot(v[0], v[1])
    first = np.array([-v[1], v[0], 0]) / max(run, _LEAST_RUN) if run > 0 else np.array([1.0, 0, 0])
    # the half of the disk that is hidden is moved onto the other
    x, y, s = radius * np.cos(angle), radius * np.sin(angle), (1 + v[2]) / 2
    y = (1 - s) * np.sqrt(1 - x ** 2) + s * y
    up = np.sqrt(np.maximum(1 - x ** 2 - y ** 2, 0))
    normal = (np.outer(x, first) + np.outer(y, np.cross(v, first)) + np.outer(up, v)) * stretch
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    cos_d = normal @ view
    light = 2 * cos_d[:, None] * normal - view
    above = light[:, 2] > 0
    cos_i, cos_o = light[above, 2], view[2]
    long_i, long_o = np.sqrt(((light[above] * stretch) ** 2).sum(axis=1)), np.sqrt(((view * stretch) ** 2).sum())
    return cos_i * (cos_o + long_o) / (cos_o * long_i + cos_i * long_o), cos_d[above]
