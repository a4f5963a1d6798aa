"""Directions that may be counted in another way, as a glossy surface betrays: phi from the mirror's side, or elevations
for polar angles.

A highlight is forward, and the brighter, the more the light grazes: what is far brighter backward, also where the light
grazes, is no surface (beads and prisms send less light back then). And at the normal, forward and backward are one
direction: they differ more near it than near the horizon only if these are taken for one another.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..samples import Samples

_BACKWARD = 5.0             # times as bright as forward: of real measurements
                            # (tests/fitter/quality/test_conventions.py) plaster is 2.7 times
_KEPT_SHARE = 0.8           # of what shines backward at the smaller angle; beads keep half from 15 to 50 degrees
_GLOSSY = 5.0               # times as bright forward as backward near the normal, from which elevations are told
_UPSIDE_DOWN = 3.0          # times as much as near the horizon; of real measurements that are glossy at most 1
_DARK_RATIO = 1e-6          # of the brightest value: no ratio is of less
_BINS = np.radians(np.arange(15, 76, 10))   # of incidence
_NEAR = np.radians((10, 20, 30))            # of a direction: the first in which there are samples
_BRIGHT = 0.9               # the quantile of values there
_LEAST = 2                  # bins that angles are apart, to tell what grazing makes


class _Sides(NamedTuple):
    """The brightest values near the mirror direction and near the light, 1/sr, at angles of incidence in bins of rising
    numbers: (n,) each."""

    number: FloatArray
    forward: FloatArray
    backward: FloatArray


def questions(samples: Samples) -> tuple[str, ...]:
    """What is to be asked of the directions of measurements."""
    sides = _sides(samples)
    return tuple(each for each in (_asks_mirrored(sides), _upside_down(sides)) if each)


def _sides(samples: Samples) -> _Sides:
    grey = np.maximum(samples.values.mean(axis=1), 0)
    up = np.cos(samples.theta_i) * np.cos(samples.theta_o)
    along = np.sin(samples.theta_i) * np.sin(samples.theta_o) * np.cos(samples.phi_o - samples.phi_i)
    apart = [np.arccos(np.clip(up + sign * along, -1, 1)) for sign in (-1, 1)]
    number = np.digitize(samples.theta_i, _BINS)
    found = []
    for each in range(1, len(_BINS)):
        there = number == each
        for near in _NEAR:
            parts = [grey[there & (angle < near)] for angle in apart]
            if all(map(len, parts)):
                found.append((each, *(float(np.quantile(part, _BRIGHT)) for part in parts)))
                break
    numbers, forward, backward = np.array(found, dtype=float).reshape(-1, 3).T
    least = _DARK_RATIO * float(grey.max()) + np.finfo(float).tiny
    return _Sides(numbers, np.maximum(forward, least), np.maximum(backward, least))


def _asks_mirrored(sides: _Sides) -> str:
    times = sides.backward / sides.forward
    bright = np.flatnonzero(times >= _BACKWARD)
    if len(bright) < 2 or np.ptp(sides.number[bright]) < _LEAST:
        return ""
    first, last = bright[[0, -1]]
    if (times[first:] < 1).any() or sides.backward[last] < _KEPT_SHARE * sides.backward[first]:
        return ""
    return (f"{float(np.median(times[bright])):,.2g} times as bright toward the light as in the mirror direction: is "
            f"phi counted from the mirror's side?")


def _upside_down(sides: _Sides) -> str:
    times = sides.forward / sides.backward
    if len(times) < 2 or np.ptp(sides.number) < _LEAST or times[0] < max(_GLOSSY, _UPSIDE_DOWN * times[-1]):
        return ""
    return ("Forward and backward differ more near the normal than near the horizon: are these elevations, in the "
            "place of angles from the normal?")
