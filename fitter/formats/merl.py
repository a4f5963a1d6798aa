"""MERL's reflectance database, 100 materials (.binary), tabulated by half and difference angles, of which only theta_h
is not even, but by its root (docs/layouts.md, MERL).

A cell with a negative number in any channel was not measured, and is left out, as are those below the horizon.
"""

import math
import struct

import numpy as np

from ..arrays import concatenate_directions
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
    parts, values = [], []
    theta_d, phi_d = np.arange(cells[1])[:, None] / cells[1] * HORIZON, np.arange(cells[2]) / cells[2] * np.pi
    up, aside, cos_d = np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d) + 0 * phi_d
    for i in range(cells[0]):       # one theta_h at a time, to save memory; phi_h is 0
        theta_h = (i / cells[0]) ** 2 * HORIZON
        used = (planes[:, i] >= 0).all(axis=0) & (
            cos_d * np.cos(theta_h) > _MERL_HORIZON + np.abs(up * np.sin(theta_h)))       # both above the horizon
        parts.append(half_to_directions(theta_h, up[used], aside[used], cos_d[used]))
        values.append(planes[:, i][:, used].T * SCALE)
    if not sum(map(len, values)):
        raise DatasetError("no cell was measured: all are negative or below the horizon")
    directions, whole = concatenate_directions(parts), np.concatenate(values)
    freeze_new_arrays(*directions, whole)
    return Samples(*directions, whole, RGB, "", notes=(_NOTE,))


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


FORMAT = Format("MERL", "MERL .binary", (".binary",), recognises, read, is_text=False, largest=_LARGEST)
