"""Scans in the plane of incidence, whose angles have signs and no azimuth.

The sign of theta_o says on which side of the normal the detector is; that of theta_i, on which the light is. Which sign
is the mirror's side, the table says, or the highlight: it is where theta_o is theta_i, or where it is its negative.
"""

import numpy as np

from ..arrays import FloatArray

_OBLIQUE = np.radians(5)    # theta_i from which a highlight is on one side
_NEAR = np.radians(6)       # of the mirror direction: the values that count
_TELLS = 1.15               # how many times brighter one side must be
PLANE_SIDES = {"mirror": 1, "specular": 1, "forward": 1, "light": -1, "source": -1, "backward": -1, "retro": -1}
"""Words for the side on which theta_o is positive, and the sign of the mirror's side."""


def directions(theta_i: FloatArray, theta_o: FloatArray, values: FloatArray, said: int = 0) -> tuple[FloatArray, str]:
    """Directions of a scan in the plane of incidence, (n, 4) as `names.ANGLES`, the light at azimuth 0, from polar
    angles with signs, (n,) radians; and how the sides are told. `said` is the sign that theta_o has on the mirror's
    side of a positive theta_i, 0 where that is not known.
    """
    sign, why = (said, "the mirror's side, as the table says") if said else _side(theta_i, theta_o, values)
    # where it is 0, the side means nothing
    is_mirrored = np.sign(theta_o) * sign * np.where(theta_i < 0, -1, 1) >= 0
    found = np.stack([np.abs(theta_i), np.zeros(len(theta_i)), np.abs(theta_o), np.pi * is_mirrored], axis=1)
    if (theta_o >= 0).all() and (theta_i >= 0).all():
        side = "mirror" if sign > 0 else "light"
        return found, f"In the plane of incidence, without an azimuth: taken as on the {side}'s side"
    return found, f"In the plane of incidence: theta_o is {'positive' if sign > 0 else 'negative'} on {why}"


def _side(theta_i: FloatArray, theta_o: FloatArray, values: FloatArray) -> tuple[int, str]:
    """The sign of theta_o on the mirror's side, and what tells it."""
    size = values.mean(axis=1)
    oblique = np.abs(theta_i) > _OBLIQUE
    bright = [size[oblique & (np.abs(theta_o - sign * theta_i) < _NEAR)] for sign in (1, -1)]
    if all(map(len, bright)):
        same, other = (max(float(np.mean(side)), 0.0) for side in bright)
        if same > _TELLS * other:
            return 1, "the side of the highlight"
        if other > _TELLS * same:
            return -1, "the side of the highlight"
    return 1, "the mirror's side, as is usual: no highlight tells it"
