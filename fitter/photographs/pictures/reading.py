"""The pictures of a description: exposures merged, the dark room taken away, in known colours."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ... import progress
from ...arrays import BoolArray, FloatArray
from ...errors import DatasetError, printable
from ...imaging.picture_files import PictureFile, PictureInfo, read_picture, read_picture_info
from ..description.capture_setup import BallSetup, CaptureSetup, LampSetup, Lit, SampleSetup, Shot
from .light import Exposure, Light, check_bright, divide_flat, merge_exposures, middle_part, subtract_dark

_MASKED = 0.5               # of white
_BAND = 1 << 20             # pixels that are merged at a time

Part = tuple[slice, slice]
"""The rows and columns of pictures that are kept."""
WHOLE: Part = (slice(None), slice(None))


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
        """What the photographs show, each of one size. Raises DatasetError if one is black."""
        return self.read_photographs(self.setup.photographs)

    def read_photographs(self, shots: Sequence[Shot], part: Part | None = None,
                         reduce: Callable[[Light], Light] = lambda light: light) -> list[Light]:
        """What a part of photographs shows, and is kept of it: they are read one at a time."""
        lights, _ = [], self.size
        for number, each in enumerate(shots):
            progress.report(number / len(shots), f"Reading {each.name}")
            lights.append(reduce(self.lamp_light(each, "files", part)))
            if part is None:
                check_bright(lights[-1].radiance, each.files[0])
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
            middle = self._known_light("flat", middle_part(read_picture_info(lamp.flat[0]).size))
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
