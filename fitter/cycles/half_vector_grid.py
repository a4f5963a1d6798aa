"""Tabulated viewing directions of an anisotropic surface, and half vectors for each.

A highlight of a brushed surface is a streak, which lies differently for each viewing direction; the half vectors of the
streak hardly change. So the mixture and the sampling tables of an anisotropic fit are tabulated over viewing directions
and half vectors, both in the principal axes of the surface. Half vectors h are divided into `HALF_RINGS` x
`HALF_SECTORS` cells about the normal, after their slopes have been divided by a stretch s along the first axis and
multiplied by it along the second, ::

    g = (h_x / s, h_y s, h_z) / |...|,

which makes streaks round: rings by the angle of g from the normal, evenly spaced in its square root, so that they are
finest there, and sectors by its azimuth, over the whole turn. A solid angle of g is one of the incident direction times
4 (wo.h) |(h_x / s, h_y s, h_z)|^3. The outermost ring ends where no direction above the horizon has a half vector any
more. Cells reach below the horizon, where nothing is reflected.
"""

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import AZIMUTH_VIEWS, GRAZING, HALF_RINGS, HALF_SECTORS, POLAR_VIEWS
from .direction_grid import Cells, Directions

CELLS = Cells(HALF_RINGS, HALF_SECTORS, (2, 1), around=True)
_LEAST_SIZE = 0.1           # solid angle of a cell that is reached, in that of its stretched half vectors
_BETWEEN = 5                # polar angles at which it is found out what is reached
_BELOW = 0.1                # sine of the angle of a corner below the horizon of a cell that is above it somewhere


def polar_angles() -> NDArray[np.float64]:
    """The tabulated polar angles of the viewer, radians, more closely spaced toward the horizon: (POLAR_VIEWS,)."""
    return GRAZING * (1 - np.linspace(1, 0, POLAR_VIEWS) ** 1.5)


def azimuths(half_turn: bool) -> NDArray[np.float64]:
    """The tabulated azimuths of the viewer in the principal axes, radians, in half a turn or in a whole one:
    (AZIMUTH_VIEWS,)."""
    return np.arange(AZIMUTH_VIEWS) * (np.pi if half_turn else 2 * np.pi) / AZIMUTH_VIEWS


def views(half_turn: bool) -> NDArray[np.float64]:
    """The tabulated viewing directions, unit vectors in the principal axes: (views, 3). The normal is the first."""
    polar, azimuth = polar_angles(), azimuths(half_turn)
    others = outgoing(polar[1:, None], azimuth).reshape(-1, 3)
    return np.concatenate([[[0.0, 0.0, 1.0]], others])


def outgoing(theta: NDArray[np.float64] | float, phi: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Unit vectors of polar angles and azimuths, which broadcast to (...): (..., 3)."""
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def grid(wo: NDArray[np.float64], stretch: float, reached: NDArray[np.bool_] | None = None) -> Directions:
    """The incident directions at which a fit is evaluated, in the principal axes.

    Parameters
    ----------
    wo : (views, 3)
        Viewing directions of one polar angle.
    stretch : float
        s.
    reached : (views, cells) bool, optional
        What `reached` has for them; by default every cell is.

    Returns
    -------
    direction_grid.Directions
        Its arrays have an axis of views in front.
    """
    farthest = _farthest(float(wo[0, 2]), stretch)
    points, turns = HALF_RINGS * CELLS.points[0], HALF_SECTORS * CELLS.points[1]
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
    near = np.ones(above.shape, dtype=bool)
    if reached is not None:
        by_axis = reached.reshape(-1, HALF_RINGS, HALF_SECTORS)
        near = np.repeat(np.repeat(by_axis, CELLS.points[0], axis=1), CELLS.points[1], axis=2).reshape(above.shape)
    return Directions(np.arccos(np.clip(unit[..., 2], 0, 1)), np.arctan2(unit[..., 1], unit[..., 0]), unit,
                      np.where(above, size, 0), np.where(above | near, np.maximum(size, _LEAST_SIZE * of_g), 0))


def reached(number: int, half_turn: bool, stretch: float) -> NDArray[np.bool_]:
    """Which cells hold half vectors of directions above the horizon, for the views of a polar angle, by its number, or
    for any viewing direction between them and those beside them: (azimuths, HALF_RINGS * HALF_SECTORS)."""
    polar, azimuth = polar_angles(), azimuths(half_turn)
    first, last = polar[max(number - 1, 0)], polar[number + 1] if number + 1 < len(polar) else np.pi / 2
    highest = np.full((len(azimuth), HALF_RINGS + 1, HALF_SECTORS), -1.0)
    for theta_o in np.linspace(first, last, _BETWEEN):
        farthest = _farthest(float(np.cos(theta_o)), stretch)
        h, _ = _half_vectors(farthest * (np.arange(HALF_RINGS + 1) / HALF_RINGS) ** 2,
                             np.arange(HALF_SECTORS) / HALF_SECTORS * 2 * np.pi, stretch)
        # the cosine of the incident direction, for the azimuth of the viewer that is nearest to that of h
        turn = np.abs((np.arctan2(h[:, 1], h[:, 0]) - azimuth[:, None] + np.pi) % (2 * np.pi) - np.pi)
        turn = np.maximum(turn - azimuth[1], 0) if number > 0 else np.zeros_like(turn)
        height = (2 * h[:, 2] * np.hypot(h[:, 0], h[:, 1]) * np.cos(turn) * np.sin(theta_o)
                  + (2 * h[:, 2] ** 2 - 1) * np.cos(theta_o))
        highest = np.maximum(highest, height.reshape(highest.shape))
    corners = np.maximum(highest, np.roll(highest, -1, axis=-1))
    corners = np.maximum(corners[:, :-1], corners[:, 1:])
    return np.asarray(corners.reshape(len(azimuth), -1) > -_BELOW)


def _farthest(cosine: float, stretch: float) -> float:
    """The largest angle from the normal of a stretched half vector, for a viewing direction of a cosine; radians."""
    largest = (np.pi / 2 + np.arccos(np.clip(cosine, 0, 1))) / 2
    return float(np.arctan2(stretch * np.sin(largest), np.cos(largest)))


def _half_vectors(ring: NDArray[np.float64], turn: NDArray[np.float64],
                  stretch: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The half vectors of all pairs of an angle and an azimuth of g, rings first, (n, 3); and by what power of which
    their solid angle differs from that of g, |(g_x s, g_y / s, g_z)|, (n,)."""
    ring, turn = (each.ravel() for each in np.meshgrid(ring, turn, indexing="ij"))
    along = outgoing(ring, turn) * [stretch, 1 / stretch, 1]
    length = np.linalg.norm(along, axis=-1)
    return along / length[:, None], length
