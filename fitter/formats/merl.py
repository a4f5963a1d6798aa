"""MERL's reflectance database, 100 materials (.binary), tabulated by half and difference angles, of which only theta_h
is not even, but by its root (docs/layouts.md, MERL).

A cell with a negative number in any channel was not measured, and is left out, as are those below the horizon.
"""

import math
import struct

import numpy as np

from ..arrays import BoolArray, Directions, FloatArray, map_directions
from ..coordinates.rusinkiewicz import half_to_directions
from ..errors import DatasetError
from ..samples import HORIZON, RGB, Samples, freeze_new_arrays
from .format import Format

MERL_CELLS = 90, 90, 180
SCALE = np.array([1.0, 1.15, 1.66]) / 1500
_NOTE = "Multiplied by MERL's scale, 1/1500 of red, 1.15/1500 of green, 1.66/1500 of blue"
_HEADER_BYTES = 12
_MERL_HORIZON = 1e-12       # cosine below which a direction is on the horizon, but for rounding
_MERL_TYPES = {8: "<f8", 4: "<f4", 2: "<f2"}
_LARGEST = _HEADER_BYTES + 3 * 8 * math.prod(MERL_CELLS)


def recognises(content: bytes) -> bool:
    """Whether the file begins with the numbers n, n, 2n, up to MERL's own; in the wrong byte order too."""
    return _is_merl(_cells(content, "<")) or _is_merl(_cells(content, ">"))


def read(content: bytes) -> Samples:
    """Read a .binary file: the cells that were measured. Raises DatasetError if the file is damaged."""
    cells = _cells(content, "<")
    if not _is_merl(cells):
        raise DatasetError("numbers in big-endian order, expected little-endian ones, as MERL's files have them")
    numbers = 3 * math.prod(cells)
    size, rest = divmod(len(content) - _HEADER_BYTES, numbers)
    if rest or size not in _MERL_TYPES:
        sizes = ", ".join(f"{_HEADER_BYTES + numbers * size:,} (float{8 * size})" for size in _MERL_TYPES)
        raise DatasetError(f"{len(content):,} bytes found for {' x '.join(map(str, cells))} cells of three channels, "
                           f"expected {sizes}")
    planes = np.frombuffer(content, _MERL_TYPES[size], offset=_HEADER_BYTES).reshape(3, *cells)
    if not all(np.isfinite(part).all() for part in np.moveaxis(planes, 1, 0)):
        raise DatasetError("holds numbers that are not finite")
    measured = [(planes[:, i] >= 0).all(axis=0) & _cells_above_horizon(i, cells) for i in range(cells[0])]
    count = sum(map(np.count_nonzero, measured))
    if not count:
        raise DatasetError("no cell was measured: all are negative or below the horizon")
    directions, values = map_directions(np.empty, [count] * 4), np.empty((count, 3))
    start = 0
    for i, above in enumerate(measured):        # one theta_h at a time, to save memory
        part = slice(start, start + int(np.count_nonzero(above)))
        for angle, of_cells in zip(directions, _directions(i, above), strict=True):
            angle[part] = of_cells
        values[part] = planes[:, i][:, above].T * SCALE
        start = part.stop
    freeze_new_arrays(*directions, values)
    return Samples(*directions, values, RGB, "", notes=(_NOTE,))


def other_layout(content: bytes) -> str | None:
    """What to say of a file in MERL's layout whose numbers of cells are others, as a part of a message."""
    cells = _cells(content, "<")
    if min(cells, default=0) < 1 or _is_merl(cells) or not any(
            len(content) - _HEADER_BYTES == 3 * math.prod(cells) * size for size in _MERL_TYPES):
        return None
    return (f"MERL's layout with {' x '.join(map(str, cells))} cells of theta_h, theta_d and phi_d; expected n x n x "
            f"2n, as in MERL's files of {' x '.join(map(str, MERL_CELLS))}: phi_d over half a turn, for the other half "
            "is the same by reciprocity. Write that half alone")


def _cells(content: bytes, order: str) -> tuple[int, ...]:
    """The numbers of cells; `order` is "<" or ">", the byte order."""
    return struct.unpack_from(order + "3i", content) if len(content) >= _HEADER_BYTES else ()


def _is_merl(cells: tuple[int, ...]) -> bool:
    return len(cells) == 3 and 2 <= cells[0] <= MERL_CELLS[0] and cells[1] == cells[0] and cells[2] == 2 * cells[0]


def _cells_above_horizon(i: int, cells: tuple[int, ...]) -> BoolArray:
    """Whether both directions of each cell of a theta_h are above the horizon: (n_d, n_p)."""
    theta_h, theta_d, phi_d = _edges(i, cells)
    return np.cos(theta_d) * np.cos(theta_h) > _MERL_HORIZON + np.abs(np.sin(theta_d) * np.cos(phi_d) * np.sin(theta_h))


def _directions(i: int, which: BoolArray) -> Directions:
    """Those of some cells of a theta_h, radians. phi_h is 0."""
    theta_h, theta_d, phi_d = _edges(i, (len(which), *which.shape))
    theta_d, phi_d = (np.broadcast_to(angle, which.shape)[which] for angle in (theta_d, phi_d))
    return half_to_directions(theta_h, np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d),
                              np.cos(theta_d))


def _edges(i: int, cells: tuple[int, ...]) -> tuple[float, FloatArray, FloatArray]:
    """theta_h, theta_d (n_d, 1) and phi_d (n_p,) of the cells of a theta_h."""
    return ((i / cells[0]) ** 2 * HORIZON, np.arange(cells[1])[:, None] / cells[1] * HORIZON,
            np.arange(cells[2]) / cells[2] * np.pi)


FORMAT = Format("MERL", "MERL .binary", (".binary",), recognises, read, is_text=False, largest=_LARGEST)
