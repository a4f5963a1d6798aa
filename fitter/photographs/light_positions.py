"""Light positions of reflectance transformation imaging, `.lp` files, of which domes have one.

Text: the number of photographs, then a line for each: the name of its file, and x, y, z of the direction to the light,
x to the right in the picture, y up, z toward the camera. They are unit vectors, nearly; some are written with decimal
commas, names have blanks, or folders of the machine that took the photographs (T. Malzbender, D. Gelb, H. Wolters:
Polynomial Texture Maps, SIGGRAPH 2001; Cultural Heritage Imaging's RTIBuilder and CNR's relight write them).
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..files import read_bytes

SUFFIX = ".lp"
LARGEST = 1 << 20           # bytes of the file
_COUNT = re.compile(r"\d{1,6}")
_NUMBER = re.compile(r"[-+]?(\d{1,20}([.,]\d{0,40})?|[.,]\d{1,40})([eE][-+]?\d{1,3})?")
_LEAST, _MOST = 0.5, 2.0    # length of what is a unit vector that was rounded or measured


class LightPositions(NamedTuple):
    """The lights of photographs."""

    names: tuple[str, ...]
    """Of the files, as they are written."""
    directions: FloatArray
    """Unit vectors toward the lights, in the camera's axes: (n, 3)."""


def read(path: str | Path) -> LightPositions:
    """The light positions in a file. Raises DatasetError, which names the line, if they are not there."""
    path = Path(path)
    content = read_bytes(path, LARGEST)
    text = content.decode("utf-8-sig", errors="surrogateescape")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines or not _COUNT.fullmatch(lines[0][1]):
        raise DatasetError(f"line 1: {lines[0][1][:40]!r} found, expected the number of photographs" if lines
                           else "empty, expected the number of photographs", path)
    count, rows = int(lines[0][1]), lines[1:]
    if len(rows) != count or not count:
        raise DatasetError(f"line 1: {count} photographs are promised, {len(rows)} lines follow", path)
    named = [_row(line, number, path) for number, line in rows]
    return LightPositions(tuple(name for name, _ in named), np.array([direction for _, direction in named]))


def _row(line: str, number: int, path: Path) -> tuple[str, FloatArray]:
    """The name and the unit vector of a line."""
    parts = [part.strip().rstrip(",") for part in line.replace(";", " ").rsplit(None, 3)]
    if len(parts) < 4:
        parts = [part.strip() for part in line.rsplit(",", 3)]
    if len(parts) < 4 or not all(_NUMBER.fullmatch(text) for text in parts[1:]):
        raise DatasetError(f"line {number}: {line[:60]!r} found, expected the name of a file and three numbers", path)
    direction = np.array([float(text.replace(",", ".")) for text in parts[1:]])
    length = float(np.linalg.norm(direction))
    if not _LEAST < length < _MOST:
        raise DatasetError(f"line {number}: a vector of the length {length:.3g} found, expected a unit vector", path)
    return parts[0].strip("\"'"), direction / length
