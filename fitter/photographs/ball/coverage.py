"""Which pairs of directions photographs of a ball cover, and where to put the next lamp.

All pixels of a photograph have nearly one difference angle, half of the phase angle between lamp and camera, and half
vectors all over. So what photographs leave open is found by the difference angle. The next lamp should stand in the
middle of a gap; where there are several, in that of which fits know least: fits without the photographs between two
gaps disagree there, in the variance of cube roots of cosine-weighted values over their mean square.
"""

from typing import NamedTuple

import numpy as np

from ... import progress
from ...arrays import BoolArray, Directions, FloatArray, select_directions
from ...coordinates.rusinkiewicz import Pair
from ...methods import fit
from ...methods.presets import PRESETS
from ...quality.coverage import cosines, fold_azimuth
from ...quality.cross_validation import cube_root
from ...quality.physics import direction_pairs
from ...samples import Samples, subsample, subset
from ..rig.photograph import STEEPEST

REACH = np.radians(5)       # a pair of directions is covered by a sample whose both directions are as near
MOST = 75                   # degrees of difference angle that a ball can show: beyond it all that is lit is grazing
WIDE = 12                   # degrees between difference angles: no sample is within `REACH` in the middle
LEAST = 5                   # degrees of difference angle: nearer the camera is in the lamp's way
_CELL = np.radians(4)       # in which pairs of directions are compared together
_SHARED_PAIRS = 2000        # of directions, of which the share is found

_SAMPLES = 8000             # to which each part is fitted
_PAIRS = 20_000             # of directions, of which those in a gap are looked at


class Coverage(NamedTuple):
    """What samples cover; degrees."""

    incidence: tuple[float, float]          # the smallest and the largest polar angle of the light
    exitance: tuple[float, float]           # and of the viewer
    difference: tuple[float, float]         # and the smallest and the largest difference angle
    gaps: tuple[tuple[float, float], ...]   # ranges of that without samples, wider than `WIDE`, the widest first
    share: float     # of pairs of directions, evenly by projected solid angle, those that are covered


def advice(samples: Samples) -> tuple[str, ...]:
    """What samples of a ball cover, and where to put the next lamp."""
    covered = coverage(samples)
    lines = ["Incidence {:.0f}° to {:.0f}°, exitance {:.0f}° to {:.0f}°, difference angle {:.0f}° to {:.0f}°".format(
        *covered.incidence, *covered.exitance, *covered.difference),
        f"{covered.share:.0%} of all pairs of directions are within {np.degrees(REACH):.0f}° of a measured one; the "
        f"rest is a guess"]
    lines += [f"No photograph has a difference angle between {low:.0f}° and {high:.0f}°" for low, high in covered.gaps]
    angle = next_phase_angle(samples, covered)
    if angle is not None:
        lines.append(f"Put the next lamp at {angle:.0f}° from the camera, seen from the ball")
    return tuple(lines)


def next_phase_angle(samples: Samples, covered: Coverage) -> float | None:
    """The phase angle of the photograph that would help most, degrees; None if none would."""
    if not covered.gaps:
        return None
    middles = [sum(gap) / 2 for gap in covered.gaps]
    angles = np.degrees(difference_angle(samples.directions))
    between = np.digitize(angles, sorted(middles))
    parts = np.unique(between)
    if len(middles) == 1 or len(parts) == 1:
        return 2 * middles[0]
    fits = [fit(subsample(subset(samples, between != part), _SAMPLES), **PRESETS["Standard"])
            for part in progress.each(parts.tolist())]
    pairs = direction_pairs(_PAIRS)
    at = np.degrees(difference_angle(pairs))

    def disagreement(gap: tuple[float, float]) -> float:
        inside = select_directions(pairs, (gap[0] < at) & (at < gap[1]) & (np.maximum(pairs[0], pairs[2]) < STEEPEST))
        found: FloatArray = np.stack([cube_root(inside[2], each.evaluate(*inside)) for each in fits])
        return float(found.var(axis=0).mean() / (found ** 2).mean())

    return 2 * middles[int(np.argmax([disagreement(gap) for gap in covered.gaps]))]


def coverage(samples: Samples) -> Coverage:
    """What samples cover."""
    angle = np.degrees(difference_angle(samples.directions))
    incidence, exitance, difference = ((float(each.min()), float(each.max())) for each in (
        np.degrees(samples.theta_i), np.degrees(samples.theta_o), angle))
    inside = np.unique(np.concatenate([[LEAST, MOST], angle[(angle > LEAST) & (angle < MOST)]]))
    wide = np.flatnonzero(np.diff(inside) > WIDE)
    gaps = [(round(float(inside[k]), 6), round(float(inside[k + 1]), 6)) for k in wide]
    return Coverage(incidence, exitance, difference, tuple(sorted(gaps, key=lambda gap: gap[0] - gap[1])),
                    float(are_covered(samples, direction_pairs(_SHARED_PAIRS)).mean()))


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
            closeness = cosines(probes[inside], theta_i[near], theta_o[near], azimuth[near])
            covered[inside] = (closeness > np.cos(REACH)).any(axis=1)
    return covered
