"""Light positions of reflectance transformation imaging, `.lp` files and projects of relight, of which domes have one.

Text: the number of photographs, then for each a line: the name of its file, and x, y, z of the direction to the light,
nearly a unit vector, x to the right in the picture, y up, z toward the camera; 0 0 0 where it was not found (T.
Malzbender, D. Gelb, H. Wolters: Polynomial Texture Maps, SIGGRAPH 2001). Some have decimal commas, blanks in names, or
folders of another machine. relight's projects are JSON: `.relight` has `images`, each with `filename`, `direction` and
`skip`, in a `folder` beside it; `info.json`, of what it has made, has `lights`, three numbers each, without names.
"""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import DatasetError
from ...storage.files import read_bytes

SUFFIX, PROJECTS = ".lp", (".json", ".relight")
_LARGEST = 1 << 20           # bytes of the file
_COUNT = re.compile(r"\d{1,6}")
_NUMBER = re.compile(r"[-+]?(\d{1,20}([.,]\d{0,40})?|[.,]\d{1,40})([eE][-+]?\d{1,3})?")
_LEAST, _MOST = 0.5, 2.0    # length of what is a unit vector that was rounded or measured


class LightPositions(NamedTuple):
    """The lights of photographs."""

    names: tuple[str, ...]  # of the files, as they are written; empty where they are not
    directions: FloatArray  # unit vectors toward the lights, in the camera's axes, 0 where one was not found: (n, 3)


def read(path: str | Path) -> LightPositions:
    """The light positions in a file. Raises DatasetError, which names the line, if they are not there."""
    path, names, directions = Path(path), list[str](), list[FloatArray]()
    text = read_bytes(path, _LARGEST).decode("utf-8-sig", errors="surrogateescape")
    for name, where, vector in (_read_project if path.suffix.lower() in PROJECTS else _read_lines)(text, path):
        length = float(np.linalg.norm(vector))
        if length and not _LEAST < length < _MOST:
            raise DatasetError(f"{where}: a vector of the length {length:.3g} found, expected a unit vector", path)
        names.append(name)
        directions.append(vector / (length or 1.0))
    if not np.any(directions):
        raise DatasetError("no light was found for any of the photographs", path)
    return LightPositions(tuple(names), np.array(directions))


def _read_lines(text: str, path: Path) -> Iterator[tuple[str, str, FloatArray]]:
    """The names of files, where they stand, and vectors toward their lights."""
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines or not _COUNT.fullmatch(lines[0][1]):
        raise DatasetError(f"line 1: {lines[0][1][:40]!r} found, expected the number of photographs" if lines
                           else "empty, expected the number of photographs", path)
    count, rows = int(lines[0][1]), lines[1:]
    if len(rows) != count or not count:
        raise DatasetError(f"line 1: {count} photographs are promised, {len(rows)} lines follow", path)
    for number, line in rows:
        parts = [part.strip().rstrip(",") for part in line.replace(";", " ").rsplit(None, 3)]
        if len(parts) < 4:
            parts = [part.strip() for part in line.rsplit(",", 3)]
        if len(parts) < 4 or not all(_NUMBER.fullmatch(text) for text in parts[1:]):
            raise DatasetError(f"line {number}: {line[:60]!r} found, expected the name of a file and three numbers",
                               path)
        yield parts[0].strip("\"'"), f"line {number}", np.array([float(each.replace(",", ".")) for each in parts[1:]])


def _read_project(text: str, path: Path) -> Iterator[tuple[str, str, FloatArray]]:
    """The same of a project of relight, whose directions are lists, or x, y and z by name; 0 where there is none."""
    try:
        values = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DatasetError(f"not JSON: {error}", path) from error
    images, lights = (values.get(key) if isinstance(values, dict) else None for key in ("images", "lights"))
    if isinstance(images, list) and images and all(isinstance(each, dict) for each in images):
        folder = str(values.get("folder") or ".")
        given = [(str(Path(folder, str(each.get("filename", "")))),
                  None if each.get("skip") is True else each.get("direction")) for each in images]
    elif isinstance(lights, list) and lights and len(lights) % 3 == 0:
        given = [("", lights[k:k + 3]) for k in range(0, len(lights), 3)]
    else:
        raise DatasetError("a project without images that have directions, or lights of three numbers each", path)
    for number, (name, value) in enumerate(given, start=1):
        numbers = ([value.get(key) for key in "xyz"] if isinstance(value, dict) else
                   [0, 0, 0] if value is None else value)
        if not isinstance(numbers, list) or len(numbers) != 3 or not all(
                isinstance(each, int | float) and not isinstance(each, bool) for each in numbers):
            raise DatasetError(f"light {number}: {str(value)[:60]!r} found, expected three numbers", path)
        yield name, f"light {number}", np.array(numbers, dtype=float)
