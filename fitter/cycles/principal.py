"""The principal axes of an anisotropic reflectance, and its stretch."""

from typing import NamedTuple

import numpy as np

from ..arrays import ComplexArray, FloatArray
from ..model import Reflectance

_HIGHLIGHT_RINGS, _HIGHLIGHT_SECTORS = 40, 64  # half vectors that are looked at, seen from the normal
_WIDEST_ANGLE = np.radians(44)  # their largest angle from it
_LEVEL = 0.25                   # the outline of the highlight: of its height above the least reflectance
_ROUND, _ROUND_THREADS = 0.1, 0.05      # smaller harmonics count as none
_GENTLY = 0.15                  # power of the squared ratio of the highlight's length and width that is the stretch
_STRETCHES = (1.0, 1.6)         # its bounds: more makes cells beside streaks, and at grazing angles, too coarse


class Principal(NamedTuple):
    """The axes of an anisotropic surface."""

    turn: float         # azimuth of the first, radians: that along which highlights are longest
    stretch: float      # by which slopes along it are divided, and across it multiplied, to make highlights round


def principal(fit: Reflectance) -> Principal:
    """The principal axes of a reflectance: of the highlight seen from the normal, the half vectors where the reflected
    radiance is above a quarter of its largest value. Where that region is as long along both axes, as on a cloth of two
    threads, they are those of its arms."""
    angle = _WIDEST_ANGLE * ((np.arange(_HIGHLIGHT_RINGS) + 0.5) / _HIGHLIGHT_RINGS) ** 2
    size = -np.diff(np.cos(_WIDEST_ANGLE * (np.arange(_HIGHLIGHT_RINGS + 1) / _HIGHLIGHT_RINGS) ** 2))
    turn = (np.arange(_HIGHLIGHT_SECTORS) + 0.5) / _HIGHLIGHT_SECTORS * 2 * np.pi
    radiance = np.maximum(fit.evaluate(2 * angle[:, None], turn, 0.0, 0.0), 0).mean(axis=-1)
    radiance = radiance * np.cos(2 * angle)[:, None]
    least = np.median(radiance[-_HIGHLIGHT_RINGS // 4:])
    highlight = size[:, None] * (radiance > least + _LEVEL * max(radiance.max() - least, 0.0))
    slope = np.tan(angle)[:, None] * np.exp(1j * turn)
    second = complex((highlight * slope ** 2).sum()) / max(float((highlight * np.abs(slope) ** 2).sum()), 1e-30)
    stretch = float(np.clip(((1 + abs(second)) / max(1 - abs(second), 1e-6)) ** _GENTLY, *_STRETCHES))
    if abs(second) > _ROUND:
        return Principal(float(np.angle(second)) / 2, stretch)
    return Principal(_thread_azimuth(radiance, size, slope), 1.0)


def _thread_azimuth(radiance: FloatArray, size: FloatArray, slope: ComplexArray) -> float:
    """The azimuth that the edges of highlights cross most often, up to right angles, radians; 0 if there is none.

    From radiance over (rings, sectors) of half vectors, whose slopes are (rings, sectors) and solid angles (rings,).
    """
    outward = np.gradient(radiance, np.abs(slope[:, 0]), axis=0)
    difference = np.roll(radiance, -1, axis=1) - np.roll(radiance, 1, axis=1)
    around = difference * _HIGHLIGHT_SECTORS / (4 * np.pi) / np.abs(slope)
    gradient = slope / np.abs(slope) * (outward + 1j * around)
    steep = size[:, None] * np.abs(gradient)
    fourth = complex((steep * np.exp(4j * np.angle(gradient))).sum()) / max(float(steep.sum()), 1e-30)
    return float(np.angle(fourth)) / 4 if abs(fourth) > _ROUND_THREADS else 0.0

