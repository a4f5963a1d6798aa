"""Which pairs of directions photographs of a ball cover, and where to put the next lamp.

A photograph has one angle between lamp and camera, the phase angle, seen from the ball. Half of it is the difference
angle of all of its pixels, nearly: near lamps and cameras vary it by a few degrees. The half vector goes all over. So
photographs are told apart, and what they leave open is found, by the difference angle.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, Directions, FloatArray, IntArray
from ..coordinates.rusinkiewicz import Pair
from ..quality.coverage import folded, vectors
from ..quality.physics import direction_pairs
from ..samples import Samples

REACH = np.radians(5)       # a pair of directions is covered by a sample whose both directions are as near
MOST = 75                   # degrees of difference angle that a ball can show: beyond it all that is lit is grazing
WIDE = 12                   # degrees between difference angles: no sample is within `REACH` in the middle
_CELL = np.radians(4)       # in which pairs of directions are compared together
_PAIRS = 2000               # of which the share is found
_LEAST = 5                  # degrees of difference angle: nearer the camera is in the lamp's way


class Coverage(NamedTuple):
    """What samples cover; degrees."""

    incidence: tuple[float, float]
    """The smallest and the largest polar angle of the light."""
    exitance: tuple[float, float]
    """And of the viewer."""
    difference: tuple[float, float]
    """And the smallest and the largest difference angle."""
    gaps: tuple[tuple[float, float], ...]
    """Ranges of the difference angle without samples that are wider than `WIDE`, the widest first."""
    share: float
    """Of pairs of directions, evenly by projected solid angle, those that are covered."""

    @property
    def next_phase_angle(self) -> float | None:
        """Between camera and lamp, seen from the ball, for the photograph that would help most; None if none would."""
        return sum(self.gaps[0]) if self.gaps else None


def coverage(samples: Samples) -> Coverage:
    """What samples cover.

    Examples
    --------
    >>> steps = np.radians(range(0, 70, 4))
    >>> theta_i, theta_o = (grid.ravel() for grid in np.meshgrid(steps, steps))
    >>> found = coverage(Samples(theta_i, 0 * theta_i, theta_o, 0 * theta_o, np.ones((len(theta_i), 1))))
    >>> found.incidence, round(found.difference[1], 3), found.gaps, found.next_phase_angle
    ((0.0, 68.0), 34.0, ((34.0, 75.0),), 109.0)
    """
    angle = np.degrees(difference_angle(samples.directions))
    pairs = direction_pairs(_PAIRS)
    return Coverage(_range(np.degrees(samples.theta_i)), _range(np.degrees(samples.theta_o)), _range(angle),
                    _gaps(angle), float(are_covered(samples, pairs).mean()))


def advice(found: Coverage) -> tuple[str, ...]:
    """The same in words, and where to put the next lamp."""
    lines = ["Incidence {:.0f}° to {:.0f}°, exitance {:.0f}° to {:.0f}°, difference angle {:.0f}° to {:.0f}°".format(
        *found.incidence, *found.exitance, *found.difference),
        f"{found.share:.0%} of all pairs of directions are within {np.degrees(REACH):.0f}° of a measured one; the rest "
        f"is a guess"]
    lines += [f"No photograph has a difference angle between {low:.0f}° and {high:.0f}°" for low, high in found.gaps]
    if found.next_phase_angle is not None:
        lines.append(f"Put the next lamp at {found.next_phase_angle:.0f}° from the camera, seen from the ball")
    return tuple(lines)


def difference_angle(directions: Directions) -> FloatArray:
    """Half of the angle between the directions, radians: (n,)."""
    pair = Pair.of(*directions)
    return np.asarray(np.arctan2(2 * np.sqrt(pair.sin2_d), np.sqrt(pair.sum2)))


def are_covered(samples: Samples, pairs: Directions, reach: float = float(REACH)) -> BoolArray:
    """Which pairs of directions have a sample near, itself, mirrored, or with its directions exchanged: (n,) bool.

    Parameters
    ----------
    samples : Samples
        Isotropic.
    pairs : four (n,) float64
        Radians.
    reach : float
        Radians that both directions may be off.
    """
    theta = np.concatenate([samples.theta_i, samples.theta_o]), np.concatenate([samples.theta_o, samples.theta_i])
    turn = np.tile(folded(samples.phi_o - samples.phi_i), 2)
    wanted, turned = (pairs[0], pairs[2]), folded(pairs[3] - pairs[1])
    cells = np.stack([(angle / _CELL).astype(int) for angle in wanted], axis=1)
    found = np.zeros(len(turned), bool)
    order = np.argsort(theta[0])
    theta, turn = (theta[0][order], theta[1][order]), turn[order]
    for cell in np.unique(cells, axis=0):
        asked = np.flatnonzero((cells == cell).all(axis=1))
        low, high = cell * _CELL - reach, (cell + 1) * _CELL + reach
        part = slice(*np.searchsorted(theta[0], (low[0], high[0])))
        near = np.flatnonzero((theta[1][part] > low[1]) & (theta[1][part] < high[1])) + part.start
        if len(near):
            found[asked] = (_cosines(wanted, turned, asked, theta, turn, near) > np.cos(reach)).any(axis=1)
    return found


def _cosines(wanted: tuple[FloatArray, FloatArray], turned: FloatArray, asked: IntArray,
             theta: tuple[FloatArray, FloatArray], turn: FloatArray, near: IntArray) -> FloatArray:
    """Of the larger of the two angles between pairs asked for and samples: (asked, near)."""
    incident = np.cos(wanted[0][asked][:, None] - theta[0][near])
    outgoing = vectors(wanted[1][asked], turned[asked]) @ vectors(theta[1][near], turn[near]).T
    return np.minimum(incident, outgoing)


def _range(angle: FloatArray) -> tuple[float, float]:
    return float(angle.min()), float(angle.max())


def _gaps(angle: FloatArray) -> tuple[tuple[float, float], ...]:
    """The wide gaps between difference angles in degrees, the widest first."""
    inside = np.unique(np.concatenate([[_LEAST, MOST], angle[(angle > _LEAST) & (angle < MOST)]]))
    wide = np.flatnonzero(np.diff(inside) > WIDE)
    gaps = [(round(float(inside[k]), 6), round(float(inside[k + 1]), 6)) for k in wide]
    return tuple(sorted(gaps, key=lambda gap: gap[0] - gap[1]))
