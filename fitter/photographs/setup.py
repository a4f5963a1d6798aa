"""The description of photographs in a file: where camera, ball and lamps were, and which file is which.

It is in TOML. Lengths are metres, angles degrees, paths relative to the file. Keys in brackets may be left out ::

    [name] = "red snooker ball"

    [camera]
    position = [0, -1.5, 0.2]
    [look_at] = [0, 0, 0]           # by default the ball's centre, or where that is the outline's, the origin
    [up] = [0, 0, 1]
    [field_of_view] = 12            # of the width; or focal_length and sensor_width in mm; or of the files' EXIF
    [matrix] = [[...], [...], [...]]    # from the camera's colours to linear Rec.709; or the files' chromaticities
    [encoding] = "linear"           # or "srgb", whatever the files say

    [ball]
    centre = [0, 0, 0]              # or "outline": it is found in the photographs
    radius = 0.026
    [mask] = "mask.png"             # white where pixels count

    [lamp]
    [radius] = 0.02                 # of one that is a ball
    [dark] = "dark.exr"             # a photograph with the lamp off
    [flat] = "flat.exr"             # and one of an evenly bright surface

    [scale]                         # one of these:
    intensity = 3.2                 # the lamp's, W/sr in units of the pictures; or three numbers
    albedo = 0.5                    # of the ball: a guess
    card = {file = "card.exr", albedo = 0.18, normal = [0, -1, 0], lamp = [0, -1, 0.5], region = [200, 180, 260, 240]}
    ball = {file = "white.exr", albedo = 0.9, lamp = [0, -1, 0.5]}

    [[photograph]]
    files = ["a1.exr", "a2.exr"]    # exposures of one lamp
    [exposures] = [0.01, 0.08]      # by default those of EXIF
    lamp = [0.3, -1.1, 0.4]         # or chrome = "a_chrome.exr" and distance = 1.2, from the ball's centre

A card stands where the ball does, and `region` is the part of its picture that it fills: left, top, right and bottom,
pixels. A file among dark, flat, card, ball and chrome may be a list of exposures as well, with `exposures` beside it
where it has a table of its own.
"""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import progress
from ..arrays import BoolArray, FloatArray
from ..errors import DatasetError
from ..files import read_bytes
from ..samples import Samples
from . import camera as cameras
from .ball import BallPhotograph
from .chrome import lamp_of_highlight
from .light import Exposure, Light, flattened, merged, without
from .outline import brightest, find_ball
from .picture_files import ENCODINGS, Picture, read_picture
from .samples import gathered, in_place
from .scale import intensity_of_ball, intensity_of_card, scaled
from .table import Table, is_number

LARGEST = 1 << 20           # bytes of the file
_SCALES = ("intensity", "albedo", "card", "ball")
_FILES = "mask", "dark", "flat", "file", "files"
_MASKED = 0.5               # of white


Description = dict[str, Any]
"""What a file holds, by key."""


class Measured(NamedTuple):
    """What photographs measure."""

    samples: Samples
    photographs: list[BallPhotograph]
    """The ball is where its outline is, and the lamp has the intensity that belongs to the samples."""


class Resolved(NamedTuple):
    """A description in which places are numbers."""

    description: Description
    size: tuple[int, int]
    """Height and width of the photographs, pixels."""


class _Stage(NamedTuple):
    """What all photographs of a description share: metres and radians."""

    position: FloatArray
    orientation: FloatArray
    field_of_view: float
    rays: FloatArray
    centre: FloatArray
    radius: float
    mask: BoolArray
    notes: tuple[str, ...]


@dataclass
class _Reader:
    """What all pictures of a description share.

    Attributes
    ----------
    encoding, matrix : str or None, (3, 3) or None
        Of the description.
    dark, flat : Light, or None
    pictures : list of Picture
        Those that were read.
    """

    encoding: str | None
    matrix: FloatArray | None
    dark: Light | None = None
    flat: Light | None = None
    pictures: list[Picture] = field(default_factory=list)

    def light(self, table: Table, key: str) -> Light:
        """The light of the files of a key, in the colours of the camera."""
        paths = table.files(key)
        pictures = [read_picture(path, self.encoding) for path in paths]
        self.pictures += pictures
        given = table.numbers("exposures", len(paths)) if table.has("exposures") else None
        if given is not None and not (given > 0).all():
            raise table.error("exposures", "numbers above 0")
        if given is None and len(paths) > 1 and any(each.exposure is None for each in pictures):
            raise table.error("exposures", "one for each file, for these do not say theirs")
        exposures = [each.exposure or 1.0 for each in pictures] if given is None else given.tolist()
        try:
            return merged([Exposure(each.pixels, exposure, each.step)
                           for each, exposure in zip(pictures, exposures, strict=True)])
        except DatasetError as error:
            raise DatasetError(str(error), paths[0]) from error

    def of_lamp(self, table: Table, key: str) -> Light:
        """The light of the lamp alone, without vignetting, in linear Rec.709 where the camera's colours are known."""
        light = self.light(table, key)
        try:
            if self.dark is not None:
                light = without(light, self.dark)
            if self.flat is not None:
                light = flattened(light, self.flat)
        except DatasetError as error:
            raise DatasetError(str(error), table.files(key)[0]) from error
        matrix = self.matrix if self.matrix is not None else self.pictures[-1].matrix
        if matrix is None or light.radiance.shape[2] != 3:
            return light
        return Light(light.radiance @ matrix.T, np.sqrt(light.noise ** 2 @ (matrix ** 2).T), light.known)


def measure(path: str | Path) -> Samples:
    """The samples that the photographs of a description make.

    Raises
    ------
    DatasetError
        If the description or a file is wrong; the message names file and key.
    ImportError
        If OpenImageIO is absent.
    """
    return measured(read(path), path).samples


def measured(description: Description, path: str | Path) -> Measured:
    """The same of a description that has been read, or made elsewhere; errors name the path, and files are beside it.

    Raises as `measure` does.
    """
    table, path = _checked(description, path), Path(path)
    photographs, notes = _photographs(table, path)
    name = table.text("name", path.stem)
    photographs = in_place(photographs, name)
    samples = gathered(photographs, name, str(path))
    samples = replace(samples, notes=(*samples.notes, *notes))
    scale = table.table("scale")
    if not scale.has("albedo"):
        return Measured(samples, photographs)
    guessed = scaled(samples, scale.needed("albedo"))
    # what is a guess of the samples' scale is one of the lamp's intensity
    share = float(samples.values.sum() / guessed.values.sum())
    return Measured(guessed, [replace(each, intensity=each.intensity * share) for each in photographs])


def photographed(description: Description, path: str | Path) -> list[BallPhotograph]:
    """The photographs of a description, as they are: nothing is checked of what they show. Raises as `measure` does."""
    return _photographs(_checked(description, path), Path(path))[0]


def resolved(description: Description, path: str | Path) -> Resolved:
    """A description with numbers in the place of what its pictures say, as `measured` finds them, and absolute paths.

    The numbers are the camera's field of view, what it looks at, the ball's centre and the lamps. Raises as `measure`
    does.
    """
    table, path = _checked(description, path), Path(path)
    reader = _reader(table.table("camera"), table.table("lamp"))
    stage = _stage(table, _lights(table, reader, path), reader, path)
    camera = {key: value for key, value in description["camera"].items() if key not in ("focal_length", "sensor_width")}
    camera |= {"look_at": (stage.position - stage.orientation[:, 2]).tolist(), "up": stage.orientation[:, 1].tolist(),
               "field_of_view": float(np.degrees(stage.field_of_view))}
    shots = [{key: value for key, value in given.items() if key not in ("chrome", "distance")}
             | {"lamp": _lamp(each, reader, stage).tolist()}
             for given, each in zip(description["photograph"], table.tables("photograph"), strict=True)]
    places = {**description, "name": table.text("name", path.stem), "camera": camera, "photograph": shots,
             "ball": {**description["ball"], "centre": stage.centre.tolist()}}
    height, width = stage.mask.shape
    return Resolved(_with_paths(places, path.parent), (height, width))


def _with_paths(value: Any, folder: Path) -> Any:
    """A description, or a part of it, with absolute paths in the place of those that are relative to a folder."""
    if isinstance(value, list):
        return [_with_paths(each, folder) for each in value]
    if not isinstance(value, dict):
        return value

    def absolute(name: Any) -> Any:
        return [absolute(each) for each in name] if isinstance(name, list) else str((folder / name).absolute())

    return {key: absolute(each) if key in _FILES else _with_paths(each, folder) for key, each in value.items()}


def read(path: str | Path) -> Description:
    """The description that a file holds. Raises DatasetError if it is not TOML."""
    try:
        return tomllib.loads(read_bytes(path, LARGEST).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DatasetError(f"not TOML: {error}", path) from error


def _checked(description: Description, path: str | Path) -> Table:
    """The description as a table, if it has no other keys than it may have."""
    path = Path(path)
    table = Table(description, "", path).only("name", "camera", "ball", "lamp", "scale", "photograph")
    table.table("camera").only("position", "look_at", "up", "field_of_view", "focal_length", "sensor_width", "matrix",
                               "encoding")
    table.table("ball").only("centre", "radius", "mask")
    table.table("lamp").only("radius", "dark", "flat")
    scale = table.table("scale").only(*_SCALES)
    if sum(map(scale.has, _SCALES)) != 1:
        raise DatasetError(f"scale has {', '.join(filter(scale.has, _SCALES)) or 'nothing'}, expected one of "
                           f"{', '.join(_SCALES)}", path)
    for each in table.tables("photograph"):
        each.only("files", "exposures", "lamp", "chrome", "distance")
    return table


def _lights(table: Table, reader: _Reader, path: Path) -> list[Light]:
    """What the photographs show, each of one size."""
    lights, tables = [], table.tables("photograph")
    for number, each in enumerate(tables):
        progress.report(number / len(tables), f"Reading {_name(each)}")
        lights.append(reader.of_lamp(each, "files"))
    sizes = {light.radiance.shape for light in lights}
    if len(sizes) > 1:
        raise DatasetError("photographs of several sizes found: " + ", ".join(
            f"{_name(each)} {light.radiance.shape[1]} x {light.radiance.shape[0]}" for each, light in zip(
                tables, lights, strict=True)), path)
    return lights


def _name(photograph: Table) -> str:
    return photograph.files("files")[0].name


def _stage(table: Table, lights: Sequence[Light], reader: _Reader, path: Path) -> _Stage:
    ball, camera = table.table("ball"), table.table("camera")
    radius, (height, width, _) = ball.needed("radius"), lights[0].radiance.shape
    position = camera.numbers("position", 3)
    by_outline = ball.value("centre") == "outline"
    centre = np.zeros(3) if by_outline else ball.numbers("centre", 3)
    look_at = camera.numbers("look_at", 3, centre.tolist())
    orientation = cameras.looking(position, look_at, camera.numbers("up", 3, (0, 0, 1)))
    angle = _field_of_view(camera, reader.pictures, path)
    rays = cameras.rays(height, width, angle, orientation)
    mask = _mask(ball, (height, width))
    notes: tuple[str, ...] = tuple(dict.fromkeys(note for each in reader.pictures for note in each.notes))
    if by_outline:
        outline = find_ball(brightest([light.radiance * mask[..., None] for light in lights]), rays, str(path))
        centre = outline.centre(position, radius)
        notes = (*notes, "The ball's centre by its outline: {:.4g}, {:.4g}, {:.4g} m".format(*centre))
    return _Stage(position, orientation, angle, rays, centre, radius, mask, notes)


def _lamp(photograph: Table, reader: _Reader, stage: _Stage) -> FloatArray:
    """Where the lamp of a photograph is: (3,)."""
    if photograph.has("lamp") == photograph.has("chrome"):
        raise photograph.error("lamp", "a position, or instead of it chrome and distance")
    if photograph.has("lamp"):
        return photograph.numbers("lamp", 3)
    shown = reader.of_lamp(photograph, "chrome").radiance
    name = photograph.files("chrome")[0].name
    return lamp_of_highlight(shown, stage.rays, stage.position, stage.centre, stage.radius, name).at(
        photograph.needed("distance"))


def _photographs(table: Table, path: Path) -> tuple[list[BallPhotograph], tuple[str, ...]]:
    """The photographs of a description, and notes of how they were read."""
    reader = _reader(table.table("camera"), table.table("lamp"))
    lights, tables = _lights(table, reader, path), table.tables("photograph")
    stage = _stage(table, lights, reader, path)

    def photograph(light: Light, lamp: FloatArray, intensity: FloatArray, name: str) -> BallPhotograph:
        return BallPhotograph(light.radiance, stage.rays, stage.position, stage.centre, stage.radius, lamp, intensity,
                              table.table("lamp").number("radius", 0.0) or 0.0, light.noise, stage.mask & light.known,
                              name)

    lamps = [_lamp(each, reader, stage) for each in tables]
    intensity, note = _intensity(table.table("scale"), reader, lights[0].radiance.shape[2], stage.centre, photograph)
    photographs = [photograph(light, lamp, intensity, _name(each))
             for light, lamp, each in zip(lights, lamps, tables, strict=True)]
    return photographs, (*stage.notes, *note)


def _reader(camera: Table, lamp: Table) -> _Reader:
    encoding = camera.value("encoding")
    if encoding not in (None, *ENCODINGS):
        raise camera.error("encoding", " or ".join(ENCODINGS))
    matrix = None
    if camera.has("matrix"):
        rows = camera.value("matrix")
        if not isinstance(rows, list) or [len(row) for row in rows if isinstance(row, list)] != [3, 3, 3] or not all(
                is_number(value) for row in rows for value in row):
            raise camera.error("matrix", "three rows of three numbers")
        matrix = np.array(rows, dtype=float)
    reader = _Reader(encoding, matrix)
    dark = reader.light(lamp, "dark") if lamp.has("dark") else None
    flat = reader.light(lamp, "flat") if lamp.has("flat") else None
    reader.dark, reader.flat = dark, flat
    return reader


def _field_of_view(camera: Table, pictures: Sequence[Picture], path: Path) -> float:
    if camera.has("field_of_view"):
        return float(np.radians(camera.needed("field_of_view")))
    focal = camera.number("focal_length", next((each.focal_length for each in pictures if each.focal_length), None))
    width = camera.number("sensor_width")
    if focal is not None and width is not None:
        return cameras.field_of_view(focal, width)
    said = next((each.field_of_view for each in pictures if each.field_of_view), None)
    if said is None:
        raise DatasetError("camera.field_of_view is missing, expected that, or focal_length and sensor_width: the "
                           "photographs do not say them", path)
    return said


def _mask(ball: Table, size: tuple[int, int]) -> BoolArray:
    if not ball.has("mask"):
        return np.ones(size, bool)
    path, = ball.files("mask")[:1]
    mask = read_picture(path).pixels.mean(axis=2) > _MASKED
    if mask.shape != size:
        raise DatasetError(f"{mask.shape[1]} x {mask.shape[0]} pixels found, expected {size[1]} x {size[0]} as the "
                           f"photographs have", path)
    return mask


def _intensity(scale: Table, reader: _Reader, channels: int, centre: FloatArray,
               photograph: Callable[[Light, FloatArray, FloatArray, str], BallPhotograph],
               ) -> tuple[FloatArray, tuple[str, ...]]:
    """The lamp's intensity, and a note of where it is from."""
    ones = np.ones(channels)
    if scale.has("albedo"):
        return ones, ("Colours are those that the lamp and the camera give",)
    if scale.has("intensity"):
        value = scale.value("intensity")
        given = [value] * channels if is_number(value) else value
        if not isinstance(given, list) or len(given) != channels or not all(is_number(each) and each > 0
                                                                            for each in given):
            raise scale.error("intensity", f"a number above 0, or {channels}")
        return np.array(given, dtype=float), ("The lamp's intensity as it was given",)
    if scale.has("ball"):
        known = scale.table("ball").only("file", "exposures", "albedo", "lamp")
        white = photograph(reader.of_lamp(known, "file"), known.numbers("lamp", 3), ones,
                           known.files("file")[0].name)
        return intensity_of_ball(white, _albedo(known, channels)), ("Scale and colour by a ball of known albedo",)
    card = scale.table("card").only("file", "exposures", "albedo", "lamp", "normal", "region")
    light = reader.of_lamp(card, "file")
    left, top, right, bottom = card.numbers("region", 4).astype(int)
    height, width = light.known.shape
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        raise card.error("region", f"left, top, right and bottom within {width} x {height} pixels")
    part = light.radiance[top:bottom, left:right][light.known[top:bottom, left:right]]
    name = card.files("file")[0]
    if not len(part):
        raise DatasetError("the card is saturated", name)
    try:
        return intensity_of_card(part, centre, card.numbers("normal", 3), card.numbers("lamp", 3),
                                 _albedo(card, channels)), ("Scale and colour by a card of known albedo",)
    except DatasetError as error:
        raise DatasetError(str(error), name) from error


def _albedo(table: Table, channels: int) -> FloatArray:
    if isinstance(table.value("albedo"), list):
        return table.numbers("albedo", channels)
    return np.full(channels, table.needed("albedo"))
