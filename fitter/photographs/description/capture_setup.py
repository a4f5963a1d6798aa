"""What stands in the description of photographs: where camera, sample and lamps were, and which file is which.

A file of it is TOML, which `docs/manual/measure-your-own.md` shows. This is its table: a class for each section, with a
line for each key that has its type, what values of it are (a `Kind`), whether it is of balls or of flat samples alone,
and what it means. Lengths are metres, angles degrees, paths relative to the file, places in a picture pixels from its
left and its top. Places are a flat sample's own: its middle is at 0, x runs along its width, y along its height, and z
toward the camera. Light positions (`light_positions`) are directions in the camera's axes; with a camera that is far
they say all there is to say.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...errors import DatasetError, printable

LEAST_VALUE, _LARGEST = 1e-9, 1e9  # of numbers: their squares and quotients are within double precision by far
GUESS = 0.5                 # of an albedo, where there is nothing better
MOST_MATERIALS = 4          # every choice of them is tried at each texel
MOST_TEXELS = 4096          # of maps, along both axes
ENCODINGS = "linear", "srgb"
SCALES = "intensity", "albedo", "card", "ball"
_LONGEST = 80               # characters of a value in a message
_DIRECTION_LENGTH = 1e-12               # least length of a vector that has a direction

Description = dict[str, Any]
"""What a file of TOML holds, by key."""


class Kind(NamedTuple):
    """What values of a key are: in words, and what makes them of what TOML has, beside files of a folder; it raises
    ValueError where it cannot."""

    expected: str
    convert: Callable[[Any, Path], Any]


def _numbers(value: Any, *shape: int, least: float = -_LARGEST, most: float = _LARGEST) -> Any:
    """A number, or an array of this shape, in which 0 is any number of numbers, or three rows or more."""
    if shape:
        if not isinstance(value, list | tuple) or len(value) < (shape[0] or 2 * len(shape) - 1) or len(value) != (
                shape[0] or len(value)):
            raise ValueError
        return np.array([_numbers(each, *shape[1:], least=least, most=most) for each in value])
    if not isinstance(value, int | float) or isinstance(value, bool) or not least <= value <= most:
        raise ValueError
    return float(value)


def _texts(value: Any) -> tuple[str, ...]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple) or not names or not all(isinstance(each, str) for each in names):
        raise ValueError
    return tuple(names)


def _files(value: Any, folder: Path) -> tuple[Path, ...]:
    return tuple(folder / each for each in _texts(value))


def _text(value: Any, *words: str) -> str:
    """One of some words, or any text where there are none."""
    if not isinstance(value, str) or (words and value not in words):
        raise ValueError
    return value


def _unit_vector(value: Any) -> FloatArray:
    vector = _numbers(value, 3)
    if not np.linalg.norm(vector) > _DIRECTION_LENGTH:
        raise ValueError
    return np.asarray(vector / np.linalg.norm(vector))


def _place_or(word: str) -> Kind:
    return Kind(f'3 numbers, or "{word}"', lambda value, _: word if value == word else _numbers(value, 3))


_BALL_KEY, _SAMPLE_KEY = "ball", "sample"   # whose descriptions alone have a key
_TEXT = Kind("a text", lambda value, _: printable(_text(value)))
_POSITIVE = Kind(f"a number of {LEAST_VALUE:g} to {_LARGEST:g}", lambda value, _: _numbers(value, least=LEAST_VALUE))
_PLACE = Kind("3 numbers", lambda value, _: _numbers(value, 3))
_DIRECTION = Kind("a vector toward it, 3 numbers", lambda value, _: _unit_vector(value))
_REGION = Kind("4 numbers", lambda value, _: _numbers(value, 4))
_MATRIX = Kind("three rows of three numbers", lambda value, _: _numbers(value, 3, 3))
_CORNERS = Kind("four places of two numbers, pixels from the left and the top", lambda value, _: _numbers(value, 4, 2))
_OUTLINE = Kind("three places of two numbers or more, pixels from the left and the top",
                lambda value, _: _numbers(value, 0, 2))
_VALUES = Kind("a number above 0, or one for each channel", lambda value, _: np.array(
    _numbers(value, *[0] * isinstance(value, list | tuple), least=LEAST_VALUE)))
_EXPOSURES = Kind(f"numbers of {LEAST_VALUE:g} to {_LARGEST:g}", lambda value, _: _numbers(value, 0, least=LEAST_VALUE))
_BRIGHTNESS = Kind('"found", or a number above 0 for each photograph',
                   lambda value, _: value if value == "found" else _numbers(value, 0, least=LEAST_VALUE))
_ALBEDO = Kind("more than 0 and at most 1, of what reflects no more than it gets",
               lambda value, _: _numbers(value, least=LEAST_VALUE, most=1))
_ALBEDOS = Kind(f"{_ALBEDO.expected}, or one for each channel", lambda value, _: np.array(
    _numbers(value, *[0] * isinstance(value, list | tuple), least=LEAST_VALUE, most=1)))
_ENCODING = Kind(" or ".join(ENCODINGS), lambda value, _: _text(value, *ENCODINGS))
_FILES = Kind("the name of a file, or a list of them", _files)
_MATERIALS = Kind(f"files, or a number of 1 to {MOST_MATERIALS}", lambda value, folder: int(
    _numbers(value, least=1, most=MOST_MATERIALS)) if isinstance(value, int) else _files(value, folder))
_PHOTOGRAPH_NAMES = Kind("names of photographs", lambda value, _: _texts(value))

Positive = Annotated[float | None, _POSITIVE]
Place = Annotated[FloatArray | None, _PLACE]
Files = Annotated[tuple[Path, ...] | None, _FILES]


@dataclass(frozen=True, kw_only=True, eq=False)
class Section:
    """A table of a description: a key that is not there is None, or has its default."""

    where: str = ""
    path: Path = Path()

    def error(self, key: str, expected: str) -> DatasetError:
        """What to raise where the value of a key is not as expected."""
        return DatasetError(self.complaint(key, expected), self.path)

    def complaint(self, key: str, expected: str) -> str:
        """The same in words."""
        return complaint(self.where, key, getattr(self, key), expected)

    def contradictions(self) -> Iterator[str]:
        """What is wrong with values together, each of which is of its kind."""
        yield from ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Lit(Section):
    """What is in a picture under one lamp."""

    lamp: Place = None              # (3,)
    direction: Annotated[FloatArray | None, _DIRECTION] = None  # or, of one far away, the unit vector toward it
    exposures: Annotated[FloatArray | None, _EXPOSURES] = None  # of each file; by default those of EXIF

    def _check_count(self, files: tuple[Path, ...]) -> Iterator[str]:
        if self.exposures is not None and len(self.exposures) != len(files):
            yield self.complaint("exposures", f"{len(files)} numbers")


@dataclass(frozen=True, kw_only=True, eq=False)
class Known(Lit):
    """A photograph of a card, or a ball, of known albedo."""

    file: Annotated[tuple[Path, ...], _FILES]
    albedo: Annotated[FloatArray, _ALBEDOS]     # of all channels, or of each
    normal: Place = None            # where a card faces; of one in a flat sample's plane [0, 0, 1]
    region: Annotated[FloatArray | None, _REGION] = None    # that a card fills: left, top, right and bottom

    def contradictions(self) -> Iterator[str]:
        """Of lamp and direction it has one."""
        if (self.lamp is None) == (self.direction is None):
            yield self.complaint("lamp", "a position, or instead of it a direction")
        yield from self._check_count(self.file)


@dataclass(frozen=True, kw_only=True, eq=False)
class Shot(Lit):
    """A photograph under one lamp: exposures of it."""

    files: Annotated[tuple[Path, ...], _FILES]
    chrome: Files = None            # picture of a chrome ball under the same lamp, in the place of `lamp`, `direction`
    distance: Positive = None       # of a lamp from the middle of what is measured

    @property
    def name(self) -> str:
        """That of its first file, as terminals can show it."""
        return printable(self.files[0].name)

    def contradictions(self) -> Iterator[str]:
        """There are as many exposures as files."""
        yield from self._check_count(self.files)


@dataclass(frozen=True, kw_only=True, eq=False)
class CameraSetup(Section):
    """Where the camera stands, and how it sees."""

    # (3,), or where nobody knows how far it is: straight above a sample. By default where a sample's corners say
    position: Annotated[FloatArray | Literal["far"] | None, _place_or("far")] = None
    look_at: Annotated[Place, _BALL_KEY] = None         # by default the ball's centre, or where that is found 0
    direction: Annotated[Place, _BALL_KEY] = None   # of one that is far: from the ball toward it, by default [0, 0, 1]
    up: Annotated[Place, _BALL_KEY] = None              # by default [0, 0, 1], and of one that is far [0, 1, 0]
    field_of_view: Positive = None                  # of the width; or these two; or what EXIF says
    focal_length: Positive = None                   # mm
    sensor_width: Positive = None                   # mm
    matrix: Annotated[FloatArray | None, _MATRIX] = None    # to linear Rec.709; by default by the files' chromaticities
    encoding: Annotated[str | None, _ENCODING] = None   # of pixels, whatever the files say

    @property
    def is_far(self) -> bool:
        """Whether its distance is unknown."""
        return isinstance(self.position, str)

    def contradictions(self) -> Iterator[str]:
        """What it looks at, or a direction, whether it is near or far."""
        if self.is_far and self.look_at is not None:
            yield self.complaint("look_at", "not that, but direction, toward the camera, for it is far")
        if not self.is_far and self.direction is not None:
            yield self.complaint("direction", 'that of a camera whose position is "far"')


@dataclass(frozen=True, kw_only=True, eq=False)
class BallSetup(Section):
    """Where a ball is; as `chrome`, one that shows where lamps are, by default in the place of what is measured."""

    centre: Annotated[FloatArray | Literal["outline"] | None, _place_or("outline")] = None  # or found in the pictures
    radius: Positive = None     # it does not matter of one that is photographed from afar under lamps far away
    # white where pixels count; of a chrome ball, where it is, which says its centre: in photographs of a flat sample it
    # lies in its plane, if its radius does not say otherwise
    mask: Files = None

    @property
    def place(self) -> FloatArray | None:
        """Its centre where that is given, (3,)."""
        return None if isinstance(self.centre, str) else self.centre


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleSetup(Section):
    """A flat sample."""

    width: Annotated[float, _POSITIVE]
    height: Annotated[float, _POSITIVE]
    corners: Annotated[FloatArray | None, _CORNERS] = None  # bottom left, bottom right, top right, top left of the maps
    mask: Files = None                                      # white where it is: a coin or a leaf is no rectangle
    outline: Annotated[FloatArray | None, _OUTLINE] = None  # or the outline of that, (n, 2)


@dataclass(frozen=True, kw_only=True, eq=False)
class LampSetup(Section):
    """What all lamps share."""

    radius: Annotated[float, _POSITIVE, _BALL_KEY] = 0.0    # of lamps that are balls
    positions: Files = None         # of light positions, in the place of those of the photographs, or of all of them
    distance: Positive = None       # of lamps whose directions `positions` or a chrome ball say, from what is measured
    dark: Files = None              # a photograph with the lamp off
    flat: Files = None              # and one of an evenly bright surface
    ball: Annotated[Place, _SAMPLE_KEY] = None       # where a chrome ball stood, whose highlights say the directions
    # of the lamps beside each other; or it is found by the sample itself, in each colour
    brightness: Annotated[FloatArray | Literal["found"] | None, _BRIGHTNESS, _SAMPLE_KEY] = None
    exposures = None                # of `dark` and `flat`: those of EXIF

    def contradictions(self) -> Iterator[str]:
        """A chrome ball stood nearer than the lamps."""
        if self.ball is not None and self.distance is None:
            yield self.complaint("distance", _POSITIVE.expected)
        elif self.ball is not None and self.distance is not None and not np.linalg.norm(self.ball) < self.distance:
            yield self.complaint("ball", "a place nearer to the sample's middle than the lamps, which are "
                                         f"{self.distance:g} m away")


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaleSetup(Section):
    """How bright the lamps are: one of four."""

    # W/sr in units of the pictures, in all channels or in each; of lamps far away as if these were 1 m away
    intensity: Annotated[FloatArray | None, _VALUES] = None
    albedo: Annotated[float | None, _ALBEDO] = None     # of what is measured: a guess
    card: Annotated[Known | None, Known] = None     # where the ball is, or in a sample's plane
    ball: Annotated[Known | None, Known, _BALL_KEY] = None  # a matte one in its place

    @property
    def ways(self) -> list[str]:
        """The names of what is given."""
        return [each for each in SCALES if getattr(self, each) is not None]


@dataclass(frozen=True, kw_only=True, eq=False)
class CaptureSetup(Section):
    """How photographs of a ball, or of a flat sample, were taken. `path` is what errors name."""

    name: Annotated[str | None, _TEXT] = None
    camera: Annotated[CameraSetup, CameraSetup] = field(default_factory=CameraSetup)
    ball: Annotated[BallSetup | None, BallSetup, _BALL_KEY] = None
    sample: Annotated[SampleSetup | None, SampleSetup, _SAMPLE_KEY] = None
    chrome: Annotated[BallSetup | None, BallSetup] = None   # in pictures of its own, or those of the sample themselves
    lamp: Annotated[LampSetup, LampSetup] = field(default_factory=LampSetup)
    scale: Annotated[ScaleSetup, ScaleSetup] = field(default_factory=ScaleSetup)
    photographs: Annotated[tuple[Shot, ...], Shot] = ()     # [[photograph]]
    # what a sample is made of: saved fits, or measurements; or how many these are; else that is found
    materials: Annotated[int | tuple[Path, ...] | None, _MATERIALS, _SAMPLE_KEY] = None
    leave_out: Annotated[tuple[str, ...], _PHOTOGRAPH_NAMES, _SAMPLE_KEY] = ()  # files of photographs that do not count
    texels: Annotated[Positive, _SAMPLE_KEY] = None  # of the maps, along the width; by default as many as it has pixels
    notes: tuple[str, ...] = ()                     # what is to be said of how the photographs were found

    @property
    def title(self) -> str:
        """Its name, by default that of the file."""
        return self.path.stem if self.name is None else self.name

    def need_ball(self) -> BallSetup:
        """The ball. DatasetError of a flat sample."""
        if self.ball is None:
            raise DatasetError("a flat sample is described, expected a table [ball]", self.path)
        return self.ball

    def need_sample(self) -> SampleSetup:
        """The flat sample. DatasetError of a ball."""
        if self.sample is None:
            raise DatasetError("a ball is described, expected a table [sample]", self.path)
        return self.sample

    def contradictions(self) -> Iterator[str]:
        """One scale, a lamp for each photograph, and what a ball needs."""
        if len(self.scale.ways) != 1:
            known = SCALES if self.sample is None else SCALES[:3]
            yield f"scale has {', '.join(self.scale.ways) or 'nothing'}, expected one of {', '.join(known)}"
        for each in self.photographs:
            given = [key for key in ("lamp", "direction", "chrome") if getattr(each, key) is not None]
            if len(given) > 1 or (not given and not (self.lamp.positions or (self.sample and self.chrome))):
                yield each.complaint("lamp", "a position, or instead of it a direction, or chrome")
        if self.ball is None:
            return
        is_near = not self.camera.is_far or any(each.lamp is not None or each.distance is not None
                                                for each in self.photographs)
        for section, key, expected in ((self.camera, "position", '3 numbers, or "far"'),
                                       (self.ball, "centre", '3 numbers, or "outline"'),
                                       (self.ball if is_near else None, "radius", _POSITIVE.expected),
                                       (self.scale.card, "normal", _PLACE.expected)):
            if section is not None and getattr(section, key) is None:
                yield section.complaint(key, expected)


def list_files(section: Section) -> Iterator[Path]:
    """The files that a description names, itself among them."""
    for value in vars(section).values():
        for each in value if isinstance(value, tuple) else (value,):
            if isinstance(each, Section):
                yield from list_files(each)
            elif isinstance(each, Path):
                yield each


def complaint(where: str, key: str, value: object, expected: str) -> str:
    """What to say of a value that is not as expected; None is missing."""
    said = "is missing" if value is None else f"is {abbreviate(value)}"
    return f"{key_path(where, key)} {said}, expected {expected}"


def key_path(where: str, key: str) -> str:
    """A key with the table in which it is."""
    return f"{where}.{key}" if where else key


def abbreviate(value: object) -> str:
    """A value as a message has it."""
    plain = value.tolist() if isinstance(value, np.ndarray) else list(value) if isinstance(value, tuple) else value
    text = repr(plain)
    return text if len(text) <= _LONGEST else text[:_LONGEST] + "..."
