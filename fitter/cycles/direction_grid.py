"""A grid over the incident hemisphere, shared by the closure mixture and the table from which directions are drawn.

The mixture is tabulated for `VIEWS` outgoing angles. Half of the hemisphere above a point (a fit is symmetric about
the plane of incidence) is divided into `RINGS` x `SECTORS` cells, evenly spaced in s = sqrt(1 - cos theta_i), which is
nearly the angle, and in t = (1 - phi / pi)^(2/3), which is finest about the mirror direction, phi the azimuth from that
of the outgoing direction; each cell is sampled at 2 x 2 points.
"""

from typing import NamedTuple

import numpy as np

VIEWS = 32
RINGS = 32
SECTORS = 24
SUBSAMPLES = 2
GRAZING = np.radians(88)            # the last view: beyond it there is nothing to see


class Directions(NamedTuple):
    """Points of the grid, rings first: angles (n,), unit vectors (n, 3), and the solid angle of each (n,), both sides
    of the plane of incidence counted."""

    theta: np.ndarray
    phi: np.ndarray
    unit: np.ndarray
    solid_angle: np.ndarray


def views():
    """The tabulated outgoing angles, radians, finer toward the horizon: (VIEWS,)."""
    return GRAZING * (1 - np.linspace(1, 0, VIEWS) ** 1.5)


def grid():
    """The directions at which a fit is sampled."""
    rings, sectors = RINGS * SUBSAMPLES, SECTORS * SUBSAMPLES
    cosine, phi = np.meshgrid(1 - ((np.arange(rings) + 0.5) / rings) ** 2,
                              np.pi * (1 - ((np.arange(sectors) + 0.5) / sectors) ** 1.5), indexing="ij")
    sine = np.sqrt(1 - cosine**2)
    high, wide = (2 * np.arange(rings) + 1) / rings**2, np.diff((np.arange(sectors + 1) / sectors) ** 1.5)
    solid_angle = 2 * np.pi * high[:, None] * wide
    unit = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    return Directions(np.arccos(cosine).ravel(), phi.ravel(), unit.reshape(-1, 3), solid_angle.ravel())
