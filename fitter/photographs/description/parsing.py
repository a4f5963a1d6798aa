"""Descriptions of photographs, read from TOML or light positions. All that is wrong in one is said at once."""

import re
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import MISSING, Field, fields, replace
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np

from ...errors import DatasetError
from ...storage.files import read_bytes
from . import light_positions
from .capture_setup import GUESS, CaptureSetup, Description, Kind, Section, Shot, abbreviate, complaint, key_path

PICTURES = ".exr", ".tif", ".tiff", ".png", ".jpg", ".jpeg"
SUFFIXES = ".toml", light_positions.SUFFIX      # of what is a description
_BYTES = 1 << 20            # of the file
_LONGEST_LINE = 4096        # bytes
_DEEPEST = 6                # a matrix in a table in a list of tables has 5
_Section = TypeVar("_Section", bound=Section)


def read(path: str | Path) -> CaptureSetup:
    """The description in a file of TOML, of light positions (`.lp`), or of a folder that has one of these.

    Of light positions alone camera and lamps are far away, the ball is at its outline, and its albedo is a guess.

    Raises DatasetError if there is no such file, several, or one that cannot be read, or is wrong.
    """
    path = Path(path)
    if path.is_dir():
        folder, path = path, find_description(path)
        if path == folder:
            raise DatasetError("a folder without a description: expected light positions (.lp) beside the photographs, "
                               "or a description in TOML", folder)
    if path.suffix.lower() == light_positions.SUFFIX:
        return parse({"name": path.absolute().parent.name or path.stem, "camera": {"position": "far"},
                      "ball": {"centre": "outline"}, "lamp": {"positions": path.name}, "scale": {"albedo": GUESS}},
                     path)
    return parse(_toml(path), path)


def _toml(path: Path) -> Description:
    content = read_bytes(path, _BYTES)
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


def parse(description: Description, path: str | Path) -> CaptureSetup:
    """A description that a file holds, or that was made elsewhere: errors name the path, and files are beside it.

    Raises DatasetError, whose message has all that is wrong.
    """
    path = Path(path)
    surfaces = sorted({"ball", "sample"} & description.keys())
    parser = _Parser(path, surfaces[0] if len(surfaces) == 1 else "ball")
    if len(surfaces) != 1:
        parser.errors.append(f"{' and '.join(surfaces)} are there, expected one of them" if surfaces
                             else "ball is missing, expected a table [ball], or [sample] of a flat sample")
    setup = parser.parse_table(CaptureSetup, description, "")
    if setup is None or parser.errors:
        raise DatasetError("; ".join(parser.errors), path)
    if setup.lamp.positions:
        setup = _add_light_positions(setup)
    errors = [] if setup.photographs else ["photograph is missing, expected one table [[photograph]] or more"]
    names = {each.name for shot in setup.photographs for each in shot.files}
    if missing := [each for each in setup.leave_out if Path(each).name not in names]:
        errors.append(setup.complaint("leave_out", f"names of photographs: {missing[0]} is none"))
    errors += setup.contradictions()
    if errors:
        raise DatasetError("; ".join(errors), path)
    dropped = {Path(each).name for each in setup.leave_out}
    return replace(setup, photographs=tuple(shot for shot in setup.photographs
                                            if not dropped & {each.name for each in shot.files}))


class _Parser:
    """Makes sections of tables, for a ball or a sample, and collects all that is wrong with them."""

    def __init__(self, path: Path, surface: str) -> None:
        self.path, self.surface = path, surface
        self.errors: list[str] = []

    def parse_table(self, cls: type[_Section], values: Any, where: str) -> _Section | None:
        """A table as what it stands for; None where something in it is wrong."""
        if not isinstance(values, dict):
            self.errors.append(f"{where} is {abbreviate(values)}, expected a table")
            return None
        known, before = dict(self._keys(cls)), len(self.errors)
        self.errors += [f"{key_path(where, str(key))} is not known, expected one of {', '.join(known)}"
                        for key in values if key not in known]
        found = {each.name: self._parse_value(kind, key, values, where)
                 for key, (each, kind) in known.items() if key in values or each.default is MISSING}
        if len(self.errors) > before:
            return None
        made = cls(where=where, path=self.path, **found)
        if cls is not CaptureSetup:         # whose photographs may be those of light positions
            self.errors += made.contradictions()
        return made

    def _keys(self, cls: type[Section]) -> Iterator[tuple[str, tuple["Field[Any]", Any]]]:
        """The keys of a table, their fields, and what these are."""
        hints = get_type_hints(cls, include_extras=True)
        for each in fields(cls):
            kind, *surface = getattr(hints[each.name], "__metadata__", (None, "none"))
            if surface in ([], [self.surface]):
                yield "photograph" if kind is Shot else each.name, (each, kind)

    def _parse_value(self, kind: Kind | type[Section], key: str, values: Description, where: str) -> Any:
        name = key_path(where, key)
        if kind is Shot:
            if isinstance(values[key], list) and values[key]:
                return tuple(self.parse_table(Shot, each, f"{name} {number}")
                             for number, each in enumerate(values[key], start=1))
            self.errors.append(f"{name} is {abbreviate(values[key])}, expected one table [[{key}]] or more")
        elif isinstance(kind, type):
            return self.parse_table(kind, values.get(key, {}), name)
        else:
            with suppress(ValueError, OverflowError, KeyError):
                return kind.convert(values[key], self.path.parent)
            self.errors.append(complaint(where, key, values.get(key), kind.expected))
        return None


def _add_light_positions(setup: CaptureSetup) -> CaptureSetup:
    """A description whose photographs have the directions of its `lamp.positions`, in the camera's axes: by default
    those of the file, or all pictures beside it."""
    file = (setup.lamp.positions or ())[0]
    found = light_positions.read(file)
    notes, shots = [*setup.notes], setup.photographs
    if shots and len(shots) != len(found.names):
        raise DatasetError(f"{len(found.names)} light positions found, expected {len(shots)}, one for each photograph",
                           file)
    if not shots:
        files, are_named = _photographs_for(found, file.parent)
        shots = tuple(Shot(where=f"photograph {number}", path=setup.path, files=(each,))
                      for number, each in enumerate(files, start=1))
        if not are_named:
            notes.append(f"{file.name} names other files: photographs and light positions belong together by their "
                         f"order")
    is_dark = np.asarray(~found.directions.any(axis=1))
    if is_dark.any():
        missing = ", ".join(shots[k].name for k in np.flatnonzero(is_dark))
        notes.append(f"Left out, for {file.name} has no light of them: {missing}")
    lit = [replace(shot, direction=direction, lamp=None, chrome=None, distance=setup.lamp.distance)
           for shot, direction, dark in zip(shots, found.directions, is_dark, strict=True) if not dark]
    return replace(setup, photographs=tuple(lit), notes=tuple(notes))


def _photographs_for(found: light_positions.LightPositions, folder: Path) -> tuple[list[Path], bool]:
    """The files of light positions in a folder, and whether they are those that it names.

    Names may have folders of another machine. Of a dome whose lights were found once, photographs of later objects have
    other names: then they are all pictures of the folder, if these are as many.
    """
    are_named = all(found.names)
    for names in (found.names, [re.split(r"[/\\]", name)[-1] for name in found.names]) if are_named else ():
        files = [folder / name for name in names]
        if all(each.is_file() for each in files):
            return files, True
    pictures = find_files(folder, *PICTURES)
    if not are_named:
        # what relight has made is in a folder beside the photographs, or within theirs, and the ball's picture in that
        beside = [find_files(place, *kinds) for place in (folder, folder.parent)
                  for kinds in (PICTURES, *((each,) for each in PICTURES))]
        pictures = next((each for each in beside if len(each) == len(found.names)), [])
        files = [folder / "photograph"] * len(found.names)
    if len(pictures) != len(found.names):
        missing = next(each.name for each in files if not each.is_file())
        raise DatasetError(f"cannot be read: no such file, and {len(pictures)} pictures beside it, where the light "
                           f"positions are {len(found.names)}", folder / missing)
    return pictures, not are_named


def find_description(folder: Path) -> Path:
    """The only description in a folder, else its only light positions, or itself where there is neither."""
    for suffix in SUFFIXES:
        found = find_files(folder, suffix)
        if len(found) > 1:
            raise DatasetError(f"several descriptions found, {', '.join(each.name for each in found[:4])}: choose one "
                               "of them", folder)
        if found:
            return found[0]
    return folder


def find_files(folder: Path, *suffixes: str) -> list[Path]:
    """The files in a folder that end so, 2 before 10."""
    try:
        return sorted((each for each in folder.iterdir() if each.suffix.lower() in suffixes and each.is_file()
                       and not each.name.startswith(".")), key=lambda each: natural_order(each.name))
    except OSError as error:
        raise DatasetError(f"cannot be read: {error.strerror or error}", folder) from error


def natural_order(name: str) -> list[tuple[int, str]]:
    """What sorts names of files by their numbers."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", name)]
