"""Tabulated viewing directions, and incident directions about the mirror direction of each.

The mixture and the sampling tables are tabulated for `VIEWS` outgoing angles. A fit is symmetric about the plane of
incidence, so that half of all directions is enough. They are divided into `RINGS` x `SECTORS` cells about the mirror
direction: rings by the angle delta from it, evenly spaced in sqrt(delta), so that they are finest there, and sectors
evenly by the turn psi around it. So the cells follow a highlight from view to view. Cells reach below the horizon,
where nothing is reflected.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..shader_constants import GRAZING, RINGS, SECTORS, STEEPEST_AXIS, VIEWS

SUBSAMPLES = (2, 1)         # points of a cell along delta and psi
_HALF_CELL = 0.15           # sine of the angle from a point to the edge of its cell, or more


class Cells(NamedTuple):
    """The cells of a grid, and the points in each.

    Attributes
    ----------
    rings, sectors : int
    points : (int, int)
        Of a cell, along rings and along sectors.
    around : bool
        Whether the last sector lies beside the first.
    """

    rings: int
    sectors: int
    points: tuple[int, int]
    around: bool

    def gather(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values at the points of grids, rings first, by cells: (..., n) to (..., cells, points of a cell)."""
        along, across = self.points
        by_axis = values.reshape(*values.shape[:-1], self.rings, along, self.sectors, across)
        by_cell = np.swapaxes(by_axis, -3, -2)
        return np.asarray(by_cell.reshape(*values.shape[:-1], self.rings * self.sectors, along * across))


CELLS = Cells(RINGS, SECTORS, SUBSAMPLES, around=False)


class Directions(NamedTuple):
    """Points of the grid, rings first.

    Attributes
    ----------
    theta, phi : (n,)
        Radians; theta is at most pi / 2.
    unit : (n, 3)
        The same as unit vectors. Below the horizon they are put onto it.
    solid_angle : (n,)
        Of each point, on both sides of the plane of incidence together; 0 below the horizon.
    reachable : (n,)
        The same, and not 0 where another point of the cell may be above the horizon, for a view near this one.
    """

    theta: NDArray[np.float64]
    phi: NDArray[np.float64]
    unit: NDArray[np.float64]
    solid_angle: NDArray[np.float64]
    reachable: NDArray[np.float64]


def views(between: int = 0) -> NDArray[np.float64]:
    """The tabulated outgoing angles, radians, more closely spaced toward the horizon: (VIEWS,).

    With others between any two of them: (VIEWS + (VIEWS - 1) between,).
    """
    return GRAZING * (1 - np.linspace(1, 0, VIEWS + (VIEWS - 1) * between) ** 1.5)


def grid(theta_o: float) -> Directions:
    """The incident directions at which a fit is evaluated, for an outgoing angle and azimuth 0."""
    rings, sectors = RINGS * SUBSAMPLES[0], SECTORS * SUBSAMPLES[1]
    mirror = min(theta_o, STEEPEST_AXIS)
    farthest = np.pi / 2 + mirror
    edges = farthest * (np.arange(rings + 1) / rings) ** 2
    delta, psi = np.meshgrid(farthest * ((np.arange(rings) + 0.5) / rings) ** 2,
                             np.pi * (np.arange(sectors) + 0.5) / sectors, indexing="ij")
    size = 2 * np.pi / sectors * -np.diff(np.cos(edges))[:, None] * np.ones(sectors)
    axis = np.array([-np.sin(mirror), 0, np.cos(mirror)])
    onward = np.array([-np.cos(mirror), 0, -np.sin(mirror)])
    unit = (np.cos(delta)[..., None] * axis + (np.sin(delta) * np.cos(psi))[..., None] * onward
            + (np.sin(delta) * np.sin(psi))[..., None] * np.array([0, 1, 0])).reshape(-1, 3)
    above, near = unit[:, 2] > 0, unit[:, 2] > -_HALF_CELL
    unit[:, 2] = np.maximum(unit[:, 2], 0)
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    return Directions(np.arccos(unit[:, 2]), np.arctan2(unit[:, 1], unit[:, 0]), unit,
                      np.where(above, size.ravel(), 0), np.where(near, size.ravel(), 0))


def spacing(delta: float) -> float:
    """About the largest distance between points of a grid at an angle from the mirror direction; all radians."""
    along = 2 * np.sqrt(np.pi * delta) / (RINGS * SUBSAMPLES[0])
    return float(max(along, np.pi * delta / (SECTORS * SUBSAMPLES[1])))


def cells(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values at the points of a grid, by cells: (n, ...) to (RINGS * SECTORS, points of a cell, ...)."""
    rings, sectors = SUBSAMPLES
    by_axis = values.reshape(RINGS, rings, SECTORS, sectors, *values.shape[1:])
    return np.asarray(np.swapaxes(by_axis, 1, 2).reshape(RINGS * SECTORS, rings * sectors, *values.shape[1:]))
