"""Microfacets of GGX with height-correlated masking (E. Heitz: Understanding the Masking-Shadowing Function in
Microfacet-Based BRDFs, JCGT 3(2), 2014), each of which reflects all light."""

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import LEAST_LENGTH
from .microfacet import Geometry


def ggx(at: Geometry, alpha: float) -> FloatArray:
    """D G2 / (4 cos theta_i cos theta_o) of one width, 1/sr: (...)."""
    alpha2 = alpha * alpha
    steepness = (1 + at.tan2_h) / (1 + at.tan2_h / alpha2)
    long_i, long_o = (np.sqrt(cosine ** 2 * (1 - alpha2) + alpha2) for cosine in (at.cos_i, at.cos_o))
    visibility = 0.5 / np.maximum(at.cos_o * long_i + at.cos_i * long_o, LEAST_LENGTH)
    return np.asarray(steepness ** 2 / (np.pi * alpha2) * visibility)


def reflect_at_visible_normals(view: FloatArray, along: float, across: float,
                               count: int) -> tuple[FloatArray, FloatArray]:
    """The share G2 / G1 of light reflected at visible normals that leaves, and the cosine of the difference angle: of
    directions (n, 3), at `count` by `count` midpoints of the unit disk, (n, points) each (E. Heitz: Sampling the GGX
    Distribution of Visible Normals, JCGT 7(4), 2018). The mean of the share is the directional albedo."""
    stretch = np.array([along, across, 1.0])
    long_o = np.linalg.norm(view * stretch, axis=1, keepdims=True)
    v = view * stretch / long_o
    run = np.hypot(v[:, 0], v[:, 1])
    first = np.stack([-v[:, 1], v[:, 0], 0 * run], axis=1) / np.maximum(run, LEAST_LENGTH)[:, None]
    first[run == 0] = 1, 0, 0
    # points of the disk, of which the half that is hidden is moved
    middle = (np.arange(count) + 0.5) / count
    radius, angle = (each.ravel() for each in np.meshgrid(np.sqrt(middle), 2 * np.pi * middle))
    x, s = radius * np.cos(angle), (1 + v[:, 2:]) / 2
    y = (1 - s) * np.sqrt(1 - x ** 2) + s * radius * np.sin(angle)
    up = np.sqrt(np.maximum(1 - x ** 2 - y ** 2, 0))
    normal = x[:, None] * first[:, None] + y[..., None] * np.cross(v, first)[:, None] + up[..., None] * v[:, None]
    normal *= stretch
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    cos_d = np.einsum("nmk,nk->nm", normal, view)
    light = 2 * cos_d[..., None] * normal - view[:, None]
    long_i, cos_i, cos_o = np.linalg.norm(light * stretch, axis=-1), np.maximum(light[..., 2], 0), view[:, 2:]
    return cos_i * (cos_o + long_o) / (cos_o * long_i + cos_i * long_o), cos_d
