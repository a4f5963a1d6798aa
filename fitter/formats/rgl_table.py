"""An RGL file as the function that it defines, `RglTable`, and the directions of its nodes (docs/layouts.md, RGL).

Of an isotropic material azimuths are relative to phi_i. Of an anisotropic one tables are interpolated between the
azimuths phi_i too, and those over half a turn or a quarter are continued by the material's symmetry.
"""

from dataclasses import dataclass, field

import numpy as np

from ..arrays import (
    ArrayLike,
    BoolArray,
    Directions,
    FloatArray,
    IntArray,
    concatenate_directions,
    map_directions,
    select_directions,
    unit_vectors,
)
from ..samples import HORIZON
from . import rgl_warp
from .rgl_warp import Warp, cell

FEWEST_AZIMUTHS = 3         # of an anisotropic material
_TURN = 2 * np.pi
_SAME_AZIMUTH = 1e-3        # radians between azimuths that are one
_RGL_HORIZON = 1e-6         # cosine of theta_o below which a direction is on the horizon, where f is not defined
_Points = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""theta_i, phi_i, theta_o, phi_o, (n,) radians, and values (n, 3), 1/sr."""


@dataclass(frozen=True, eq=False)
class RglTable:
    """The BRDF that a file defines, between its measurements too, as the authors' reader evaluates it."""

    theta_i: FloatArray         # (T,) tabulated angles of incidence, radians
    ndf: FloatArray             # (m, n) over the unit square of directions
    sigma: FloatArray           # likewise
    warp: Warp                  # from half vectors to the grid: slices by azimuth and by angle of incidence, the faster
    values: FloatArray          # (P T, N, N, 3) of such slices: linear sRGB of f cos theta_o, over the Jacobian, if any
    has_jacobian: bool
    name: str                   # what was measured
    notes: tuple[str, ...] = ()     # what reading made of the file
    # (P,) tabulated azimuths of incidence, radians; of an isotropic material one, 0
    phi_i: FloatArray = field(default_factory=lambda: np.zeros(1))

    @property
    def isotropic(self) -> bool:
        """Whether only the difference of the azimuths matters."""
        return len(self.phi_i) < FEWEST_AZIMUTHS

    @property
    def reduction(self) -> int:
        """How many times the azimuths phi_i go into a whole turn: 1, 2 or 4; others have no symmetry."""
        return 1 if self.isotropic else reduction(self.phi_i)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF: (n,) radians each to (n, 3), 1/sr, without the cosine; 0 below the horizon.

        Beyond the tabulated angles of incidence it is that of the nearest one. Values may be negative.
        """
        theta_i, phi_i, theta_o, phi_o = map_directions(lambda angle: np.asarray(angle, dtype=float),
                                                np.broadcast_arrays(theta_i, phi_i, theta_o, phi_o))
        incident, outgoing = self._turn_to_tabulated(phi_i, phi_o)
        x, y, z = (unit_vectors(theta_i, incident) + unit_vectors(theta_o, outgoing)).T
        u_x, u_y = _square(np.arctan2(np.hypot(x, y), z), np.arctan2(y, x))
        slices = self._slices(theta_i, incident)
        s_x, s_y = rgl_warp.to_grid(self.warp, slices, u_x, u_y)
        value = sum((weight[:, None] * _bilinear(self.values, s_x, s_y, index) for index, weight in slices),
                    np.zeros(1))
        return value * self._factor(theta_i, incident, theta_o, u_x, u_y)[:, None]

    def _turn_to_tabulated(self, phi_i: FloatArray, phi_o: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Both azimuths turned, and mirrored, so that that of incidence is a tabulated one: (n,) each."""
        turn = phi_o - phi_i
        if self.isotropic:
            return np.zeros_like(turn), turn
        around = np.mod(phi_i - self.phi_i[0], _TURN / min(self.reduction, 2))
        if self.reduction == 4:
            mirrored = around > _TURN / 4
            around, turn = np.where(mirrored, _TURN / 2 - around, around), np.where(mirrored, -turn, turn)
        return self.phi_i[0] + around, self.phi_i[0] + around + turn

    def _slices(self, theta_i: FloatArray, phi_i: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """The slices between which (n,) directions of incidence are, and their weights."""
        index, weight = _locate(self.theta_i, theta_i)
        pair = [(index, 1 - weight), (index + 1, weight)]
        if self.isotropic:
            return pair
        row, share = _locate(self.phi_i, phi_i)
        return [(len(self.theta_i) * (row + step) + index, part * weight)
                for step, part in ((0, 1 - share), (1, share)) for index, weight in pair]

    def _factor(self, theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, u_x: FloatArray,
                u_y: FloatArray) -> FloatArray:
        """What the table's values are multiplied with to be f: (n,); u is the half vector's."""
        cosine = np.cos(theta_o)
        above = (cosine > _RGL_HORIZON) & (theta_i <= HORIZON)
        factor = np.divide(1, cosine, out=np.zeros_like(cosine), where=above)
        if self.has_jacobian:
            factor *= _bilinear(self.ndf, u_x, u_y) / (4 * _bilinear(self.sigma, *_square(theta_i, phi_i)))
        return factor

    def nodes(self) -> _Points:
        """The measured directions above the horizon, and the BRDF there. Of an isotropic material phi_i is 0; of an
        anisotropic one it is a tabulated azimuth, but for the last where that is the first again.
        """
        theta_i, azimuths, size = np.minimum(self.theta_i, HORIZON), self.phi_i, self.values.shape[1]
        covered = self.reduction * (azimuths[-1] - azimuths[0])
        if self.reduction < 4 and abs(covered - _TURN) < _SAME_AZIMUTH:
            azimuths = azimuths[:-1]        # the last is the first again, after a turn or by a symmetry of half a turn
        step = np.arange(size) / (size - 1)
        parts, values = [], []
        for index in range(len(azimuths) * len(theta_i)):
            row, column = divmod(index, len(theta_i))
            u_x, rows_y = rgl_warp.from_grid(self.warp, index, step, step[:-1])     # the last row is the first, 2 pi on
            u_x[:, 0] = 0
            u_y = np.broadcast_to(rows_y[:, None], u_x.shape)
            directions, which = _reflect_above_horizon(theta_i[column], azimuths[row], u_x, u_y)
            value = self.values[index, :-1].copy()
            value[:, 0] = value[:, 0].mean(axis=0)
            factor = self._factor(*directions[:3], u_x[which], u_y[which])
            parts.append(directions)
            values.append(value[which] * factor[:, None])
        return *concatenate_directions(parts), np.concatenate(values)


def reduction(phi_i: FloatArray) -> int:
    """How many times the range of tabulated azimuths, radians, goes into a whole turn; 0 if it is none."""
    covered = float(phi_i[-1] - phi_i[0])
    return round(_TURN / covered) if covered > _SAME_AZIMUTH else 0


def _reflect_above_horizon(theta: float, phi: float, u_x: FloatArray, u_y: FloatArray) -> tuple[Directions, BoolArray]:
    """The light, and the directions into which half vectors u reflect it, above the horizon: (n,); and which u these
    are. Of a column where the half vector is the normal, the first.
    """
    theta_h, phi_h = u_x ** 2 * HORIZON, (2 * u_y - 1) * np.pi - phi
    x, y, z = np.sin(theta_h) * np.cos(phi_h), np.sin(theta_h) * np.sin(phi_h), np.cos(theta_h)
    cosine = np.sin(theta) * x + np.cos(theta) * z
    x, y, z = 2 * cosine * x - np.sin(theta), 2 * cosine * y, 2 * cosine * z - np.cos(theta)
    theta_o, phi_o = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x) + phi
    which = np.cos(theta_o) > _RGL_HORIZON
    which[1:] &= u_x[1:] > 0
    return select_directions((np.full_like(u_x, theta), np.full_like(u_x, phi), theta_o, phi_o), which), which


def _locate(nodes: FloatArray, at: FloatArray) -> tuple[IntArray, FloatArray]:
    """The interval of rising nodes in which each number is, and how far in, 0 to 1; beyond them, the nearest node."""
    after = np.clip(np.searchsorted(nodes, at, side="right"), 1, len(nodes) - 1)
    index = after - 1
    return index, np.clip((at - nodes[index]) / (nodes[after] - nodes[index]), 0, 1)


def _square(theta: FloatArray, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The point of the unit square for a direction; phi = pi is where phi = -pi is."""
    u_y = (phi + np.pi) / (2 * np.pi)
    return np.sqrt(np.clip(theta / HORIZON, 0, 1)), u_y - np.floor(u_y)


def _bilinear(table: FloatArray, u_x: FloatArray, u_y: FloatArray, index: IntArray | None = None) -> FloatArray:
    """Interpolate a table (rows, columns, ...), or slice `index` of (slices, rows, columns, ...)."""
    at: tuple[IntArray, ...] = () if index is None else (index,)
    rows, columns = table.shape[len(at):len(at) + 2]
    (i, a), (j, b) = cell(u_x, columns), cell(u_y, rows)
    extra = (slice(None), *[None] * (table.ndim - len(at) - 2))
    a, b = a[extra], b[extra]
    return ((1 - b) * ((1 - a) * table[(*at, j, i)] + a * table[(*at, j, i + 1)])
            + b * ((1 - a) * table[(*at, j + 1, i)] + a * table[(*at, j + 1, i + 1)]))
