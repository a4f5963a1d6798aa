"""Descriptions of photographs as they are read: of a file in TOML, of light positions, or of a folder with either."""

import re
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import DatasetError
from ..storage.files import read_bytes
from . import light_positions

LARGEST = 1 << 20           # bytes of the file
_LONGEST_LINE = 4096        # bytes
_DEEPEST = 6                # a matrix in a table in a list of tables has 5
PICTURES = ".exr", ".tif", ".tiff", ".png", ".jpg", ".jpeg"
GUESS = 0.5                 # of an albedo, where there is nothing better
SUFFIXES = ".toml", light_positions.SUFFIX       # of what is a description
_FILES = "mask", "dark", "flat", "file", "files", "chrome", "positions"


Description = dict[str, Any]
"""What a file holds, by key."""


class Read(NamedTuple):
    """A description, and the path that errors name and beside which its files are."""

    description: Description
    path: Path


def read(path: str | Path) -> Read:
    """The description in a file, of light positions (`.lp`), or of a folder that has one of these.

    Of light positions alone camera and lamps are far away, the ball is at its outline, and its albedo is a guess.

    Raises DatasetError if there is no such file, several, or one that cannot be read.
    """
    path = Path(path)
    if path.is_dir():
        path = _only_one(path)
    if path.suffix.lower() == light_positions.SUFFIX:
        return Read({"name": path.absolute().parent.name or path.stem, "camera": {"position": "far"},
                     "ball": {"centre": "outline"}, "lamp": {"positions": path.name}, "scale": {"albedo": GUESS}}, path)
    return Read(_toml(path), path)


def descriptions_in(folder: Path) -> list[Path]:
    """The descriptions in a folder, or where there are none its light positions."""
    try:
        files = sorted(each for each in folder.iterdir() if each.is_file() and not each.name.startswith("."))
    except OSError as error:
        raise DatasetError(f"cannot be read: {error.strerror or error}", folder) from error
    found = ([each for each in files if each.suffix.lower() == suffix] for suffix in SUFFIXES)
    return next(filter(None, found), [])


def _only_one(folder: Path) -> Path:
    found = descriptions_in(folder)
    if len(found) > 1:
        raise DatasetError(f"several descriptions found, {', '.join(each.name for each in found[:4])}: choose one of "
                           f"them", folder)
    if not found:
        raise DatasetError("a folder without a description: expected light positions (.lp) beside the photographs, or "
                           "a description in TOML", folder)
    return found[0]


def _toml(path: Path) -> Description:
    content = read_bytes(path, LARGEST)
    for number, line in enumerate(content.splitlines(), start=1):
        if len(line) > _LONGEST_LINE:       # its reader takes minutes for keys of a hundred thousand parts
            raise DatasetError(f"{len(line):,} bytes in a line, expected at most {_LONGEST_LINE:,}", path, number)
    try:
        description = tomllib.loads(content.decode("utf-8"))
    except (ValueError, RecursionError) as error:       # ValueError of whole numbers of many thousand digits, too
        raise DatasetError(f"not TOML: {error}", path) from error
    if _is_deeper(description, _DEEPEST):
        raise DatasetError(f"tables within tables, expected at most {_DEEPEST} deep", path)
    return description


def _is_deeper(value: Any, levels: int) -> bool:
    """Whether tables and lists lie within each other more than so many times."""
    if not isinstance(value, dict | list):
        return False
    return levels == 0 or any(_is_deeper(each, levels - 1)
                              for each in (value.values() if isinstance(value, dict) else value))


def pictures_in(folder: Path) -> tuple[Path, ...]:
    """The pictures in a folder, 2 before 10."""
    return tuple(sorted((each for each in folder.iterdir() if each.suffix.lower() in PICTURES and each.is_file()
                         and not each.name.startswith(".")), key=lambda each: in_order(each.name)))


def in_order(name: str) -> list[tuple[int, str]]:
    """What sorts names of files by their numbers.

    Examples
    --------
    >>> sorted(["lamp10.exr", "lamp2.exr"], key=in_order)
    ['lamp2.exr', 'lamp10.exr']
    """
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)]


def with_paths(value: Any, folder: Path) -> Any:
    """A description, or a part of it, with absolute paths in the place of those that are relative to a folder."""
    if isinstance(value, list):
        return [with_paths(each, folder) for each in value]
    if not isinstance(value, dict):
        return value

    def absolute(name: Any) -> Any:
        if isinstance(name, list):
            return [absolute(each) for each in name]
        return str((folder / name).absolute()) if isinstance(name, str) else name

    return {key: absolute(each) if key in _FILES and not isinstance(each, dict) else with_paths(each, folder)
            for key, each in value.items()}
