"""The viewing directions at which mixtures are tabulated, and for each the incident directions at which a fit is
evaluated: points of rings about an axis, evenly spaced in the square root of the angle from it, so that they are finest
there. They reach below the horizon, where nothing is reflected."""

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, unit_vectors
from ..shader_constants import GRAZING

OUTGOING_COUNT = 32                  # as many stops as a colour ramp has
_MIRROR_RINGS, _MIRROR_SECTORS = 64, 24     # points: .1 degrees apart at the mirror direction, 5 far from it
_HALF_RINGS, _HALF_SECTORS = 32, 24
_GRAZING_LIMIT = np.radians(86)  # mirror direction about which the rings lie


class IncidentDirections(NamedTuple):
    """Points of a grid, rings first; of several viewing directions with an axis in front."""

    theta: FloatArray          # (n,), radians, at most pi / 2
    phi: FloatArray            # (n,), radians
    unit: FloatArray           # (n, 3): the same as unit vectors; below the horizon they are put onto it
    solid_angle: FloatArray    # (n,): 0 below the horizon


def outgoing_angles(count: int) -> FloatArray:
    """Outgoing angles to tabulate, denser toward the horizon, and one between any two: (2 count - 1,), radians."""
    return GRAZING * (1 - np.linspace(1, 0, 2 * count - 1) ** 1.5)


def mirror_grid(theta_o: float) -> IncidentDirections:
    """Incident directions about the mirror direction of an outgoing angle at azimuth 0, radians.

    An isotropic fit is symmetric about the plane of incidence: the solid angles are those of both sides together.
    """
    mirror = min(theta_o, _GRAZING_LIMIT)
    ring, size = _rings(np.pi / 2 + mirror, _MIRROR_RINGS, _MIRROR_SECTORS)
    delta, psi = np.meshgrid(ring, np.pi * (np.arange(_MIRROR_SECTORS) + 0.5) / _MIRROR_SECTORS, indexing="ij")
    axis = np.array([-np.sin(mirror), 0, np.cos(mirror)])
    onward = np.array([-np.cos(mirror), 0, -np.sin(mirror)])
    unit = (np.cos(delta)[..., None] * axis + (np.sin(delta) * np.cos(psi))[..., None] * onward
            + (np.sin(delta) * np.sin(psi))[..., None] * np.array([0, 1, 0])).reshape(-1, 3)
    return _clip_to_horizon(unit, size)


def half_vector_grid(wo: FloatArray, stretch: float) -> IncidentDirections:
    """Incident directions in the principal axes of an anisotropic surface, by half vectors: of viewing directions of
    one polar angle, (views, 3), and a stretch s.

    The highlight of a brushed surface is a streak, which lies differently for each viewing direction; its half vectors
    h hardly change. They are points of rings about the normal after they have been stretched, which makes streaks
    round: g = (h_x / s, h_y s, h_z) / |...|. A solid angle of g is one of the incident direction times 4 (wo.h)
    |(h_x / s, h_y s, h_z)|^3. Beyond the outermost ring no direction above the horizon has a half vector.
    """
    largest = (np.pi / 2 + np.arccos(np.clip(wo[0, 2], 0, 1))) / 2
    ring, of_g = _rings(np.arctan2(stretch * np.sin(largest), np.cos(largest)), _HALF_RINGS, _HALF_SECTORS)
    turn = (np.arange(_HALF_SECTORS) + 0.5) / _HALF_SECTORS * 2 * np.pi
    h = (unit_vectors(ring[:, None], turn) * [stretch, 1 / stretch, 1]).reshape(-1, 3)
    length = np.linalg.norm(h, axis=-1)
    h = h / length[:, None]
    cosine = wo @ h.T
    return _clip_to_horizon(2 * cosine[..., None] * h - wo[:, None], of_g * 4 * np.maximum(cosine, 0) / length ** 3)


def _rings(farthest: float, rings: int, sectors: int) -> tuple[FloatArray, FloatArray]:
    """The angles of rings from their axis, (rings,), and the solid angle of each point, (rings * sectors,)."""
    edges = farthest * (np.arange(rings + 1) / rings) ** 2
    return (farthest * ((np.arange(rings) + 0.5) / rings) ** 2,
            2 * np.pi / sectors * np.repeat(-np.diff(np.cos(edges)), sectors))


def _clip_to_horizon(unit: FloatArray, solid_angle: FloatArray) -> IncidentDirections:
    above = unit[..., 2] > 0
    unit[..., 2] = np.maximum(unit[..., 2], 0)
    unit /= np.maximum(np.linalg.norm(unit, axis=-1), 1e-9)[..., None]
    return IncidentDirections(np.arccos(np.clip(unit[..., 2], 0, 1)), np.arctan2(unit[..., 1], unit[..., 0]), unit,
                              np.where(above, solid_angle, 0))
