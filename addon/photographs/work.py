"""What worker processes do with photographs of a ball, or of a flat sample. Nothing here imports bpy."""

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...fitter import DatasetError, Fit, FlatPhotograph, load, maps_from_flat, progress
from ...fitter.arrays import FloatArray
from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.formats import saved_samples
from ...fitter.photographs import flat_maps, flat_setup, light_positions, setup
from ...fitter.photographs.ball_advice import advice, left_out
from ...fitter.photographs.capture_setup import (
    GUESS,
    PICTURES,
    SUFFIXES,
    CameraSetup,
    CaptureSetup,
    Description,
    descriptions_in,
    in_order,
    parse,
    pictures_in,
    read,
)
from ...fitter.photographs.flat import check_materials
from ...fitter.photographs.flat_tiling import tile_size, tiled
from ...fitter.photographs.picture_files import PictureInfo, read_picture_info
from ..core.annotations import Arguments
from ..core.storage.outcomes import EmbeddedFit, Outcome
from ..work import tasks

LENS, SENSOR = 85.0, 36.0   # mm, where the files do not say theirs
START = -0.6, -0.8, 0.7     # m from the origin: where lamps are until somebody says where they stood
LIGHT_POSITIONS = light_positions.SUFFIX, *light_positions.PROJECTS
_ALIKE = 0.01               # relative difference of exposures that are the same
# what messages have of a description, and what the panel has in its place
_IN_PANEL = {'say so by encoding = "linear"': "set Values to Linear",
             "leave_out leaves such photographs out": "Untick such photographs to leave them out",
             ", lamp.dark,": " (Lamp Off)", "camera.matrix": "Camera Matrix", "sample.corners": "Corners",
             "sample.outline": "Drawn Mask", "sample.width": "Width", "sample.height": "Height",
             "scale.card.region": "Region", "scale.card.albedo": "Albedo", "scale.ball.albedo": "Albedo",
             "scale.albedo": "Albedo", "chrome.mask": "Chrome Ball"}


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
    doubts : tuple of str
        Those lines that say that something is wrong.
    """

    outcome: Outcome
    content: bytes
    centre: FloatArray
    intensity: FloatArray
    told: tuple[str, ...]
    doubts: tuple[str, ...]


def find_description(paths: Sequence[str], radius: float, distance: float, count: int) -> setup.Resolved:
    """The description that a file is, or a folder has; else one of the pictures, or of those in the folder, as
    `described` makes it."""
    folder = Path(paths[0])
    if len(paths) == 1 and (folder.suffix.lower() in SUFFIXES or (folder.is_dir() and descriptions_in(folder))):
        return setup.resolved(read(paths[0]))
    return described(paths, radius, distance, count)


def in_panel(text: str) -> str:
    """A message with the names that the panel has, in the place of keys of a description."""
    for key, name in _IN_PANEL.items():
        text = text.replace(key, name)
    return text


@contextmanager
def _names_of_panel() -> Iterator[None]:
    """Let errors of a scene's description name what the panel has."""
    try:
        yield
    except DatasetError as error:
        raise DatasetError(in_panel(str(error))) from error


class SampleDescription(NamedTuple):
    """A description of a flat sample whose places are numbers, and the materials that it names, fitted."""

    resolved: setup.Resolved
    materials: list[Outcome]


def find_sample_description(paths: Sequence[str], width: float, count: int, arguments: Arguments,
                            how: Arguments) -> SampleDescription:
    """The description of a flat sample that a file is, or a folder has; else one of light positions or pictures.

    Then it fills the pictures, is so many metres wide, and its albedo is a guess; the camera looks straight down.
    `arguments` are of fits, `how` keyword arguments of `fitter.load`.
    """
    with progress.part(0.0, 0.3):
        found = _resolved_sample(paths, width, count)
    with progress.part(0.3, 1.0):
        named = found.setup.materials
        return SampleDescription(found, _materials(named, arguments, how) if isinstance(named, tuple) else [])


def _materials(files: Sequence[Path], arguments: Arguments, how: Arguments) -> list[Outcome]:
    """Saved fits, and fits of measurements. All are looked at before one is fitted."""
    read_files = [Fit.load(file) if saved_samples.is_another(file) else load(file, **how) for file in files]
    check_materials(read_files, 3)
    space, made = how["colours"], []
    for file, each in progress.each([*zip(files, read_files, strict=True)]):
        if not isinstance(each, Fit):
            made.append(tasks.outcome(str(file), "", arguments, how=how))
        elif space == DEFAULT_COLOURS:
            made.append(tasks.outcome_alone(each, space))
        else:
            raise DatasetError(f"a fit for the colours {DEFAULT_COLOURS}, and the open file has {space}: name its "
                               "measurements", file)
    return made


def _resolved_sample(paths: Sequence[str], width: float, count: int) -> setup.Resolved:
    path = Path(paths[0])
    if path.is_dir() and descriptions_in(path):
        path = descriptions_in(path)[0]
    if len(paths) == 1 and path.suffix.lower() == ".toml":
        return flat_setup.resolved(read(path))
    folder = path if path.is_dir() else path.parent
    whole = {"name": folder.absolute().name, "camera": {"position": "far"}, "scale": {"albedo": GUESS},
             "sample": {"width": width, "height": width}}
    if len(paths) == 1 and path.suffix.lower() in LIGHT_POSITIONS:
        made = parse({**whole, "lamp": {"positions": path.name}}, path)
        size = setup.size_of(made)
    else:
        groups, first = _grouped(paths, count)
        lens = {} if first.field_of_view is None and first.focal_length is None else {"camera": _lens(first)}
        made = parse({**whole, **lens, "photograph": [{"files": group, "lamp": list(START)} for group in groups]},
                     folder / "photographs")
        size = first.size
    edge = np.array([[0, size[0]], size[::-1], [size[1], 0], [0, 0]], dtype=float)
    return flat_setup.resolved(replace(made, sample=replace(made.of_sample(), height=width * size[0] / size[1],
                                                            corners=edge)))


def described(paths: Sequence[str], radius: float, distance: float, count: int) -> setup.Resolved:
    """A description of pictures of a ball at the origin, whose lamps nobody has placed yet.

    Radius of the ball, and distance of the camera from it, are in metres; `count` is that of exposures under each lamp,
    0: as the files say.
    """
    groups, first = _grouped(paths, count)
    folder = Path(paths[0]).parent
    return setup.Resolved(parse(
        {"name": folder.name, "camera": {"position": [0.0, -distance, 0.0], **_lens(first)},
         "ball": {"centre": [0.0, 0.0, 0.0], "radius": radius}, "scale": {"albedo": GUESS},
         "photograph": [{"files": group, "lamp": list(START)} for group in groups]}, folder / "photographs"),
        first.size)


def _grouped(paths: Sequence[str], count: int) -> tuple[list[list[str]], PictureInfo]:
    """Pictures, or those in a folder, by their lamps, and what the first file says."""
    folder = Path(paths[0])
    if len(paths) == 1 and folder.is_dir():
        paths = list(map(str, pictures_in(folder)))
        if not paths:
            raise DatasetError(f"a folder without photographs ({', '.join(PICTURES)})", folder)
    paths = sorted(paths, key=lambda path: in_order(Path(path).name))
    abouts: list[PictureInfo] = []
    for number, path in enumerate(paths):
        progress.report(number / len(paths), f"Looking at {Path(path).name}")
        abouts.append(read_picture_info(path))
    sizes = dict.fromkeys(each.size for each in abouts)
    if len(sizes) > 1:
        raise DatasetError("photographs of several sizes found: " + ", ".join(
            f"{width} x {height}" for height, width in sizes), Path(paths[0]).parent)
    return _groups(paths, [each.exposure for each in abouts], count), abouts[0]


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


def _lens(said: PictureInfo) -> dict[str, float]:
    if said.field_of_view is None:
        return {"focal_length": said.focal_length or LENS, "sensor_width": SENSOR}
    half = math.tan(said.field_of_view / 2)
    focal = said.focal_length or SENSOR / (2 * half)
    return {"focal_length": focal, "sensor_width": 2 * focal * half}


def outline(description: Description, name: str) -> list[float]:
    """Where the ball of a description is, by its outline in the photographs."""
    ball = {**description["ball"], "centre": "outline"}
    with _names_of_panel():
        found = setup.resolved(parse({**description, "ball": ball}, name)).setup.of_ball()
    return np.asarray(found.centre).tolist()


def camera_by_corners(description: Description, name: str) -> CameraSetup:
    """Where the camera of a flat sample was, by its corners."""
    with _names_of_panel():
        return flat_setup.resolved(parse(description, name)).setup.camera


def lamps_by(description: Description, name: str, paths: Sequence[str], distance: float,
             mask: str) -> list[list[float] | None]:
    """Where the lamp of each photograph of a description was, None where that is not said.

    It is said by a file of light positions, or by pictures of a chrome ball, one for each in the order of their names.
    The distance is from the middle of ball or sample, metres, 0 of lamps far away; the mask says where that ball is.
    """
    shots = [{key: value for key, value in shot.items() if key != "lamp"} for shot in description["photograph"]]
    away = {"distance": distance} if distance else {}
    lamp = {**description["lamp"], **away}
    if len(paths) == 1 and Path(paths[0]).suffix.lower() in LIGHT_POSITIONS:
        lamp["positions"] = paths[0]
    elif len(paths) != len(shots):
        raise DatasetError(f"{len(paths)} pictures of a chrome ball found, expected {len(shots)}, one for each "
                           f"photograph", paths[0])
    else:
        ordered = sorted(paths, key=lambda path: in_order(Path(path).name))
        shots = [{**shot, "chrome": path, **away} for shot, path in zip(shots, ordered, strict=True)]
    told = {**description, "lamp": lamp, "photograph": shots, **({"chrome": {"mask": mask}} if mask else {})}
    with _names_of_panel():
        made = parse(told, name)
        found = (setup if made.sample is None else flat_setup).resolved(made).setup.photographs
    places = {each.files: np.asarray(each.lamp).tolist() for each in found}
    return [places.get(tuple(map(Path, shot["files"]))) for shot in shots]


def measured(description: Description, name: str, path: str, arguments: Arguments, how: Arguments) -> Result:
    """Measure, and fit what was measured, as `setup.measured` and `tasks.outcome` do.

    The file of the samples is not written; `path` is where it will be.
    """
    with progress.part(0.0, 0.4, "Measuring"), _names_of_panel():
        samples, photographs, doubts = setup.measured(parse(description, name))
    with tempfile.TemporaryDirectory() as folder, progress.part(0.4, 0.8):
        part = Path(folder, Path(path).name)
        saved_samples.write(samples, part)
        outcome = tasks.outcome(str(part), "", arguments, how=how)
        content = part.read_bytes()
    with progress.part(0.8, 1.0, about="Next lamp: "):
        others = left_out(photographs)
        told = *map(in_panel, samples.notes), others.words, *advice(samples)
    return Result(outcome._replace(measured=outcome.measured._replace(path=path)), content, photographs[0].centre,
                  photographs[0].intensity, told, (*doubts, *([others.words] if others.is_bad else [])))


class Maps(NamedTuple):
    """What photographs of a flat sample have measured.

    Attributes
    ----------
    name : str
    outcomes : list of Outcome
        Of the materials that were found; empty where they were chosen.
    masks : list of (bytes, float)
        The share of each material but the first, where it lies upon those before it: a PNG of 16 bits, and its mean.
    brightness : bytes
        What the mix is multiplied with, over `most`: a PNG of 16 bits.
    most : float
    normals : bytes
        A normal map: a PNG of 16 bits.
    is_tile : bool
        Whether they can be repeated.
    part : (2, 2)
        Which part of the sample they are: its lower left and its upper right, shares of width and height.
    told, doubts : tuple of str
        What is to be said of it, and the lines of that which say that something is wrong.
    intensities : dict of (channels,) arrays
        Of the lamps, by the names of photographs, W/sr in units of the pictures.
    """

    name: str
    outcomes: list[Outcome]
    masks: list[tuple[bytes, float]]
    brightness: bytes
    most: float
    normals: bytes
    is_tile: bool
    part: FloatArray
    told: tuple[str, ...]
    doubts: tuple[str, ...]
    intensities: dict[str, FloatArray]


def measure_sample(description: Description, name: str, is_tile: bool, chosen: Sequence[EmbeddedFit],
                   how: Arguments) -> tuple[Maps, CameraSetup]:
    """Measure the flat sample of a scene's description, in the words of its panel, and where the camera was.

    It is a mix of chosen materials, else of those that are found; `how` are keyword arguments of `fitter.load`. A tile
    is `flat_tiling.tiled`. Raises DatasetError, ValueError.
    """
    with _names_of_panel():
        made = parse(description, name)
        maps = _measured_maps(made, is_tile, chosen, how["colours"])
        return (maps._replace(told=tuple(map(in_panel, maps.told)), doubts=tuple(map(in_panel, maps.doubts))),
                flat_setup.resolved(made).setup.camera)


def _measured_maps(made: CaptureSetup, is_tile: bool, chosen: Sequence[EmbeddedFit], space: str) -> Maps:
    with progress.part(0.0, 0.3, "Reading"):
        sample = flat_setup.flat(made)
    photographs = [_in_colours(each, space) for each in sample.photographs]
    fits = [tasks.kept_fit(each) for each in chosen]
    with progress.part(0.3, 0.75):
        maps = maps_from_flat(photographs, sample.corners, sample.shape, fits or sample.number)
    with progress.part(0.75, 0.85, about="Checking: "):
        report = flat_maps.report(maps, photographs, sample.albedo)
    told = *sample.notes, *sample.doubts, *report.lines
    if is_tile:
        with progress.part(0.85, 0.95):
            maps = tiled(maps)
        told = *told, tile_size(maps)
    with progress.part(0.95, 1.0):
        outcomes = [] if fits else [tasks.outcome_alone(replace(each, name=f"{sample.name}: {each.name}"), space)
                                    for each in progress.each(maps.fits)]
    masks, brightness, most = flat_maps.layers(maps.weights)
    first, last = sample.corners[[0, 2], :2]
    return Maps(sample.name, outcomes,
                [(flat_maps.png(each), float(each.mean())) for each in np.moveaxis(masks, 2, 0)],
                flat_maps.png(brightness), most, flat_maps.png(flat_maps.normal_map(maps)), is_tile,
                (maps.corners[[0, 2], :2] - first) / (last - first), told, (*sample.doubts, *report.doubts),
                {each.name: each.intensity for each in sample.photographs})


def _in_colours(photograph: FlatPhotograph, space: str) -> FlatPhotograph:
    """A photograph in another colour space: what it shows under a white lamp."""
    if space == DEFAULT_COLOURS or photograph.radiance.shape[2] == 1:
        return photograph
    given = photograph.intensity
    return replace(photograph, radiance=photograph.radiance / given @ conversion(DEFAULT_COLOURS, space).T,
                   intensity=np.ones(3), mask=photograph.counts[..., 0] > 0,
                   noise=None if photograph.noise is None else photograph.noise / given)
