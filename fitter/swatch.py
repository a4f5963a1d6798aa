"""Pictures of published materials: a sphere in a photographer's studio, so that metals have something to reflect.

The lobe of `model.low2012` is sampled exactly. A half vector at the angle theta_h from the normal, with
u = 1 - cos theta_h, is chosen with the density D / (2 pi Z), D = (1 + B u)^-C, where Z is the integral of D over u from
0 to 1. A sample of light L from direction i then counts ::

    f cos theta_i L / pdf = 8 A Z F G cos theta_d / cos theta_o L,    pdf = D / (2 pi Z) / (4 cos theta_d)
"""

from collections.abc import Callable

import numpy as np

from .arrays import FloatArray, SingleArray
from .model.low2012 import Low2012, fresnel
from .pictures import sphere, srgb

SIZE = 128
_SAMPLES = 192              # of the lobe, for a pixel
_LIGHTS = 1500              # directions from which diffuse light comes
_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))
_LEAST = 1e-6
# softboxes: direction to the middle, half widths across and up (of unit vectors), radiance
_BOXES = (((-0.55, 0.6, 0.6), (0.38, 0.32), 4.0), ((0.85, 0.15, 0.35), (0.12, 0.6), 2.0),
          ((0.1, 0.5, -0.85), (0.8, 0.2), 1.2))
_SOFT = 0.15                # width of a box's edge
_GROUND, _HORIZON, _SKY = 0.08, 0.25, 0.7       # radiance of what is around


def swatch(model: Low2012, size: int = SIZE) -> SingleArray:
    """A sphere of a material in a studio, in orthographic view on a transparent background.

    Parameters
    ----------
    model : Low2012
        Linear Rec.709.
    size : int
        Pixels.

    Returns
    -------
    (size, size, 4) float32
        sRGB, the bottom row first.
    """
    normal, inside, cover = sphere(size)
    picture = np.zeros((size, size, 4), dtype=np.float32)
    picture[inside, :3] = srgb(radiance(model, normal, studio))
    picture[..., 3] = cover
    return picture


def radiance(model: Low2012, normal: FloatArray, light: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """What surfaces with normals (n, 3) send to a viewer at (0, 0, 1) under some light: (n, 3) float64.

    `light` is radiance from directions (..., 3), as (...); up is (0, 1, 0).
    """
    return _irradiance(normal, light)[:, None] * model.kd / np.pi + _lobe(model, normal, light)[:, None] * model.a


def studio(direction: FloatArray) -> FloatArray:
    """The radiance of a studio with three softboxes: unit vectors (..., 3) to (...)."""
    up = direction[..., 1]
    total = np.where(up > 0, _HORIZON + (_SKY - _HORIZON) * np.maximum(up, 0), _GROUND)
    for middle, widths, strength in _BOXES:
        ahead = np.array(middle) / np.linalg.norm(middle)
        across = np.cross((0.0, 1.0, 0.0), ahead)
        across /= np.linalg.norm(across)
        edges = [np.abs(direction @ axis) - width
                 for axis, width in zip((across, np.cross(ahead, across)), widths, strict=True)]
        inside = np.prod([np.clip(0.5 - edge / _SOFT, 0, 1) for edge in edges], axis=0)
        total = total + strength * inside * (direction @ ahead > 0)
    return np.asarray(total)


def _irradiance(normal: FloatArray, light: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """(n,): the integral of light times cosine."""
    k = np.arange(_LIGHTS)
    height, turn = 1 - (2 * k + 1) / _LIGHTS, k * _GOLDEN_ANGLE
    radius = np.sqrt(1 - height ** 2)
    places = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=-1)
    return np.asarray(np.maximum(normal @ places.T, 0) @ light(places) * (4 * np.pi / _LIGHTS))


def _lobe(model: Low2012, normal: FloatArray, light: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """(n,): what the lobe reflects, for A = 1."""
    cos_o = np.maximum(normal[:, 2], _LEAST)
    helper = np.where(np.abs(normal[:, 1:2]) < 0.9, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    across = np.cross(helper, normal)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = np.cross(normal, across)
    total, whole = np.zeros(len(normal)), _whole(model)
    for k in range(_SAMPLES):
        u, turn = _inverse(model, (k + 0.5) / _SAMPLES * whole), k * _GOLDEN_ANGLE
        cos_h, sin_h = 1 - u, np.sqrt(u * (2 - u))
        half = sin_h * (np.cos(turn) * across + np.sin(turn) * other) + cos_h * normal
        cos_d = half[:, 2]                                      # the viewer is at (0, 0, 1)
        incident = 2 * cos_d[:, None] * half - (0.0, 0.0, 1.0)
        cos_i = np.einsum("nk,nk->n", incident, normal)
        seen = (cos_d > _LEAST) & (cos_i > _LEAST)
        cos_d = np.maximum(cos_d, _LEAST)
        shadowing = np.minimum(1, 2 * cos_h * np.minimum(cos_i, cos_o) / cos_d)
        total += np.where(seen, fresnel(model.eta, cos_d) * shadowing * cos_d / cos_o * light(incident), 0)
    return total * 8 * whole / _SAMPLES


def _whole(model: Low2012) -> float:
    """Z, the integral of D over u from 0 to 1."""
    exponent = 1 - model.c
    if abs(exponent) < _LEAST:
        return float(np.log1p(model.b) / model.b)
    return float(np.expm1(exponent * np.log1p(model.b)) / (model.b * exponent))


def _inverse(model: Low2012, part: float) -> float:
    """The u up to which the integral of D is a part of Z."""
    exponent = 1 - model.c
    if abs(exponent) < _LEAST:
        return float(np.expm1(part * model.b) / model.b)
    return float(np.expm1(np.log1p(part * model.b * exponent) / exponent) / model.b)
