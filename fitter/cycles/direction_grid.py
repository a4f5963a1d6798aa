"""Tabulated viewing directions and a grid of incident ones, for the closure mixture and the sampling tables.

The mixture is tabulated for `VIEWS` outgoing angles. A fit is symmetric about the plane of incidence, so that half of
the hemisphere is enough. It is divided into `RINGS` x `SECTORS` cells, evenly spaced in s = sqrt(1 - cos theta_i),
which is nearly proportional to the angle, and in t = (1 - phi / pi)^(2/3), which is finest near the mirror direction;
phi is the azimuth from that of the outgoing direction. Each cell is evaluated at 2 x 2 points.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import GRAZING, RINGS, SECTORS, VIEWS

SUBSAMPLES = 2              # points of a cell along each of its two sides


class Directions(NamedTuple):
    """Points of the grid, rings first.

    Attributes
    ----------
    theta, phi : (n,)
        Radians.
    unit : (n, 3)
        The same as unit vectors.
    solid_angle : (n,)
        Of each point, on both sides of the plane of incidence together.
    """

    theta: NDArray[np.float64]
    phi: NDArray[np.float64]
    unit: NDArray[np.float64]
    solid_angle: NDArray[np.float64]


def views() -> NDArray[np.float64]:
    """The tabulated outgoing angles, radians, more closely spaced toward the horizon: (VIEWS,)."""
    return GRAZING * (1 - np.linspace(1, 0, VIEWS) ** 1.5)


def grid() -> Directions:
    """The incident directions at which a fit is evaluated."""
    rings, sectors = RINGS * SUBSAMPLES, SECTORS * SUBSAMPLES
    cosine, phi = np.meshgrid(1 - ((np.arange(rings) + 0.5) / rings) ** 2,
                              np.pi * (1 - ((np.arange(sectors) + 0.5) / sectors) ** 1.5), indexing="ij")
    sine = np.sqrt(1 - cosine**2)
    height, width = (2 * np.arange(rings) + 1) / rings**2, np.diff((np.arange(sectors + 1) / sectors) ** 1.5)
    solid_angle = 2 * np.pi * height[:, None] * width
    unit = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    return Directions(np.arccos(cosine).ravel(), phi.ravel(), unit.reshape(-1, 3), solid_angle.ravel())
