"""Where lamps are, by the tables of a description: at a place, or far away in a direction; or by a chrome ball."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import ArrayLike, FloatArray, RealArray
from ..errors import DatasetError
from . import light_positions
from .chrome import Highlight, lamp_of_highlight
from .descriptions import Description, pictures_in
from .table import Table
from .viewpoint import Viewpoint

KEYS = "lamp", "direction", "chrome", "distance"
PLACED = "lamp", "direction", "distance"     # those that need no chrome ball
FAR = 1e4                   # sizes of what it lights, to a lamp far away, which lights all of it alike to 1e-4
_OF_UNIT = 1e-12            # least length of a vector that has a direction


class Lamp(NamedTuple):
    """A lamp of a description."""

    toward: FloatArray
    """Its place, metres, or where it is far the unit vector toward it: (3,)."""
    is_far: bool

    def at(self, middle: ArrayLike, size: float) -> FloatArray:
        """The place of the lamp, (3,), for what is in this place and of this size, metres."""
        return np.asarray(middle, dtype=float) + FAR * size * self.toward if self.is_far else self.toward


class ChromeBall(NamedTuple):
    """A chrome ball in the place of what is measured; metres."""

    centre: FloatArray
    radius: float


def lamp_of(table: Table, shown: RealArray | None, view: Viewpoint, camera: ArrayLike, middle: FloatArray,
            chrome: ChromeBall) -> Lamp:
    """The lamp of a table that has one of `KEYS`.

    Parameters
    ----------
    shown : (height, width, channels) float64, or None
        The picture of the chrome ball, where the table has one.
    camera : (3,) array_like
        The place of the view's camera, also where that was far.
    middle : (3,) float64
        Of what is measured, which distances count from, metres.
    chrome : ChromeBall
    """
    if sum(map(table.has, ("lamp", "direction", "chrome"))) != 1:
        raise table.error("lamp", "a position, or instead of it a direction, or chrome")
    if shown is None:
        return placed_lamp(table, middle)
    highlight = lamp_of_highlight(shown, view.rays, camera, chrome.centre, chrome.radius,
                                  table.files("chrome")[0].name)
    return (Lamp(highlight.at(table.needed("distance")), False) if table.has("distance")
            else Lamp(highlight.direction, True))


def placed_lamp(table: Table, middle: FloatArray, turn: FloatArray | None = None,
                ball: FloatArray | None = None) -> Lamp:
    """The lamp of a table that has one of `PLACED`; `turn` (3, 3) is from the axes of its direction to the scene's, and
    the direction holds at `ball` (3,), by default in the middle, which the distance counts from."""
    if sum(map(table.has, ("lamp", "direction"))) != 1:
        raise table.error("lamp", "a position, or instead of it a direction")
    if table.has("lamp"):
        return Lamp(table.numbers("lamp", 3), False)
    direction = direction_of(table) if turn is None else turn @ direction_of(table)
    if not table.has("distance"):
        return Lamp(direction, True)
    distance = table.needed("distance")
    return Lamp(middle + distance * direction if ball is None else Highlight(ball, direction, middle).at(distance),
                False)


def direction_of(table: Table) -> FloatArray:
    """The unit vector of the key `direction`: (3,)."""
    vector = table.numbers("direction", 3)
    length = float(np.linalg.norm(vector))
    if not length > _OF_UNIT:
        raise table.error("direction", "a vector toward the lamp")
    return np.asarray(vector / length)


def alike(lamps: Sequence[Lamp], path: Path) -> bool:
    """Whether the lamps of photographs, one or more, are far. DatasetError if some are, and others are not: it is not
    known then how bright they are beside each other."""
    if len({lamp.is_far for lamp in lamps}) > 1:
        raise DatasetError("some lamps have a place, and some only a direction, expected the same of all: give chrome "
                           "balls their distance, or places in the place of directions", path)
    return lamps[0].is_far


def with_light_positions(description: Description, path: Path, turn: FloatArray,
                         ) -> tuple[Description, tuple[str, ...]]:
    """A description whose photographs have the directions of its `lamp.positions`, a file of `light_positions`; and
    notes.

    Where it has no photographs they are those of the file, or all pictures beside it. `turn` is the rotation from the
    camera's axes, which the file has, to those of the directions: (3, 3).
    """
    table = Table(description, "", path)
    lamp = table.table("lamp")
    if not lamp.has("positions"):
        return description, ()
    file = lamp.files("positions")[0]
    found = light_positions.read(file)
    notes: tuple[str, ...] = ()
    if "photograph" in description:
        shots = description["photograph"]
        if len(table.tables("photograph")) != len(found.names):
            raise DatasetError(f"{len(found.names)} light positions found, expected {len(shots)}, one for each "
                               f"photograph", file)
    else:
        files, are_named = _files_of(found, file.parent)
        shots = [{"files": [str(each.absolute())]} for each in files]
        if not are_named:
            notes = f"{file.name} names other files: photographs and light positions belong together by their order",
    dark = np.asarray(~found.directions.any(axis=1))
    if dark.any():
        missing = ", ".join(Path(str(shots[k].get("files", k + 1) if isinstance(shots[k], dict) else k + 1).strip(
            "[']")).name for k in np.flatnonzero(dark))
        notes += f"Left out, for {file.name} has no light of them: {missing}",
        shots = [each for each, is_dark in zip(shots, dark, strict=True) if not is_dark]
    directions = found.directions[~dark] @ turn.T
    distance = {"distance": lamp.needed("distance")} if lamp.has("distance") else {}
    lit = [{**shot, "direction": direction.tolist(), **distance}
           for shot, direction in zip(shots, directions, strict=True)]
    return {**description, "photograph": lit}, notes


def _alike(pictures: Sequence[Path]) -> list[tuple[Path, ...]]:
    """Pictures, and those of each kind of file."""
    kinds = dict.fromkeys(each.suffix for each in pictures)
    return [tuple(pictures), *(tuple(each for each in pictures if each.suffix == kind) for kind in kinds)]


def _files_of(found: light_positions.LightPositions, folder: Path) -> tuple[list[Path], bool]:
    """The files of light positions in a folder, and whether they are those that it names.

    Names may have folders of another machine. Of a dome whose lights were found once, photographs of later objects have
    other names: then they are all pictures of the folder, if these are as many.
    """
    are_named = all(found.names)
    for names in (found.names, [re.split(r"[/\\]", name)[-1] for name in found.names]) if are_named else ():
        files = [folder / name for name in names]
        if all(each.is_file() for each in files):
            return files, True
    pictures = pictures_in(folder)
    if not are_named:
        # what relight has made is in a folder beside the photographs, or within theirs, and the ball's picture in that
        beside = [each for place in (folder, folder.parent) for each in _alike(pictures_in(place))]
        pictures = next((each for each in beside if len(each) == len(found.names)), ())
        files = [folder / "photograph"] * len(found.names)
    if len(pictures) != len(found.names):
        missing = next(each.name for each in files if not each.is_file())
        raise DatasetError(f"cannot be read: no such file, and {len(pictures)} pictures beside it, where the light "
                           f"positions are {len(found.names)}", folder / missing)
    return list(pictures), not are_named
