"""Which files of a folder are descriptions, and which are photographs."""

import re
from pathlib import Path

from ...errors import DatasetError
from .light_positions import SUFFIX

PICTURES = ".exr", ".tif", ".tiff", ".png", ".jpg", ".jpeg"
SUFFIXES = ".toml", SUFFIX      # of what is a description


def descriptions_in(folder: Path) -> list[Path]:
    """The descriptions in a folder, or where there are none its light positions."""
    try:
        files = sorted(each for each in folder.iterdir() if each.is_file() and not each.name.startswith("."))
    except OSError as error:
        raise DatasetError(f"cannot be read: {error.strerror or error}", folder) from error
    found = ([each for each in files if each.suffix.lower() == suffix] for suffix in SUFFIXES)
    return next(filter(None, found), [])


def only_description(folder: Path) -> Path:
    """The description in a folder. DatasetError where there is none, or more than one."""
    found = descriptions_in(folder)
    if len(found) > 1:
        raise DatasetError(f"several descriptions found, {', '.join(each.name for each in found[:4])}: choose one of "
                           f"them", folder)
    if not found:
        raise DatasetError("a folder without a description: expected light positions (.lp) beside the photographs, or "
                           "a description in TOML", folder)
    return found[0]


def pictures_in(folder: Path) -> tuple[Path, ...]:
    """The pictures in a folder, 2 before 10."""
    return tuple(sorted((each for each in folder.iterdir() if each.suffix.lower() in PICTURES and each.is_file()
                         and not each.name.startswith(".")), key=lambda each: natural_order(each.name)))


def natural_order(name: str) -> list[tuple[int, str]]:
    """What sorts names of files by their numbers.

    Examples
    --------
    >>> sorted(["lamp10.exr", "lamp2.exr"], key=natural_order)
    ['lamp2.exr', 'lamp10.exr']
    """
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)]
