"""Viewing directions of an anisotropic surface, and half vectors for each.

A highlight of a brushed surface is a streak, which lies differently for each viewing direction; the half vectors of the
streak hardly change. So an anisotropic fit is looked at over viewing directions and half vectors, both in the principal
axes of the surface. Half vectors h are points of rings about the normal, after their slopes have been divided by a
stretch s along the first axis and multiplied by it along the second, ::

    g = (h_x / s, h_y s, h_z) / |...|,

which makes streaks round: rings by the angle of g from the normal, evenly spaced in its square root, so that they are
finest there, and evenly by its azimuth, over the whole turn. A solid angle of g is one of the incident direction times
4 (wo.h) |(h_x / s, h_y s, h_z)|^3. The outermost ring ends where no direction above the horizon has a half vector any
more. Points reach below the horizon, where nothing is reflected.
"""

import numpy as np

from ..arrays import FloatArray, unit_vectors
from .direction_grid import IncidentDirections

_HALF_RINGS, _HALF_SECTORS = 32, 24  # points


def grid(wo: FloatArray, stretch: float) -> IncidentDirections:
    """The incident directions at which a fit is evaluated, in the principal axes, for viewing directions of one polar
    angle, (views, 3), and a stretch s. The arrays have an axis of viewing directions in front."""
    farthest = _largest_half_angle(float(wo[0, 2]), stretch)
    points, turns = _HALF_RINGS, _HALF_SECTORS
    edges = farthest * (np.arange(points + 1) / points) ** 2
    ring = farthest * ((np.arange(points) + 0.5) / points) ** 2
    h, length = _half_vectors(ring, (np.arange(turns) + 0.5) / turns * 2 * np.pi, stretch)
    cosine = wo @ h.T
    unit = 2 * cosine[..., None] * h - wo[:, None]
    of_g = 2 * np.pi / turns * np.repeat(-np.diff(np.cos(edges)), turns)
    size = of_g * 4 * np.maximum(cosine, 0) / length ** 3
    above = (unit[..., 2] > 0) & (cosine > 0)
    unit[..., 2] = np.maximum(unit[..., 2], 0)
    unit /= np.maximum(np.linalg.norm(unit, axis=-1), 1e-9)[..., None]
    return IncidentDirections(np.arccos(np.clip(unit[..., 2], 0, 1)), np.arctan2(unit[..., 1], unit[..., 0]), unit,
                              np.where(above, size, 0))


def _largest_half_angle(cosine: float, stretch: float) -> float:
    """The largest angle from the normal of a stretched half vector, for a viewing direction of a cosine; radians."""
    largest = (np.pi / 2 + np.arccos(np.clip(cosine, 0, 1))) / 2
    return float(np.arctan2(stretch * np.sin(largest), np.cos(largest)))


def _half_vectors(ring: FloatArray, turn: FloatArray,
                  stretch: float) -> tuple[FloatArray, FloatArray]:
    """The half vectors of all pairs of an angle and an azimuth of g, rings first, (n, 3); and by what power of which
    their solid angle differs from that of g, |(g_x s, g_y / s, g_z)|, (n,)."""
    ring, turn = (each.ravel() for each in np.meshgrid(ring, turn, indexing="ij"))
    along = unit_vectors(ring, turn) * [stretch, 1 / stretch, 1]
    length = np.linalg.norm(along, axis=-1)
    return along / length[:, None], length
