"""The pictures of a description as light: exposures merged by their noise, the dark room taken away, in known colours.

A pixel that is p of white has the variance READ^2 + SHOT p + step^2 / 12: of the electronics, of the photons, and of
rounding to steps. Exposures are averaged with weights of the inverse variance of what they say of the radiance
(M. Granados, B. Ajdin, M. Wand, C. Theobalt, H.-P. Seidel, H. P. A. Lensch: Optimal HDR Reconstruction with Linear
Digital Cameras, CVPR 2010).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import BoolArray, FloatArray, RealArray
from ..errors import DatasetError, printable
from ..imaging.picture_files import PictureFile, PictureInfo, read_picture, read_picture_info
from .description.capture_setup import BallSetup, CaptureSetup, LampSetup, Lit, SampleSetup, Shot

SATURATED = 0.95            # of white: pixels above it are left out
READ, SHOT = 5e-4, 5e-5     # noise of a camera at ISO 100: 10 of 20,000 electrons, and the root of their number
_ROUNDS = 2                 # of the mean, whose weights depend on it
_CENTRE = 0.04              # of a picture's sides: the part whose brightness others are compared with
_MASKED = 0.5               # of white
_BAND = 1 << 20             # pixels that are merged at a time

Part = tuple[slice, slice]
"""The rows and columns of pictures that are kept."""
WHOLE: Part = (slice(None), slice(None))


class Exposure(NamedTuple):
    """One photograph of several that differ in exposure."""

    pixels: FloatArray          # linear, 1 for white, where the camera is saturated: (height, width, channels)
    step: FloatArray | float = 0.0      # of 1, between two values that the file can hold, of each or of all
    exposure: float = 1.0       # time times sensitivity, in any unit: `picture_files.camera_exposure`


class Light(NamedTuple):
    """The light that reached the camera: radiance, its standard deviation, both (h, w, channels), and where it is known
    (h, w)."""

    radiance: RealArray
    noise: RealArray
    known: BoolArray

    def convert(self, matrix: FloatArray) -> "Light":
        """The same in other colours, by a matrix (3, 3)."""
        return Light(self.radiance @ matrix.T, np.sqrt(self.noise ** 2 @ (matrix ** 2).T), self.known)


def check_bright(radiance: RealArray, where: str | Path) -> None:
    """Raise DatasetError, of a file or its name, where a photograph is black: whatever is predicted of it is right."""
    if not (radiance > 0).any():
        raise DatasetError("a black photograph: none of its pixels is above 0, expected what a lamp lights", where)


def same_pictures(pictures: Sequence[RealArray], names: Sequence[str]) -> tuple[str, ...]:
    """A line that tells of photographs, (h, w, channels), which repeat another one's picture, if there are any."""
    sums = [float(picture.sum()) for picture in pictures]
    same = [number for number, picture in enumerate(pictures) if any(
        sums[before] == sums[number] and np.array_equal(pictures[before], picture) for before in range(number))]
    return () if not same else (f"{len(same)} of {len(pictures)} photographs repeat the picture of another one, "
                                f"{names[same[0]]} for one: expected each under a lamp of its own",)


def merge_exposures(exposures: Sequence[Exposure]) -> Light:
    """The light that one or more exposures of one size saw, in units of white at an exposure of 1."""
    good = [np.asarray((each.pixels < SATURATED).all(axis=2)) for each in exposures]
    known = np.asarray(np.any(good, axis=0))
    radiance, shortest = np.zeros(exposures[0].pixels.shape), min(exposures, key=lambda each: each.exposure)
    for number in range(1 + _ROUNDS):
        total, weights = np.zeros_like(radiance), np.zeros_like(radiance)
        for each, is_good in zip(exposures, good, strict=True):
            # first as if nothing were there but the noise of the dark
            expected = np.maximum(radiance * each.exposure, 0) if number else 0.0
            variance = READ ** 2 + SHOT * expected + np.square(each.step) / 12
            weight = is_good[..., None] * each.exposure ** 2 / variance
            total, weights = total + weight * each.pixels / each.exposure, weights + weight
        # where all are saturated, it is as bright as that at least
        radiance = np.divide(total, weights, out=shortest.pixels / shortest.exposure, where=weights > 0)
    noise = np.divide(1, np.sqrt(weights), out=np.zeros_like(weights), where=weights > 0)
    return Light(radiance, noise, known)


def subtract_dark(light: Light, dark: Light) -> Light:
    """Light less what was there with the lamp off."""
    return Light(light.radiance - dark.radiance, np.hypot(light.noise, dark.noise), light.known & dark.known)


def divide_flat(light: Light, flat: Light, middle: RealArray) -> Light:
    """Light without the vignetting that a photograph of an evenly bright surface shows, in whose middle this is
    `middle`, (channels,): what is seen there stays as it is."""
    share = flat.radiance / np.where(middle > 0, middle, 1)
    seen = flat.known & (share > 0).all(axis=2)
    share = np.where(seen[..., None], share, 1.0)
    return Light(light.radiance / share, light.noise / share, light.known & seen)


@dataclass
class Pictures:
    """How all pictures of a description are read, and what those that were read say."""

    setup: CaptureSetup
    said: dict[Path, PictureFile] = field(default_factory=dict)     # of the files that were read, without their pixels
    _known: dict[tuple[str, str], Light] = field(default_factory=dict)      # of the whole lamp, by key and part

    @cached_property
    def infos(self) -> list[PictureInfo]:
        """What the photographs' first files say."""
        return [read_picture_info(each.files[0]) for each in self.setup.photographs]

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the photographs. Raises DatasetError if they have several."""
        sizes: dict[tuple[int, int], Shot] = {}
        for each, info in zip(self.setup.photographs, self.infos, strict=True):
            sizes.setdefault(info.size, each)
        if len(sizes) > 1:
            raise DatasetError("photographs of several sizes found: " + ", ".join(
                f"{each.name} {width} x {height}" for (height, width), each in sizes.items()), self.setup.path)
        return next(iter(sizes))

    @cached_property
    def photographs(self) -> list[Light]:
        """What the photographs show."""
        return self.read_photographs(self.setup.photographs)

    def read_photographs(self, shots: Sequence[Shot], part: Part | None = None,
                         reduce: Callable[[Light], Light] = lambda light: light) -> list[Light]:
        """What a part of photographs, which have one size, shows, and is kept of it: they are read one at a time."""
        lights, _ = [], self.size
        for number, each in enumerate(shots):
            progress.report(number / len(shots), f"Reading {each.name}")
            lights.append(reduce(self.lamp_light(each, "files", part)))
        return lights

    def light(self, given: Lit | LampSetup, key: str, part: Part | None = None) -> Light:
        """The light of the files of a key, in the colours of the camera; of a part in single precision."""
        part, precision = (WHOLE, np.float64) if part is None else (part, np.float32)
        paths = getattr(given, key)
        pictures = [read_picture(path, self.setup.camera.encoding) for path in paths]
        self.said |= {path: replace(each, stored=each.stored[:0].copy())
                      for path, each in zip(paths, pictures, strict=True)}
        if key == "files" and not any((each.stored > 0).any() for each in pictures):
            check_bright(pictures[0].stored, paths[0])
        if given.exposures is None and len(paths) > 1 and any(each.exposure is None for each in pictures):
            raise given.error("exposures", "one for each file, for these do not say theirs")
        exposures = ([each.exposure or 1.0 for each in pictures] if given.exposures is None
                     else given.exposures.tolist())
        shapes = {each.stored.shape for each in pictures}
        if len(shapes) > 1:
            raise DatasetError(f"exposures of several sizes found: {', '.join(map(str, sorted(shapes)))}", paths[0])
        rows, columns = (range(*each.indices(side)) for each, side in zip(part, shapes.pop(), strict=False))
        kept = len(rows), len(columns), pictures[0].stored.shape[2]
        light = Light(np.zeros(kept, precision), np.zeros(kept, precision), np.zeros(kept[:2], bool))
        step = max(_BAND // max(len(columns), 1), 1)
        for first in range(0, len(rows), step):
            band = slice(first, min(first + step, len(rows)))
            there = slice(rows.start + band.start, rows.start + band.stop), slice(columns.start, columns.stop)
            merged = merge_exposures([Exposure(*each.linear(there), exposure)
                                      for each, exposure in zip(pictures, exposures, strict=True)])
            for whole, values in zip(light, merged, strict=True):
                whole[band] = values
        return light

    def lamp_light(self, given: Lit, key: str, part: Part | None = None) -> Light:
        """The light of the lamp alone, without vignetting, in linear Rec.709 where the camera's colours are known."""
        lamp, camera = self.setup.lamp, self.setup.camera
        dark, flat = (self._known_light(name, part) if getattr(lamp, name) else None for name in ("dark", "flat"))
        light, path = self.light(given, key, part), getattr(given, key)[0]
        for what, other in (("with the lamp off", dark), ("of an even surface", flat)):
            if other is not None and other.radiance.shape != light.radiance.shape:
                raise DatasetError(f"the photograph {what} has the size {other.radiance.shape}, expected "
                                   f"{light.radiance.shape} as of the others", path)
        if dark is not None:
            light = subtract_dark(light, dark)
        if flat is not None and lamp.flat:
            rows, columns = (slice(int(side * (0.5 - _CENTRE)), int(side * (0.5 + _CENTRE)) + 1)
                             for side in read_picture_info(lamp.flat[0]).size)
            middle = self._known_light("flat", (rows, columns))
            light = divide_flat(light, flat, middle.radiance.mean(axis=(0, 1)))
        matrix = camera.matrix if camera.matrix is not None else self.said[path].matrix
        return light if matrix is None or light.radiance.shape[2] != 3 else light.convert(matrix)

    def _known_light(self, key: str, part: Part | None) -> Light:
        """That of a file that belongs to all photographs."""
        name = key, repr(part)
        if name not in self._known:
            self._known[name] = self.light(self.setup.lamp, key, part)
        return self._known[name]

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known of the files: one note for all of which the same is."""
        of_files: dict[str, list[str]] = {}
        for path, picture in self.said.items():
            for note in picture.notes:
                of_files.setdefault(note, []).append(printable(path.name))
        return tuple(f"{names[0] if len(names) == 1 else f'{len(names)} files, {names[0]} to {names[-1]}'}: {note}"
                     for note, names in of_files.items())


def read_mask(given: BallSetup | SampleSetup, size: tuple[int, int]) -> BoolArray | None:
    """Where the mask that is named is white, and within an outline: (height, width); None where neither is there."""
    outline = given.outline if isinstance(given, SampleSetup) else None
    inside = None if outline is None else polygon_mask(outline, size)
    if inside is not None and not inside.any():
        raise given.error("outline", f"one around pixels of pictures of {size[1]} x {size[0]}")
    if not given.mask:
        return inside
    path = given.mask[0]
    picture = read_picture(path)
    if picture.is_turned:
        raise DatasetError("EXIF says that viewers show this mask turned or mirrored: save it without that", path)
    mask = picture.pixels.mean(axis=2) > _MASKED
    if mask.shape != size:
        raise DatasetError(f"{mask.shape[1]} x {mask.shape[0]} pixels found, expected {size[1]} x {size[0]} as the "
                           f"photographs have", path)
    if not mask.any():
        raise DatasetError("nothing is white in this mask", path)
    return mask if inside is None else mask & inside


def bounds(mask: BoolArray, beside: int = 0) -> Part:
    """The rows and columns that have pixels of a mask, (h, w), and so many beside them."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return (slice(max(rows[0] - beside, 0), rows[-1] + beside + 1),
            slice(max(columns[0] - beside, 0), columns[-1] + beside + 1))


def polygon_mask(outline: FloatArray, size: tuple[int, int]) -> BoolArray:
    """The pixels of a picture of this height and width whose centres are within a polygon (n, 2), by the even-odd rule.

    Examples
    --------
    >>> polygon_mask(np.array([[1.0, 0], [3, 0], [3, 2], [1, 2]]), (3, 4)).astype(int).tolist()
    [[0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]]
    """
    inside = np.zeros(size, bool)
    row, column = (np.arange(side) + 0.5 for side in size)
    for (x, y), (x_next, y_next) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        crossed = np.flatnonzero((y <= row) != (y_next <= row))
        inside[crossed] ^= column > (x + (row[crossed] - y) / (y_next - y or 1.0) * (x_next - x))[:, None]
    return inside
