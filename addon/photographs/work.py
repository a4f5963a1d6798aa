"""What worker processes do with photographs of a ball, or of a flat sample. Nothing here imports bpy."""

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...fitter import DatasetError, Fit, FlatPhotograph, load, maps_from_flat, progress
from ...fitter.arrays import FloatArray
from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.formats import saved_samples
from ...fitter.imaging.picture_files import PictureInfo, read_picture_info
from ...fitter.photographs.ball import measuring
from ...fitter.photographs.capture import resolve
from ...fitter.photographs.description import light_positions, parsing
from ...fitter.photographs.description.capture_setup import GUESS, CaptureSetup, Description
from ...fitter.photographs.flat import map_files
from ...fitter.photographs.flat.maps import check_materials
from ...fitter.photographs.flat.reading import read_sample
from ...fitter.photographs.flat.tiling import cut_tile, tile_size
from ...fitter.photographs.pictures import Light, Pictures
from ...fitter.photographs.report import report_ball, report_sample
from ...fitter.photographs.rig.camera import CameraView
from ...fitter.photographs.rig.lamps import Scene
from ..core.annotations import Arguments, not_none
from ..core.storage.outcomes import EmbeddedFit, Outcome
from ..work import tasks

LENS, SENSOR = 85.0, 36.0   # mm, where the files do not say theirs
START = -0.6, -0.8, 0.7     # m from the origin: where lamps are until somebody says where they stood
LIGHT_POSITIONS = light_positions.SUFFIX, *light_positions.PROJECTS
_SAME_EXPOSURE = 0.01       # relative difference of exposures that are the same
# what messages have of a description, and what the panel has in its place
_IN_PANEL = {'say so by encoding = "linear"': "set Values to Linear",
             "leave_out leaves such photographs out": "Untick such photographs to leave them out",
             ", lamp.dark,": " (Lamp Off)", "camera.matrix": "Camera Matrix", "sample.corners": "Corners",
             "sample.outline": "Drawn Mask", "sample.width": "Width", "sample.height": "Height",
             "scale.card.region": "Region", "scale.card.albedo": "Albedo", "scale.ball.albedo": "Albedo",
             "scale.albedo": "Albedo", "chrome.mask": "Chrome Ball"}


class BallResult(NamedTuple):
    """What photographs of a ball have measured."""

    outcome: Outcome        # the fit of the samples, and what a material is made from
    content: bytes          # the file of the samples
    centre: FloatArray      # of the ball, by its outline, metres: (3,)
    intensity: FloatArray   # of the lamp, W/sr in units of the pictures: (channels,)
    told: tuple[str, ...]   # what was measured, what that covers, and where to put the next lamp
    doubts: tuple[str, ...]         # those lines that say that something is wrong


class SampleResult(NamedTuple):
    """What photographs of a flat sample have measured; pictures are PNG of 16 bits."""

    name: str
    view: CameraView
    outcomes: list[Outcome]         # of the materials that were found; empty where they were chosen
    masks: list[tuple[bytes, float]]    # the share of each but the first, where it lies upon those before; its mean
    brightness: bytes               # what the mix is multiplied with, over `most`
    most: float
    normals: bytes
    is_tile: bool                   # whether they can be repeated
    part: FloatArray                # of the sample: its lower left and upper right, shares of its sides, (2, 2)
    told: tuple[str, ...]           # what is to be said of it
    doubts: tuple[str, ...]         # the lines of that which say that something is wrong
    intensities: dict[str, FloatArray]      # of the lamps, by the names of photographs, W/sr in units of the pictures


def translate_keys(text: str) -> str:
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
        raise DatasetError(translate_keys(str(error))) from error


def find_scene(paths: Sequence[str], whole: Description, count: int, arguments: Arguments,
               how: Arguments) -> tuple[Scene, list[Outcome]]:
    """The scene of the description that a file is, or a folder has, and the materials that it names, fitted.

    Else that of pictures, or light positions: `whole` has camera and ball, or a square sample, which gets the height of
    the pictures. There are `count` exposures under each lamp, 0: as the files say. `arguments` are of fits, `how` of
    `fitter.load`.
    """
    with progress.part(0.0, 0.3):
        path = Path(paths[0])
        if len(paths) == 1 and path.is_dir():
            path = parsing.find_description(path)
        suffix = path.suffix.lower() if len(paths) == 1 else ""
        if suffix == ".toml" or (suffix == light_positions.SUFFIX and "ball" in whole):
            setup = parsing.read(path)
        else:
            setup = _describe_pictures(paths, path, whole, count, suffix in LIGHT_POSITIONS)
        if "ball" in whole:
            setup.need_ball()
        else:
            setup.need_sample()
        scene = resolve(setup)
    with progress.part(0.3, 1.0):
        named = setup.materials
        return scene, _fit_materials(named, arguments, how) if isinstance(named, tuple) else []


def _describe_pictures(paths: Sequence[str], path: Path, whole: Description, count: int,
                       by_positions: bool) -> CaptureSetup:
    """A description of pictures whose lamps light positions say, or nobody has placed yet."""
    folder = path if path.is_dir() else path.parent
    described = {"name": folder.absolute().name, "scale": {"albedo": GUESS}, **whole}
    if by_positions:
        setup = parsing.parse({**described, "lamp": {"positions": path.name}}, path)
    else:
        groups, first = _group_pictures(paths, count)
        if "ball" in whole or first.field_of_view is not None or first.focal_length is not None:
            described["camera"] = {**(whole["camera"] if "ball" in whole else {}), **_lens(first)}
        shots = [{"files": group, "lamp": list(START)} for group in groups]
        setup = parsing.parse({**described, "photograph": shots}, folder / "photographs")
    if setup.sample is None:
        return setup
    height, width = Pictures(setup).size
    edge = np.array([[0, height], [width, height], [width, 0], [0, 0]], dtype=float)
    return replace(setup, sample=replace(setup.sample, height=setup.sample.width * height / width, corners=edge))


def _fit_materials(files: Sequence[Path], arguments: Arguments, how: Arguments) -> list[Outcome]:
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


def _group_pictures(paths: Sequence[str], count: int) -> tuple[list[list[str]], PictureInfo]:
    """Pictures, or those in a folder, by their lamps, and what the first file says."""
    folder = Path(paths[0])
    if len(paths) == 1 and folder.is_dir():
        paths = list(map(str, parsing.find_files(folder, *parsing.PICTURES)))
        if not paths:
            raise DatasetError(f"a folder without photographs ({', '.join(parsing.PICTURES)})", folder)
    paths = sorted(paths, key=lambda path: parsing.natural_order(Path(path).name))
    abouts: list[PictureInfo] = []
    for number, path in enumerate(paths):
        progress.report(number / len(paths), f"Looking at {Path(path).name}")
        abouts.append(read_picture_info(path))
    count = count or _bracket([each.exposure for each in abouts])
    if len(paths) % count:
        raise DatasetError(f"{len(paths)} pictures found, expected a multiple of {count} exposures")
    return [list(paths[first:first + count]) for first in range(0, len(paths), count)], abouts[0]


def _bracket(exposures: Sequence[float | None]) -> int:
    """How many pictures each lamp has: as many as have exposures that then repeat."""
    known = [each for each in exposures if each is not None]
    if len(known) < len(exposures):
        return 1
    are_alike = partial(math.isclose, rel_tol=_SAME_EXPOSURE)
    for count in range(2, len(known) // 2 + 1):
        repeats = len(known) % count == 0 and all(map(are_alike, known, known[:count] * (len(known) // count)))
        if repeats and not any(are_alike(a, b) for a, b in pairwise(sorted(known[:count]))):
            return count
    return 1


def _lens(said: PictureInfo) -> dict[str, float]:
    if said.field_of_view is None:
        return {"focal_length": said.focal_length or LENS, "sensor_width": SENSOR}
    half = math.tan(said.field_of_view / 2)
    focal = said.focal_length or SENSOR / (2 * half)
    return {"focal_length": focal, "sensor_width": 2 * focal * half}


def _parse(description: Description) -> CaptureSetup:
    return parsing.parse(description, description["name"])


@_names_of_panel()
def find_places(description: Description) -> Scene:
    """The scene with the ball by its outline in the photographs, or the camera by the corners of a flat sample."""
    ball = {"ball": {**description["ball"], "centre": "outline"}} if "ball" in description else {}
    return resolve(_parse({**description, **ball}))


@_names_of_panel()
def lamps_by(description: Description, paths: Sequence[str], distance: float,
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
        ordered = sorted(paths, key=lambda path: parsing.natural_order(Path(path).name))
        shots = [{**shot, "chrome": path, **away} for shot, path in zip(shots, ordered, strict=True)]
    told = {**description, "lamp": lamp, "photograph": shots, **({"chrome": {"mask": mask}} if mask else {})}
    scene = resolve(_parse(told))
    places = {each.files: lamp.tolist() for each, lamp in zip(scene.setup.photographs, scene.lamps, strict=True)}
    return [places.get(tuple(map(Path, shot["files"]))) for shot in shots]


@_names_of_panel()
def measure_ball(description: Description, path: str, arguments: Arguments, how: Arguments) -> BallResult:
    """Measure, and fit what was measured, as `measuring.measure_ball` and `tasks.outcome` do. The file of the samples
    is not written; `path` is where it will be."""
    with progress.part(0.0, 0.4, "Measuring"):
        measured = measuring.measure_ball(_parse(description))
    with tempfile.TemporaryDirectory() as folder, progress.part(0.4, 0.8):
        part = Path(folder, Path(path).name)
        saved_samples.write(measured.samples, part)
        outcome = tasks.outcome(str(part), "", arguments, how=how)
        content = part.read_bytes()
    with progress.part(0.8, 1.0, about="Next lamp: "):
        lines, doubts = report_ball(measured)
    first = measured.photographs[0]
    return BallResult(outcome._replace(measured=outcome.measured._replace(path=path)), content, first.centre,
                      first.intensity, lines, doubts)


@_names_of_panel()
def measure_sample(description: Description, is_tile: bool, chosen: Sequence[EmbeddedFit],
                   how: Arguments) -> SampleResult:
    """Measure the flat sample of a scene's description: a mix of chosen materials, else of those that are found. `how`
    are keyword arguments of `fitter.load`. Raises DatasetError, ValueError."""
    space = how["colours"]
    with progress.part(0.0, 0.3, "Reading"):
        sample = read_sample(_parse(description))
    photographs = [_convert_colours(each, space) for each in sample.photographs]
    fits = [tasks.kept_fit(each) for each in chosen]
    with progress.part(0.3, 0.75):
        maps = maps_from_flat(photographs, sample.corners, sample.shape, fits or sample.number)
    with progress.part(0.75, 0.85, about="Checking: "):
        report = report_sample(maps, photographs, sample.albedo)
    told = *sample.notes, *sample.doubts, *report.lines
    if is_tile:
        with progress.part(0.85, 0.95):
            maps = cut_tile(maps)
        told = *told, tile_size(maps)
    with progress.part(0.95, 1.0):
        outcomes = [] if fits else [tasks.outcome_alone(replace(each, name=f"{sample.name}: {each.name}"), space)
                                    for each in progress.each(maps.fits)]
    masks, brightness, most = map_files.layers(maps.weights)
    first, last = sample.corners[[0, 2], :2]
    return SampleResult(
        sample.name, sample.view, outcomes,
        [(map_files.png(each), float(each.mean())) for each in np.moveaxis(masks, 2, 0)],
        map_files.png(brightness), most, map_files.png(map_files.normal_map(maps)), is_tile,
        (maps.corners[[0, 2], :2] - first) / (last - first),
        told, (*sample.doubts, *report.doubts), {each.name: each.intensity for each in sample.photographs})


def _convert_colours(photograph: FlatPhotograph, space: str) -> FlatPhotograph:
    """A photograph in another colour space: what it shows under a white lamp."""
    if space == DEFAULT_COLOURS or photograph.radiance.shape[2] == 1:
        return photograph
    light = Light(photograph.radiance / photograph.intensity, not_none(photograph.noise) / photograph.intensity,
                  photograph.counts).convert(conversion(DEFAULT_COLOURS, space))
    return replace(photograph, radiance=light.radiance, intensity=np.ones(3), noise=light.noise, mask=light.known)
