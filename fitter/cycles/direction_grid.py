"""Viewing directions of an isotropic fit, and incident directions about the mirror direction of each.

The mixture is tabulated for `OUTGOING_COUNT` outgoing angles. A fit is symmetric about the plane of incidence, so that
half of all directions is enough. They are points of rings about the mirror direction, evenly spaced in the square root
of the angle delta from it, so that they are finest there, and evenly by the azimuth psi around it. Points reach below
the horizon, where nothing is reflected.
"""

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..shader_constants import GRAZING

OUTGOING_COUNT = 32                  # as many stops as a colour ramp has
_DIRECTION_RINGS, _DIRECTION_SECTORS = 64, 24  # points: .1 degrees apart at the mirror direction, 5 far from it
_GRAZING_LIMIT = np.radians(86)  # mirror direction about which the rings lie


class IncidentDirections(NamedTuple):
    """Points of the grid, rings first."""

    theta: FloatArray          # (n,), radians, at most pi / 2
    phi: FloatArray            # (n,), radians
    unit: FloatArray           # (n, 3): the same as unit vectors; below the horizon they are put onto it
    solid_angle: FloatArray    # (n,): on both sides of the plane of incidence together; 0 below the horizon


def outgoing_angles(count: int) -> FloatArray:
    """So many outgoing angles to tabulate, radians, more closely spaced toward the horizon, and one between any two of
    them: (2 count - 1,)."""
    return GRAZING * (1 - np.linspace(1, 0, 2 * count - 1) ** 1.5)


def grid(theta_o: float) -> IncidentDirections:
    """The incident directions at which a fit is evaluated, for an outgoing angle and azimuth 0."""
    rings, sectors = _DIRECTION_RINGS, _DIRECTION_SECTORS
    mirror = min(theta_o, _GRAZING_LIMIT)
    farthest = np.pi / 2 + mirror
    edges = farthest * (np.arange(rings + 1) / rings) ** 2
    delta, psi = np.meshgrid(farthest * ((np.arange(rings) + 0.5) / rings) ** 2,
                             np.pi * (np.arange(sectors) + 0.5) / sectors, indexing="ij")
    size = 2 * np.pi / sectors * -np.diff(np.cos(edges))[:, None] * np.ones(sectors)
    axis = np.array([-np.sin(mirror), 0, np.cos(mirror)])
    onward = np.array([-np.cos(mirror), 0, -np.sin(mirror)])
    unit = (np.cos(delta)[..., None] * axis + (np.sin(delta) * np.cos(psi))[..., None] * onward
            + (np.sin(delta) * np.sin(psi))[..., None] * np.array([0, 1, 0])).reshape(-1, 3)
    above = unit[:, 2] > 0
    unit[:, 2] = np.maximum(unit[:, 2], 0)
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    return IncidentDirections(np.arccos(unit[:, 2]), np.arctan2(unit[:, 1], unit[:, 0]), unit,
                              np.where(above, size.ravel(), 0))

