"""What worker processes do with photographs of a ball. Nothing here imports bpy."""

import math
import tempfile
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from ...fitter import DatasetError, progress
from ...fitter.arrays import FloatArray
from ...fitter.formats import saved_samples
from ...fitter.photographs import setup
from ...fitter.photographs.coverage import advice, coverage
from ...fitter.photographs.descriptions import (
    GUESS,
    PICTURES,
    SUFFIXES,
    Description,
    descriptions_in,
    in_order,
    pictures_in,
    read,
)
from ...fitter.photographs.picture_files import About, about
from ..core.annotations import Arguments
from ..core.outcomes import Outcome
from ..work import tasks

LENS, SENSOR = 85.0, 36.0   # mm, where the files do not say theirs
START = -0.6, -0.8, 0.7     # m from the origin: where lamps are until somebody says where they stood
_ALIKE = 0.01               # relative difference of exposures that are the same


class Result(NamedTuple):
    """What photographs have measured.

    Attributes
    ----------
    outcome : Outcome
        The fit of the samples, and what a material is made from.
    content : bytes
        The file of the samples.
    centre : (3,)
        Of the ball, by its outline, metres.
    intensity : (channels,)
        Of the lamp, W/sr in units of the pictures.
    told : tuple of str
        What was measured, what that covers, and where to put the next lamp.
    """

    outcome: Outcome
    content: bytes
    centre: FloatArray
    intensity: FloatArray
    told: tuple[str, ...]


def found(paths: Sequence[str], radius: float, distance: float, count: int) -> setup.Resolved:
    """The description that a file is, or a folder has; else one of the pictures, or of those in the folder, as
    `described` makes it."""
    folder = Path(paths[0])
    if len(paths) == 1 and (folder.suffix.lower() in SUFFIXES or (folder.is_dir() and descriptions_in(folder))):
        return opened(paths[0])
    if len(paths) == 1 and folder.is_dir():
        paths = list(map(str, pictures_in(folder)))
        if not paths:
            raise DatasetError(f"a folder without photographs ({', '.join(PICTURES)})", folder)
    return described(paths, radius, distance, count)


def described(paths: Sequence[str], radius: float, distance: float, count: int) -> setup.Resolved:
    """A description of pictures of a ball at the origin, whose lamps nobody has placed yet.

    Radius of the ball, and distance of the camera from it, are in metres; `count` is that of exposures under each lamp,
    0: as the files say.
    """
    paths = sorted(paths, key=lambda path: in_order(Path(path).name))
    abouts: list[About] = []
    for number, path in enumerate(paths):
        progress.report(number / len(paths), f"Looking at {Path(path).name}")
        abouts.append(about(path))
    sizes = dict.fromkeys(each.size for each in abouts)
    if len(sizes) > 1:
        raise DatasetError("photographs of several sizes found: " + ", ".join(
            f"{width} x {height}" for height, width in sizes), Path(paths[0]).parent)
    groups = _groups(paths, [each.exposure for each in abouts], count)
    return setup.Resolved(
        {"name": Path(paths[0]).parent.name, "camera": {"position": [0.0, -distance, 0.0], **_lens(abouts[0])},
         "ball": {"centre": [0.0, 0.0, 0.0], "radius": radius}, "scale": {"albedo": GUESS},
         "photograph": [{"files": group, "lamp": list(START)} for group in groups]}, abouts[0].size)


def _groups(paths: Sequence[str], exposures: Sequence[float | None], count: int) -> list[list[str]]:
    """The files of each lamp: so many that follow one another, or as many as have exposures that then repeat."""
    count = count or _bracket(exposures)
    if len(paths) % count:
        raise DatasetError(f"{len(paths)} pictures found, expected a multiple of {count} exposures")
    return [list(paths[first:first + count]) for first in range(0, len(paths), count)]


def _bracket(exposures: Sequence[float | None]) -> int:
    known = [each for each in exposures if each is not None]
    if len(known) < len(exposures):
        return 1
    for count in range(2, len(known) // 2 + 1):
        repeats = len(known) % count == 0 and all(
            math.isclose(each, known[number % count], rel_tol=_ALIKE) for number, each in enumerate(known))
        first = sorted(known[:count])
        differ = all(not math.isclose(a, b, rel_tol=_ALIKE) for a, b in pairwise(first))
        if repeats and differ:
            return count
    return 1


def _lens(said: About) -> dict[str, float]:
    if said.field_of_view is None:
        return {"focal_length": said.focal_length or LENS, "sensor_width": SENSOR}
    half = math.tan(said.field_of_view / 2)
    focal = said.focal_length or SENSOR / (2 * half)
    return {"focal_length": focal, "sensor_width": 2 * focal * half}


def opened(path: str) -> setup.Resolved:
    """The description in a file, with absolute paths and all places in numbers."""
    return setup.resolved(*read(path))


def outline(description: Description, name: str) -> list[float]:
    """Where the ball of a description is, by its outline in the photographs."""
    ball = {**description["ball"], "centre": "outline"}
    centre: list[float] = setup.resolved({**description, "ball": ball}, name).description["ball"]["centre"]
    return centre


def lamp_by_chrome(description: Description, name: str, chrome: str, distance: float) -> list[float]:
    """Where the lamp of the only photograph of a description was, by the picture of a chrome ball and the lamp's
    distance from the middle of the ball, metres."""
    photograph, = description["photograph"]
    shot = {"files": photograph["files"], "chrome": chrome, "distance": distance}
    if "exposures" in photograph:
        shot["exposures"] = photograph["exposures"]
    lamp: list[float] = setup.resolved({**description, "photograph": [shot]}, name).description["photograph"][0]["lamp"]
    return lamp


def measured(description: Description, name: str, path: str, arguments: Arguments, how: Arguments) -> Result:
    """Measure, and fit what was measured, as `setup.measured` and `tasks.outcome` do.

    The file of the samples is not written; `path` is where it will be.
    """
    with progress.part(0.0, 0.4, "Measuring"):
        samples, photographs = setup.measured(description, name)
    with tempfile.TemporaryDirectory() as folder, progress.part(0.4, 1.0):
        part = Path(folder, Path(path).name)
        saved_samples.write(samples, part)
        outcome = tasks.outcome(str(part), "", arguments, how=how)
        content = part.read_bytes()
    return Result(outcome._replace(measured=outcome.measured._replace(path=path)), content, photographs[0].centre,
                  photographs[0].intensity, (*samples.notes, *advice(coverage(samples))))
