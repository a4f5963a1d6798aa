"""The pictures of a description: exposures merged, the dark room taken away, in known colours."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..errors import DatasetError, printable
from .light import Exposure, Light, flattened, merged, without
from .picture_files import ENCODINGS, Picture, read_picture
from .table import LARGEST, LEAST, Table

_MASKED = 0.5               # of white


@dataclass
class Pictures:
    """How all pictures of a description are read, and what those that were read say.

    Attributes
    ----------
    encoding, matrix : str or None, (3, 3) or None
        Of the description.
    dark, flat : Light, or None
    said : dict of Path to Picture
        Of the files that were read, without their pixels.
    """

    encoding: str | None
    matrix: FloatArray | None
    dark: Light | None = None
    flat: Light | None = None
    said: dict[Path, Picture] = field(default_factory=dict)

    @classmethod
    def of(cls, camera: Table, lamp: Table) -> "Pictures":
        """As the tables `camera` and `lamp` say, which name the photographs of a dark room and an even surface."""
        encoding = camera.value("encoding")
        if encoding not in (None, *ENCODINGS):
            raise camera.error("encoding", " or ".join(ENCODINGS))
        pictures = cls(encoding, _matrix(camera))
        dark = pictures.light(lamp, "dark") if lamp.has("dark") else None
        flat = pictures.light(lamp, "flat") if lamp.has("flat") else None
        pictures.dark, pictures.flat = dark, flat
        return pictures

    def light(self, table: Table, key: str) -> Light:
        """The light of the files of a key, in the colours of the camera."""
        paths = table.files(key)
        pictures = [read_picture(path, self.encoding) for path in paths]
        self.said |= {path: replace(each, pixels=each.pixels[:0], step=0.0)
                      for path, each in zip(paths, pictures, strict=True)}
        given = table.numbers("exposures", len(paths)) if table.has("exposures") else None
        if given is not None and not (given >= LEAST).all():
            raise table.error("exposures", f"numbers of {LEAST:g} to {LARGEST:g}")
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
        path = table.files(key)[0]
        try:
            if self.dark is not None:
                light = without(light, self.dark)
            if self.flat is not None:
                light = flattened(light, self.flat)
        except DatasetError as error:
            raise DatasetError(str(error), path) from error
        matrix = self.matrix if self.matrix is not None else self.said[path].matrix
        if matrix is None or light.radiance.shape[2] != 3:
            return light
        return Light(light.radiance @ matrix.T, np.sqrt(light.noise ** 2 @ (matrix ** 2).T), light.known)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be known of the files: one note for all of which the same is."""
        of_files: dict[str, list[str]] = {}
        for path, picture in self.said.items():
            for note in picture.notes:
                of_files.setdefault(note, []).append(printable(path.name))
        return tuple(f"{_named(names)}: {note}" for note, names in of_files.items())


def _named(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{len(names)} files, {names[0]} to {names[-1]}"


def _matrix(camera: Table) -> FloatArray | None:
    if not camera.has("matrix"):
        return None
    return camera.rows("matrix", (3, 3), "three rows of three numbers")


def mask_of(table: Table, size: tuple[int, int]) -> BoolArray | None:
    """The mask that a table names, where it is white: (height, width); None where it names none."""
    if not table.has("mask"):
        return None
    path, = table.files("mask")[:1]
    picture = read_picture(path)
    if picture.is_turned:
        raise DatasetError("EXIF says that viewers show this mask turned or mirrored: save it without that", path)
    mask = picture.pixels.mean(axis=2) > _MASKED
    if mask.shape != size:
        raise DatasetError(f"{mask.shape[1]} x {mask.shape[0]} pixels found, expected {size[1]} x {size[0]} as the "
                           f"photographs have", path)
    if not mask.any():
        raise DatasetError("nothing is white in this mask", path)
    return mask
