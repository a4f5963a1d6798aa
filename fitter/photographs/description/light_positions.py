"""Light positions of reflectance transformation imaging, `.lp` files and projects of relight, of which domes have one.

Text: the number of photographs, then a line for each: the name of its file, and x, y, z of the direction to the light,
x to the right in the picture, y up, z toward the camera. They are unit vectors, nearly; some are written with decimal
commas, names have blanks, or folders of the machine that took the photographs (T. Malzbender, D. Gelb, H. Wolters:
Polynomial Texture Maps, SIGGRAPH 2001; Cultural Heritage Imaging's RTIBuilder and CNR's relight write them). A light
that was not found is 0 0 0.

relight's projects are JSON: `.relight` has `images`, each with `filename`, `direction` and `skip`, in a `folder` beside
it; `info.json`, of what it has made, has `lights`, three numbers each, without names.
"""

import json
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import DatasetError
from ...storage.files import read_bytes

SUFFIX, PROJECTS = ".lp", (".json", ".relight")
LARGEST = 1 << 20           # bytes of the file
_COUNT = re.compile(r"\d{1,6}")
_NUMBER = re.compile(r"[-+]?(\d{1,20}([.,]\d{0,40})?|[.,]\d{1,40})([eE][-+]?\d{1,3})?")
_LEAST, _MOST = 0.5, 2.0    # length of what is a unit vector that was rounded or measured


class LightPositions(NamedTuple):
    """The lights of photographs."""

    names: tuple[str, ...]  # of the files, as they are written; empty where they are not
    directions: FloatArray  # unit vectors toward the lights, in the camera's axes, 0 where one was not found: (n, 3)


def read(path: str | Path) -> LightPositions:
    """The light positions in a file. Raises DatasetError, which names the line, if they are not there."""
    path = Path(path)
    content = read_bytes(path, LARGEST)
    text = content.decode("utf-8-sig", errors="surrogateescape")
    if path.suffix.lower() in PROJECTS:
        return _project(text, path)
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines or not _COUNT.fullmatch(lines[0][1]):
        raise DatasetError(f"line 1: {lines[0][1][:40]!r} found, expected the number of photographs" if lines
                           else "empty, expected the number of photographs", path)
    count, rows = int(lines[0][1]), lines[1:]
    if len(rows) != count or not count:
        raise DatasetError(f"line 1: {count} photographs are promised, {len(rows)} lines follow", path)
    named = [_row(line, number, path) for number, line in rows]
    return _positions([name for name, _ in named], [direction for _, direction in named], path)


def _positions(names: list[str], directions: list[FloatArray], path: Path) -> LightPositions:
    if not np.any(directions):
        raise DatasetError("no light was found for any of the photographs", path)
    return LightPositions(tuple(names), np.array(directions))


def _project(text: str, path: Path) -> LightPositions:
    """The light positions in a project of relight."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DatasetError(f"not JSON: {error}", path) from error
    images, lights = (values.get(key) if isinstance(values, dict) else None for key in ("images", "lights"))
    if isinstance(images, list) and images and all(isinstance(each, dict) for each in images):
        folder = str(values.get("folder") or ".")
        return _positions([str(Path(folder, str(each.get("filename", "")))) for each in images],
                          [np.zeros(3) if each.get("skip") is True else
                           _project_direction(each.get("direction"), number, path)
                           for number, each in enumerate(images, start=1)], path)
    if isinstance(lights, list) and lights and len(lights) % 3 == 0:
        return _positions([""] * (len(lights) // 3),
                          [_project_direction(lights[k:k + 3], k // 3 + 1, path)
                           for k in range(0, len(lights), 3)], path)
    raise DatasetError("a project without images that have directions, or lights of three numbers each", path)


def _project_direction(value: object, number: int, path: Path) -> FloatArray:
    """A direction as a list, or as x, y and z by name; 0 where there is none."""
    numbers = [value.get(key) for key in "xyz"] if isinstance(value, dict) else value
    if numbers is None:
        return np.zeros(3)
    if not isinstance(numbers, list) or len(numbers) != 3 or not all(
            isinstance(each, int | float) and not isinstance(each, bool) for each in numbers):
        raise DatasetError(f"light {number}: {str(value)[:60]!r} found, expected three numbers", path)
    return _unit(np.array(numbers, dtype=float), f"light {number}", path)


def _unit(direction: FloatArray, where: str, path: Path) -> FloatArray:
    """A unit vector; 0 of a light that was not found."""
    length = float(np.linalg.norm(direction))
    if length == 0:
        return direction
    if not _LEAST < length < _MOST:
        raise DatasetError(f"{where}: a vector of the length {length:.3g} found, expected a unit vector", path)
    return np.asarray(direction / length)


def _row(line: str, number: int, path: Path) -> tuple[str, FloatArray]:
    """The name and the unit vector of a line."""
    parts = [part.strip().rstrip(",") for part in line.replace(";", " ").rsplit(None, 3)]
    if len(parts) < 4:
        parts = [part.strip() for part in line.rsplit(",", 3)]
    if len(parts) < 4 or not all(_NUMBER.fullmatch(text) for text in parts[1:]):
        raise DatasetError(f"line {number}: {line[:60]!r} found, expected the name of a file and three numbers", path)
    direction = np.array([float(text.replace(",", ".")) for text in parts[1:]])
    return parts[0].strip("\"'"), _unit(direction, f"line {number}", path)
