"""Which pairs of directions photographs of a ball cover.

A photograph has one angle between lamp and camera, the phase angle, seen from the ball. Half of it is the difference
angle of all of its pixels, nearly: near lamps and cameras vary it by a few degrees. The half vector goes all over. So
photographs are told apart, and what they leave open is found, by the difference angle.
"""

from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, Directions, FloatArray
from ...coordinates.rusinkiewicz import Pair
from ...quality.coverage import cosines, fold_azimuth
from ...quality.physics import direction_pairs
from ...samples import Samples

REACH = np.radians(5)       # a pair of directions is covered by a sample whose both directions are as near
MOST = 75                   # degrees of difference angle that a ball can show: beyond it all that is lit is grazing
WIDE = 12                   # degrees between difference angles: no sample is within `REACH` in the middle
LEAST = 5                   # degrees of difference angle: nearer the camera is in the lamp's way
_CELL = np.radians(4)       # in which pairs of directions are compared together
_PAIRS = 2000               # of which the share is found


class Coverage(NamedTuple):
    """What samples cover; degrees."""

    incidence: tuple[float, float]          # the smallest and the largest polar angle of the light
    exitance: tuple[float, float]           # and of the viewer
    difference: tuple[float, float]         # and the smallest and the largest difference angle
    gaps: tuple[tuple[float, float], ...]   # ranges of that without samples, wider than `WIDE`, the widest first
    share: float     # of pairs of directions, evenly by projected solid angle, those that are covered


def coverage(samples: Samples) -> Coverage:
    """What samples cover.

    Examples
    --------
    >>> steps = np.radians(range(0, 70, 4))
    >>> theta_i, theta_o = (grid.ravel() for grid in np.meshgrid(steps, steps))
    >>> found = coverage(Samples(theta_i, 0 * theta_i, theta_o, 0 * theta_o, np.ones((len(theta_i), 1))))
    >>> found.incidence, round(found.difference[1], 3), found.gaps
    ((0.0, 68.0), 34.0, ((34.0, 75.0),))
    """
    angle = np.degrees(difference_angle(samples.directions))
    incidence, exitance, difference = ((float(each.min()), float(each.max())) for each in (
        np.degrees(samples.theta_i), np.degrees(samples.theta_o), angle))
    inside = np.unique(np.concatenate([[LEAST, MOST], angle[(angle > LEAST) & (angle < MOST)]]))
    wide = np.flatnonzero(np.diff(inside) > WIDE)
    gaps = [(round(float(inside[k]), 6), round(float(inside[k + 1]), 6)) for k in wide]
    return Coverage(incidence, exitance, difference, tuple(sorted(gaps, key=lambda gap: gap[0] - gap[1])),
                    float(are_covered(samples, direction_pairs(_PAIRS)).mean()))


def difference_angle(directions: Directions) -> FloatArray:
    """Half of the angle between the directions, radians: (n,)."""
    pair = Pair.from_angles(*directions)
    return np.asarray(np.arctan2(2 * np.sqrt(pair.sin2_d), np.sqrt(pair.sum2)))


def are_covered(samples: Samples, pairs: Directions) -> BoolArray:
    """Which pairs of directions have an isotropic sample near, mirrored, or with its directions exchanged: (n,)."""
    theta_i, theta_o = (np.concatenate(both) for both in ((samples.theta_i, samples.theta_o),
                                                          (samples.theta_o, samples.theta_i)))
    azimuth = np.tile(fold_azimuth(samples.phi_o - samples.phi_i), 2)
    order = np.argsort(theta_i)
    theta_i, theta_o, azimuth = theta_i[order], theta_o[order], azimuth[order]
    probes = np.stack([pairs[0], pairs[2], fold_azimuth(pairs[3] - pairs[1])], axis=1)
    covered, cells = np.zeros(len(probes), bool), (probes[:, :2] / _CELL).astype(int)
    for cell in np.unique(cells, axis=0):
        inside = np.flatnonzero((cells == cell).all(axis=1))
        low, high = cell * _CELL - REACH, (cell + 1) * _CELL + REACH
        part = slice(*np.searchsorted(theta_i, (low[0], high[0])))
        near = np.flatnonzero((theta_o[part] > low[1]) & (theta_o[part] < high[1])) + part.start
        if len(near):
            apart = cosines(probes[inside], theta_i[near], theta_o[near], azimuth[near])
            covered[inside] = (apart > np.cos(REACH)).any(axis=1)
    return covered
