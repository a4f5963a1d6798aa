"""Photographs from files, by OpenImageIO, which Blender has: linear values, and what the file says of the camera."""

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray, SingleArray
from ..colours import conversion_from_primaries, decode_srgb
from ..errors import DatasetError

NEEDED = ("reading photographs needs OpenImageIO, which Blender has: run this in Blender, or install it (pip install "
          "OpenImageIO)")
MOST_PIXELS = 200_000_000
_FULL_FRAME = 36.0          # mm, to which a focal length "in 35 mm film" belongs
_INTEGERS = {"uint8": 8, "uint10": 10, "uint12": 12, "uint16": 16}
_MID_GREY = 0.18
_WHOLE = "combined"         # Blender's layer of the whole picture
_GREY_IN_SRGB = 0.4614      # the same
_LEAST_GAMMA = 1.5          # of values that are not linear
# by the number of EXIF's orientation
_SHOWN = {2: "mirrored", 3: "turned by 180 degrees", 4: "upside down, mirrored", 5: "turned by 90 degrees, mirrored",
          6: "turned by 90 degrees clockwise", 7: "turned by 90 degrees, mirrored",
          8: "turned by 90 degrees counter-clockwise"}
TURNED = ("EXIF says that viewers show it {}. It is read as the sensor has it, for a camera that stands still may say "
          "that of some pictures and not of others: count pixels of corners and regions without that turn")
BENT = ("sRGB, which was made linear: cameras bend such colours to please, so develop raw files linearly; where these "
        "are linear, say so by encoding = \"linear\"")


def camera_exposure(seconds: float, f_number: float = 1.0, iso: float = 100.0) -> float:
    """The exposure of a photograph.

    Examples
    --------
    >>> camera_exposure(1 / 50, 4), camera_exposure(1 / 200, 4, 400)
    (0.00125, 0.00125)
    """
    if not (seconds > 0 and f_number > 0 and iso > 0):
        raise DatasetError(f"an exposure of {seconds:g} s at f/{f_number:g} and ISO {iso:g} found, expected more than "
                           f"0")
    return seconds / f_number ** 2 * iso / 100


@dataclass(frozen=True, eq=False, kw_only=True)
class PictureInfo:
    """What a file says of its photograph; None where it does not say it."""

    size: tuple[int, int]               # height and width, pixels
    exposure: float | None = None       # by exposure time, aperture and sensitivity
    field_of_view: float | None = None  # of the width, radians, by the focal length in 35 mm film
    focal_length: float | None = None   # mm


@dataclass(frozen=True, eq=False, kw_only=True)
class PictureFile(PictureInfo):
    """A photograph from a file, as the sensor has it: EXIF's orientation is not followed, but told."""

    stored: SingleArray                 # as the file has them, top row first, of integers 1 is white: (h, w, 1 or 3)
    bend: Callable[[FloatArray], FloatArray] | None = None      # makes them linear, where they are not
    stored_step: float = 0.0            # between two values that the file can hold
    matrix: FloatArray | None = None    # to linear Rec.709, by the file's chromaticities: (3, 3)
    notes: tuple[str, ...] = ()         # without the name of the file: the same of all for which the same is so
    is_turned: bool = False             # whether EXIF says that viewers show it turned or mirrored

    def linear(self, part: Any = slice(None)) -> tuple[FloatArray, FloatArray | float]:
        """A part of the pixels, linear, (height, width, channels), and the steps between values of the file there."""
        pixels = self.stored[part].astype(float)
        if self.bend is None:
            return pixels, self.stored_step
        linear = self.bend(pixels)
        return linear, self.bend(pixels + self.stored_step) - linear

    @property
    def pixels(self) -> FloatArray:
        """All pixels, linear."""
        return self.linear()[0]


def read_picture(path: str | Path, encoding: str | None = None) -> PictureFile:
    """Read a photograph of any file that OpenImageIO reads; EXR or TIFF that a raw converter has written linearly are
    best.

    The encoding, "linear" or "srgb", is what the values are, whatever the file says. By default they are what it says;
    and where it says nothing, sRGB of 8 bits, and else linear. Of several parts the first is read, of several layers
    that of the whole picture or the first; notes say so. Raises DatasetError if it cannot be read, has neither one nor
    three channels of colour, or holds numbers that are not finite; ImportError if OpenImageIO is absent.
    """
    path, more = Path(path), list[str]()
    with _open_picture(path) as file:
        spec = file.spec()
        info = _read_info(spec, path)
        height, width = info.size
        if max(spec.width * spec.height, width * height) > MOST_PIXELS:
            raise DatasetError(f"{width} x {height} pixels, expected at most {MOST_PIXELS:,}", path)
        stored = file.read_image(0, 0, 0, spec.nchannels, "float")
        if stored is None:
            raise DatasetError(f"cannot be read: {file.geterror() or 'damaged'}", path)
        if file.seek_subimage(1, 0):
            more.append("the first of several parts is read")
    pixels = np.asarray(stored, dtype=np.float32).reshape(spec.height, spec.width, -1)
    channels = _colours(spec, path, more)
    if channels != list(range(pixels.shape[2])):
        pixels = pixels[..., channels]
    if not np.isfinite(pixels).all():
        raise DatasetError("holds numbers that are not finite", path)
    if _has_window(spec):
        pixels = _place_in_window(pixels, spec, info.size)
        more.append(f"its pixels are {spec.width} x {spec.height} beside a display window of {width} x {height}, which "
                    "is read: it is black where it has no pixels")
    turn = _SHOWN.get(int(_positive(spec, "Orientation") or 1))
    if turn is not None:
        more.append(TURNED.format(turn))
    bits = _INTEGERS.get(str(spec.format))
    step, bend = 0.0 if bits is None else 1 / (2 ** bits - 1), _bend(spec, bits, encoding)
    notes = [] if bend is None else [BENT]
    if bits == 8:
        worst = step / _MID_GREY if bend is None else float(bend(np.array(_GREY_IN_SRGB + step))) / _MID_GREY - 1
        notes.append(f"8 bits a channel, whose steps are {worst:.1%} at a grey of {_MID_GREY:g}, more in the dark")
    return PictureFile(**vars(info), stored=pixels, bend=bend, stored_step=step, matrix=_matrix(spec),
                       notes=(*notes, *more), is_turned=turn is not None)


def read_picture_info(path: str | Path) -> PictureInfo:
    """What a file says of its photograph, of which no pixel is read. Raises as `read_picture` does."""
    with _open_picture(Path(path)) as file:
        return _read_info(file.spec(), Path(path))


def _read_info(spec: Any, path: Path) -> PictureInfo:
    seconds = _positive(spec, "ExposureTime", "Exif:ExposureTime", "expTime")
    iso = _positive(spec, "Exif:PhotographicSensitivity", "Exif:ISOSpeedRatings", "isoSpeed")
    aperture, focal = _positive(spec, "FNumber", "Exif:FNumber", "aperture"), _positive(
        spec, "Exif:FocalLengthIn35mmFilm")
    return PictureInfo(
        size=_size(spec, path), exposure=None if seconds is None else camera_exposure(
            seconds, aperture or 1.0, iso or 100.0), focal_length=_positive(spec, "Exif:FocalLength"),
        field_of_view=None if focal is None else 2 * math.atan(_FULL_FRAME / (2 * focal)))


def _has_window(spec: Any) -> bool:
    """Whether a file has other pixels than those of its display window, which EXR defines."""
    return spec.getattribute("openexr:lineOrder") is not None and (
        (spec.x, spec.y, spec.width, spec.height) != (spec.full_x, spec.full_y, spec.full_width, spec.full_height))


def _size(spec: Any, path: Path) -> tuple[int, int]:
    """Height and width of the picture, pixels."""
    if not _has_window(spec):
        return spec.height, spec.width
    if not (spec.x < spec.full_x + spec.full_width and spec.full_x < spec.x + spec.width
            and spec.y < spec.full_y + spec.full_height and spec.full_y < spec.y + spec.height):
        raise DatasetError("none of its pixels is in its display window", path)
    return spec.full_height, spec.full_width


def _place_in_window(pixels: SingleArray, spec: Any, size: tuple[int, int]) -> SingleArray:
    """Pixels in their place of the display window, which is black beside them: (height, width, channels)."""
    shown = np.zeros((*size, pixels.shape[2]), np.float32)
    y, x = spec.y - spec.full_y, spec.x - spec.full_x
    part = pixels[max(-y, 0):size[0] - y, max(-x, 0):size[1] - x]
    shown[max(y, 0):max(y, 0) + part.shape[0], max(x, 0):max(x, 0) + part.shape[1]] = part
    return shown


@contextmanager
def _open_picture(path: Path) -> Iterator[Any]:
    """A file as an ImageInput of OpenImageIO. Raises as `read_picture` does."""
    try:
        import OpenImageIO
    except ImportError as error:
        raise ImportError(NEEDED) from error
    if not os.path.isfile(path):        # Path's raises an error of a name that is too long
        raise DatasetError("cannot be read: no such file", path)
    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        raise DatasetError(f"cannot be read: {OpenImageIO.geterror() or 'in no known format'}", path)
    try:
        yield file
    finally:
        file.close()


def _colours(spec: Any, path: Path, notes: list[str]) -> list[int]:
    """The channels of colour, red, green and blue, or the only one; of one layer, which is noted if there are more."""
    layers: dict[str, dict[str, int]] = {}
    for number, name in enumerate(spec.channelnames):
        layer, _, channel = str(name).lower().rpartition(".")
        layers.setdefault(layer, {})[channel] = number
    for wanted in (("r", "g", "b"), ("red", "green", "blue"), ("y",)):
        found = [layer for layer, channels in layers.items() if channels.keys() >= {*wanted}]
        if found:
            best = min(found, key=lambda layer: (layer != "", layer.split(".")[-1] != _WHOLE))
            if len(found) > 1:
                notes.append(f"the layer {best or 'without a name'} is read, of "
                             f"{', '.join(each or '-' for each in found[:4])}")
            return [layers[best][name] for name in wanted]
    if len(spec.channelnames) == 1:
        return [0]
    raise DatasetError(f"channels {', '.join(map(str, spec.channelnames[:6]))} found, expected R, G and B, or a single "
                       f"one", path)


def _bend(spec: Any, bits: int | None, encoding: str | None) -> Callable[[FloatArray], FloatArray] | None:
    """What makes the values of a file linear; None where they are. OpenImageIO takes PNG and JPEG for sRGB where these
    say nothing, as their specifications do. A gamma near that of sRGB is how older files say it."""
    if encoding is not None:
        return decode_srgb if encoding == "srgb" else None
    said = str(spec.get_string_attribute("oiio:ColorSpace")).lower()
    profile = str(spec.get_string_attribute("ICCProfile:profile_description")).lower()
    if said.startswith(("lin", "scene_linear", "raw", "data")) or "linear" in profile:
        return None
    if said == "srgb" and (spec.getattribute("tiff:PhotometricInterpretation") is not None
                           and spec.getattribute("Exif:ColorSpace") != 1):
        said = ""           # OpenImageIO takes a TIFF for sRGB because it has EXIF, which says nothing of colours
    bent = "srgb" in said or "srgb" in profile or (
        said.startswith("g") and (_positive(spec, "oiio:Gamma") or 1.0) > _LEAST_GAMMA)
    return decode_srgb if bent or bits == 8 else None


def _positive(spec: Any, *names: str) -> float | None:
    """The first of some attributes that is there, and above 0."""
    for name in names:
        value = spec.getattribute(name)
        if isinstance(value, int | float) and math.isfinite(value) and value > 0:
            return float(value)
    return None


def _matrix(spec: Any) -> FloatArray | None:
    numbers = spec.getattribute("chromaticities")
    if numbers is None or len(numbers) != 8:
        return None
    places = [(float(numbers[k]), float(numbers[k + 1])) for k in (0, 2, 4, 6)]
    return conversion_from_primaries(places[:3], places[3])
