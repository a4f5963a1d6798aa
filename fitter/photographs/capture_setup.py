"""The description of photographs: where camera, sample and lamps were, and which file is which.

A file of it is TOML; `CaptureSetup` and its parts have its keys as attributes, and their docstrings say what they mean.
Lengths are metres, angles degrees, paths relative to the file, places in a picture pixels from its left and its top.
Those of a ball are in `[ball]`, those of a flat sample in `[sample]` ::

    name = "red snooker ball"

    [camera]
    position = [0, -1.5, 0.2]
    field_of_view = 12

    [ball]
    centre = "outline"
    radius = 0.026

    [scale]
    card = {file = "card.exr", albedo = 0.18, normal = [0, -1, 0], lamp = [0, -1, 0.5], region = [200, 180, 260, 240]}

    [[photograph]]
    files = ["a1.exr", "a2.exr"]    # exposures of one lamp
    lamp = [0.3, -1.1, 0.4]

Places are a flat sample's own: its middle is at 0, x runs along its width, y along its height, and z toward the camera.
All that is wrong in a description is said at once. Light positions (`light_positions`) are directions in the camera's
axes; with a camera that is far they say all there is to say.
"""

import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple, TypeVar, get_type_hints

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError, printable
from ..storage.files import read_bytes
from . import light_positions
from .picture_files import ENCODINGS

LEAST, LARGEST = 1e-9, 1e9  # of numbers: their squares and quotients are within double precision by far
GUESS = 0.5                 # of an albedo, where there is nothing better
MOST_MATERIALS = 4          # every choice of them is tried at each texel
MOST_TEXELS = 4096          # of maps, along both axes
PICTURES = ".exr", ".tif", ".tiff", ".png", ".jpg", ".jpeg"
SUFFIXES = ".toml", light_positions.SUFFIX      # of what is a description
SCALES = "intensity", "albedo", "card", "ball"
_BYTES = 1 << 20            # of the file
_LONGEST_LINE = 4096        # bytes
_LONGEST = 80               # characters of a value in a message
_DEEPEST = 6                # a matrix in a table in a list of tables has 5
_OF_UNIT = 1e-12            # least length of a vector that has a direction

Description = dict[str, Any]
"""What a file of TOML holds, by key."""
_Section = TypeVar("_Section", bound="Section")


class Kind(NamedTuple):
    """What values of a key are: in words, and what makes them of what TOML has, beside files of a folder; it raises
    ValueError where it cannot."""

    expected: str
    convert: Callable[[Any, Path], Any]


class Key(NamedTuple):
    """What a field is in a description: a value of a kind, or a table; of balls or samples only; by another name."""

    kind: "Kind | type[Section]"
    only: str = ""
    name: str = ""


def _number(value: Any, least: float = -LARGEST, most: float = LARGEST) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not least <= value <= most:
        raise ValueError
    return float(value)


def _vector(value: Any, count: int, least: float = -LARGEST) -> FloatArray:
    if not isinstance(value, list | tuple) or not value or len(value) != (count or len(value)):
        raise ValueError
    return np.array([_number(each, least) for each in value])


def _rows(value: Any, count: int, width: int) -> FloatArray:
    if not isinstance(value, list | tuple) or len(value) != (count or len(value)) or len(value) < 3:
        raise ValueError
    return np.array([_vector(each, width) for each in value])


def _texts(value: Any) -> list[str]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple) or not names or not all(isinstance(each, str) for each in names):
        raise ValueError
    return [*names]


def _word(*words: str, otherwise: Callable[[Any], Any] | None = None) -> Callable[[Any, Path], Any]:
    def convert(value: Any, _folder: Path) -> Any:
        if isinstance(value, str) and value in words:
            return value
        if otherwise is None:
            raise ValueError
        return otherwise(value)
    return convert


def _text(value: Any, _folder: Path) -> str:
    if not isinstance(value, str):
        raise ValueError
    return printable(value)


def _materials(value: Any, folder: Path) -> int | tuple[Path, ...]:
    if isinstance(value, int):
        return int(_number(value, 1, MOST_MATERIALS))
    return tuple(folder / each for each in _texts(value))


def _direction(value: Any, _folder: Path) -> FloatArray:
    vector = _vector(value, 3)
    if not np.linalg.norm(vector) > _OF_UNIT:
        raise ValueError
    return np.asarray(vector / np.linalg.norm(vector))


def _positive_values(value: Any, _folder: Path) -> FloatArray:
    return np.array(_number(value, LEAST)) if not isinstance(value, list | tuple) else _vector(value, 0, LEAST)


_POSITIVE = Kind(f"a number of {LEAST:g} to {LARGEST:g}", lambda value, _: _number(value, LEAST))
_PLACE = Kind("3 numbers", lambda value, _: _vector(value, 3))
_CAMERA, _CENTRE = (Kind(f'3 numbers, or "{word}"', _word(word, otherwise=lambda value: _vector(value, 3)))
                    for word in ("far", "outline"))
_DIRECTION = Kind("a vector toward it, 3 numbers", _direction)
_REGION = Kind("4 numbers", lambda value, _: _vector(value, 4))
_MATRIX = Kind("three rows of three numbers", lambda value, _: _rows(value, 3, 3))
_CORNERS = Kind("four places of two numbers, pixels from the left and the top", lambda value, _: _rows(value, 4, 2))
_OUTLINE = Kind("three places of two numbers or more, pixels from the left and the top",
                lambda value, _: _rows(value, 0, 2))
_VALUES = Kind("a number above 0, or one for each channel", _positive_values)
_EXPOSURES = Kind(f"numbers of {LEAST:g} to {LARGEST:g}", lambda value, _: _vector(value, 0, LEAST))
_BRIGHTNESS = Kind('"found", or a number above 0 for each photograph',
                   _word("found", otherwise=lambda value: _vector(value, 0, LEAST)))
_ALBEDO = Kind("more than 0 and at most 1, of what reflects no more than it gets",
               lambda value, _: _number(value, LEAST, 1))
_TEXT = Kind("a text", _text)
_ENCODING = Kind(" or ".join(ENCODINGS), _word(*ENCODINGS))
_FILES = Kind("the name of a file, or a list of them",
              lambda value, folder: tuple(folder / each for each in _texts(value)))
_MATERIALS = Kind(f"files, or a number of 1 to {MOST_MATERIALS}", _materials)
_LEFT_OUT = Kind("names of photographs", lambda value, _: tuple(_texts(value)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Section:
    """A table of a description: a key that is not there is None, or has its default."""

    where: str = ""
    path: Path = Path()

    def error(self, key: str, expected: str) -> DatasetError:
        """What to raise where the value of a key is not as expected."""
        return DatasetError(self._complaint(key, getattr(self, key), expected), self.path)

    def _complaint(self, key: str, value: Any, expected: str) -> str:
        said = "is missing" if value is None else f"is {_abbreviate(value)}"
        return f"{_dotted(self.where, key)} {said}, expected {expected}"

    def _wrong(self) -> list[str]:
        """What is wrong with values together, each of which is of its kind."""
        return []

    def _lacks(self, key: str, expected: str, is_wrong: bool = True) -> list[str]:
        return [self._complaint(key, getattr(self, key), expected)] if is_wrong else []


@dataclass(frozen=True, kw_only=True, eq=False)
class Lit(Section):
    """What is in a picture under one lamp."""

    lamp: Annotated[FloatArray | None, Key(_PLACE)] = None
    """The lamp's place: (3,)."""
    direction: Annotated[FloatArray | None, Key(_DIRECTION)] = None
    """Or the unit vector toward one that is far away, or at `distance`."""
    exposures: Annotated[FloatArray | None, Key(_EXPOSURES)] = None
    """Of each file; by default those of EXIF."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Known(Lit):
    """A photograph of a card, or a ball, of known albedo."""

    file: Annotated[tuple[Path, ...], Key(_FILES)]
    albedo: Annotated[FloatArray, Key(_VALUES)]
    """Of all channels, or of each."""
    normal: Annotated[FloatArray | None, Key(_PLACE)] = None
    """Where a card faces; of one in a flat sample's plane [0, 0, 1]."""
    region: Annotated[FloatArray | None, Key(_REGION)] = None
    """The part of the picture that a card fills: left, top, right and bottom."""

    def _wrong(self) -> list[str]:
        return [*self._lacks("lamp", "a position, or instead of it a direction",
                             (self.lamp is None) == (self.direction is None)),
                *_count(self, "exposures", self.file)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot(Lit):
    """A photograph under one lamp: exposures of it."""

    files: Annotated[tuple[Path, ...], Key(_FILES)]
    chrome: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """The picture of a chrome ball under the same lamp, in the place of `lamp` or `direction`."""
    distance: Annotated[float | None, Key(_POSITIVE)] = None
    """Of a lamp from the middle of what is measured."""

    @property
    def name(self) -> str:
        """That of its first file, as terminals can show it."""
        return printable(self.files[0].name)

    def _wrong(self) -> list[str]:
        return _count(self, "exposures", self.files)


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraSetup(Section):
    """Where the camera stands, and how it sees."""

    position: Annotated[FloatArray | Literal["far"] | None, Key(_CAMERA)] = None
    """(3,), or "far" where nobody knows how far it is: straight above a sample. By default where a sample's corners
    say."""
    look_at: Annotated[FloatArray | None, Key(_PLACE, "ball")] = None
    """By default the ball's centre, or where that is the outline's, the origin."""
    direction: Annotated[FloatArray | None, Key(_PLACE, "ball")] = None
    """Of one that is far in the place of `look_at`: from the ball toward the camera, by default [0, 0, 1]."""
    up: Annotated[FloatArray | None, Key(_PLACE, "ball")] = None
    """By default [0, 0, 1], and of one that is far [0, 1, 0]: x is to the right in its pictures."""
    field_of_view: Annotated[float | None, Key(_POSITIVE)] = None
    """Of the width; or focal length and sensor width; or what EXIF says."""
    focal_length: Annotated[float | None, Key(_POSITIVE)] = None
    """mm."""
    sensor_width: Annotated[float | None, Key(_POSITIVE)] = None
    """mm."""
    matrix: Annotated[FloatArray | None, Key(_MATRIX)] = None
    """(3, 3), from the camera's colours to linear Rec.709; by default by the files' chromaticities."""
    encoding: Annotated[str | None, Key(_ENCODING)] = None
    """Of pixels, whatever the files say."""

    @property
    def is_far(self) -> bool:
        """Whether its distance is unknown."""
        return isinstance(self.position, str)

    def _wrong(self) -> list[str]:
        return [*self._lacks("look_at", "not that, but direction, toward the camera, for it is far",
                             self.is_far and self.look_at is not None),
                *self._lacks("direction", 'that of a camera whose position is "far"',
                             not self.is_far and self.direction is not None)]


@dataclass(frozen=True, kw_only=True, eq=False)
class BallSetup(Section):
    """Where a ball is; as `chrome`, one that shows where lamps are, by default in the place of what is measured."""

    centre: Annotated[FloatArray | Literal["outline"] | None, Key(_CENTRE)] = None
    """(3,), or found in the photographs."""
    radius: Annotated[float | None, Key(_POSITIVE)] = None
    """Of one that is photographed from afar under lamps far away it does not matter."""
    mask: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """A picture that is white where pixels count; of a chrome ball, where it is, which says its centre: in photographs
    of a flat sample it lies in its plane, if its radius does not say otherwise."""

    @property
    def is_by_outline(self) -> bool:
        """Whether the photographs say where it is."""
        return isinstance(self.centre, str)


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleSetup(Section):
    """A flat sample."""

    width: Annotated[float, Key(_POSITIVE)]
    height: Annotated[float, Key(_POSITIVE)]
    corners: Annotated[FloatArray | None, Key(_CORNERS)] = None
    """In the pictures: (4, 2), bottom left, bottom right, top right, top left of the maps."""
    mask: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """A picture that is white where it is: a coin or a leaf is no rectangle."""
    outline: Annotated[FloatArray | None, Key(_OUTLINE)] = None
    """Or the outline of that, (n, 2)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LampSetup(Section):
    """What all lamps share."""

    radius: Annotated[float, Key(_POSITIVE, "ball")] = 0.0
    """Of lamps that are balls."""
    positions: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """A file of light positions, in the place of those of the photographs, or of all of them."""
    distance: Annotated[float | None, Key(_POSITIVE)] = None
    """Of lamps whose directions `positions` or a chrome ball say, from the middle of what is measured."""
    dark: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """A photograph with the lamp off."""
    flat: Annotated[tuple[Path, ...] | None, Key(_FILES)] = None
    """And one of an evenly bright surface."""
    ball: Annotated[FloatArray | None, Key(_PLACE, "sample")] = None
    """Where a chrome ball stood, whose highlights say the directions of lamps at this distance."""
    brightness: Annotated[FloatArray | Literal["found"] | None, Key(_BRIGHTNESS, "sample")] = None
    """Of the lamps beside each other; or it is found by the sample itself, in each colour."""
    exposures = None            # of `dark` and `flat`: those of EXIF

    def _wrong(self) -> list[str]:
        if self.ball is None:
            return []
        if self.distance is None:
            return self._lacks("distance", _POSITIVE.expected)
        return self._lacks("ball", "a place nearer to the sample's middle than the lamps, which are "
                           f"{self.distance:g} m away", not np.linalg.norm(self.ball) < self.distance)


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaleSetup(Section):
    """How bright the lamps are: one of four."""

    intensity: Annotated[FloatArray | None, Key(_VALUES)] = None
    """W/sr in units of the pictures, in all channels or in each; of lamps far away as if these were 1 m away."""
    albedo: Annotated[float | None, Key(_ALBEDO)] = None
    """Of what is measured: a guess."""
    card: Annotated[Known | None, Key(Known)] = None
    """A card where the ball is, or in a sample's plane."""
    ball: Annotated[Known | None, Key(Known, "ball")] = None
    """A matte ball in the place of the other."""

    def way(self) -> str:
        """The name of what is given."""
        return next(each for each in SCALES if getattr(self, each) is not None)


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptureSetup(Section):
    """How photographs of a ball, or of a flat sample, were taken. `path` is what errors name."""

    name: Annotated[str | None, Key(_TEXT)] = None
    camera: Annotated[CameraSetup, Key(CameraSetup)] = field(default_factory=CameraSetup)
    ball: Annotated[BallSetup | None, Key(BallSetup, "ball")] = None
    sample: Annotated[SampleSetup | None, Key(SampleSetup, "sample")] = None
    chrome: Annotated[BallSetup | None, Key(BallSetup)] = None
    """A chrome ball, in pictures of its own, or in the photographs of a flat sample themselves."""
    lamp: Annotated[LampSetup, Key(LampSetup)] = field(default_factory=LampSetup)
    scale: Annotated[ScaleSetup, Key(ScaleSetup)] = field(default_factory=ScaleSetup)
    photographs: Annotated[tuple[Shot, ...], Key(Shot, name="photograph")] = ()
    materials: Annotated[int | tuple[Path, ...] | None, Key(_MATERIALS, "sample")] = None
    """What a sample is made of: saved fits, or measurements; or how many these are; else that is found."""
    leave_out: Annotated[tuple[str, ...], Key(_LEFT_OUT, "sample")] = ()
    """Files of photographs that do not count."""
    texels: Annotated[float | None, Key(_POSITIVE, "sample")] = None
    """Of the maps, along the width; by default as many as it has pixels."""
    notes: tuple[str, ...] = ()
    """What is to be said of how the photographs were found."""

    @property
    def title(self) -> str:
        """Its name, by default that of the file."""
        return self.path.stem if self.name is None else self.name

    @property
    def is_by_light_positions(self) -> bool:
        """Whether directions are in the camera's axes."""
        return self.lamp.positions is not None

    def of_ball(self) -> BallSetup:
        """The ball. DatasetError of a flat sample."""
        if self.ball is None:
            raise DatasetError("a flat sample is described, expected a table [ball]", self.path)
        return self.ball

    def of_sample(self) -> SampleSetup:
        """The flat sample. DatasetError of a ball."""
        if self.sample is None:
            raise DatasetError("a ball is described, expected a table [sample]", self.path)
        return self.sample

    def _wrong(self) -> list[str]:
        lines = []
        ways = [way for way in SCALES if getattr(self.scale, way) is not None]
        if len(ways) != 1:
            known = SCALES if self.sample is None else SCALES[:3]
            lines.append(f"scale has {', '.join(ways) or 'nothing'}, expected one of {', '.join(known)}")
        for each in self.photographs:
            given = [key for key in ("lamp", "direction", "chrome") if getattr(each, key) is not None]
            if len(given) > 1 or (not given and not (self.is_by_light_positions or (self.sample and self.chrome))):
                lines.append(each._complaint("lamp", each.lamp, "a position, or instead of it a direction, or chrome"))
        if self.ball is not None:
            lines += self._wrong_with_ball(self.ball)
        return lines

    def _wrong_with_ball(self, ball: BallSetup) -> list[str]:
        is_near = not self.camera.is_far or any(each.lamp is not None or each.distance is not None
                                                for each in self.photographs)
        lines = [*self.camera._lacks("position", '3 numbers, or "far"', self.camera.position is None),
                 *ball._lacks("centre", '3 numbers, or "outline"', ball.centre is None),
                 *ball._lacks("radius", _POSITIVE.expected, is_near and ball.radius is None)]
        card = self.scale.card
        return lines if card is None else [*lines, *card._lacks("normal", "3 numbers", card.normal is None)]


def list_files(section: Section) -> Iterator[Path]:
    """The files that a description names, itself among them."""
    for value in vars(section).values():
        for each in value if isinstance(value, tuple) else (value,):
            if isinstance(each, Section):
                yield from list_files(each)
            elif isinstance(each, Path):
                yield each


def _count(section: Section, key: str, files: Sequence[Path]) -> list[str]:
    value = getattr(section, key)
    return section._lacks(key, f"{len(files)} numbers", value is not None and len(value) != len(files))


def _dotted(where: str, key: str) -> str:
    return f"{where}.{key}" if where else key


def _abbreviate(value: object) -> str:
    plain = value.tolist() if isinstance(value, np.ndarray) else list(value) if isinstance(value, tuple) else value
    text = repr(plain)
    return text if len(text) <= _LONGEST else text[:_LONGEST] + "..."


def read(path: str | Path) -> CaptureSetup:
    """The description in a file of TOML, of light positions (`.lp`), or of a folder that has one of these.

    Of light positions alone camera and lamps are far away, the ball is at its outline, and its albedo is a guess.

    Raises DatasetError if there is no such file, several, or one that cannot be read, or is wrong.
    """
    path = Path(path)
    if path.is_dir():
        path = _only_one(path)
    if path.suffix.lower() == light_positions.SUFFIX:
        return parse({"name": path.absolute().parent.name or path.stem, "camera": {"position": "far"},
                      "ball": {"centre": "outline"}, "lamp": {"positions": path.name}, "scale": {"albedo": GUESS}},
                     path)
    return parse(_toml(path), path)


def parse(description: Description, path: str | Path) -> CaptureSetup:
    """A description that a file holds, or that was made elsewhere: errors name the path, and files are beside it.

    Raises DatasetError, whose message has all that is wrong.
    """
    path, errors = Path(path), list[str]()
    surfaces = {"ball", "sample"} & description.keys()
    if len(surfaces) != 1:
        errors.append(f"{' and '.join(sorted(surfaces))} are there, expected one of them" if surfaces
                      else "ball is missing, expected a table [ball], or [sample] of a flat sample")
    setup = _section(CaptureSetup, description, "", path, next(iter(surfaces), "ball"), errors)
    if setup is None or errors:
        raise DatasetError("; ".join(errors), path)
    if setup.is_by_light_positions:
        setup = _with_light_positions(setup)
    if not setup.photographs:
        errors.append("photograph is missing, expected one table [[photograph]] or more")
    names = {each.name for shot in setup.photographs for each in shot.files}
    if missing := [each for each in setup.leave_out if Path(each).name not in names]:
        errors.append(setup._complaint("leave_out", setup.leave_out, f"names of photographs: {missing[0]} is none"))
    errors += setup._wrong()
    if errors:
        raise DatasetError("; ".join(errors), path)
    dropped = {Path(each).name for each in setup.leave_out}
    return replace(setup, photographs=tuple(shot for shot in setup.photographs
                                            if not dropped & {each.name for each in shot.files}))


def _section(cls: type[_Section], values: Any, where: str, path: Path, surface: str,
             errors: list[str]) -> _Section | None:
    """A table as what it stands for; None where something in it is wrong, which is added to the errors."""
    if not isinstance(values, dict):
        errors.append(f"{where} is {_abbreviate(values)}, expected a table")
        return None
    known = {key.name or each.name: (each, key.kind) for each, key in _keys(cls) if key.only in ("", surface)}
    before = len(errors)
    errors += [f"{_dotted(where, str(key))} is not known, expected one of {', '.join(known)}"
               for key in values if key not in known]
    found = {each.name: _value(kind, key, values, where, path, surface, errors)
             for key, (each, kind) in known.items() if key in values or each.default is MISSING}
    if len(errors) > before:
        return None
    made = cls(where=where, path=path, **found)
    if cls is not CaptureSetup:         # whose photographs may be those of light positions
        errors += made._wrong()
    return made


def _keys(cls: type[Section]) -> list[tuple["Field[Any]", Key]]:
    """The fields of a table that stand in a description, and what they are there."""
    hints = get_type_hints(cls, include_extras=True)
    return [(each, key) for each in fields(cls) for key in getattr(hints[each.name], "__metadata__", ())]


def _value(kind: Kind | type[Section], key: str, values: Description, where: str, path: Path, surface: str,
           errors: list[str]) -> Any:
    name = _dotted(where, key)
    if kind is Shot:
        if not isinstance(values[key], list) or not values[key]:
            errors.append(f"{name} is {_abbreviate(values[key])}, expected one table [[{key}]] or more")
            return ()
        return tuple(_section(Shot, each, f"{name} {number}", path, surface, errors)
                     for number, each in enumerate(values[key], start=1))
    if isinstance(kind, type):
        return _section(kind, values.get(key, {}), name, path, surface, errors)
    try:
        if key in values:
            return kind.convert(values[key], path.parent)
        errors.append(f"{name} is missing, expected {kind.expected}")
    except (ValueError, OverflowError):
        errors.append(f"{name} is {_abbreviate(values[key])}, expected {kind.expected}")
    return None


def _with_light_positions(setup: CaptureSetup) -> CaptureSetup:
    """A description whose photographs have the directions of its `lamp.positions`, in the camera's axes.

    Where it has no photographs they are those of the file, or all pictures beside it.
    """
    file = (setup.lamp.positions or ())[0]
    found = light_positions.read(file)
    notes, shots = [*setup.notes], setup.photographs
    if shots and len(shots) != len(found.names):
        raise DatasetError(f"{len(found.names)} light positions found, expected {len(shots)}, one for each photograph",
                           file)
    if not shots:
        files, are_named = _files_of(found, file.parent)
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
