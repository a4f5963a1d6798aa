"""The description of photographs in a file: where camera, ball and lamps were, and which file is which.

It is in TOML. Lengths are metres, angles degrees, paths relative to the file. Keys in brackets may be left out ::

    [name] = "red snooker ball"

    [camera]
    position = [0, -1.5, 0.2]       # or "far", where nobody knows how far
    [look_at] = [0, 0, 0]           # by default the ball's centre, or where that is the outline's, the origin
    [direction] = [0, 0, 1]         # of one that is far in the place of it: from the ball toward the camera
    [up] = [0, 0, 1]                # of one that is far [0, 1, 0]: x is to the right in its pictures
    [field_of_view] = 12            # of the width; or focal_length and sensor_width in mm; or of the files' EXIF
    [matrix] = [[...], [...], [...]]    # from the camera's colours to linear Rec.709; or the files' chromaticities
    [encoding] = "linear"           # or "srgb", whatever the files say

    [ball]
    centre = [0, 0, 0]              # or "outline": it is found in the photographs
    radius = 0.026                  # of one that is photographed from afar it does not matter
    [mask] = "mask.png"             # white where pixels count: what is beside the ball need not be masked, but may be

    [chrome]                        # a ball that shows where lamps are; by default one in the place of the other
    [centre] = "outline"            # or [x, y, z]
    [radius] = 0.03
    [mask] = "chrome_mask.png"      # white where this ball is, which says its centre

    [lamp]
    [radius] = 0.02                 # of one that is a ball
    [positions] = "dome.lp"         # light positions, in the place of those of the photographs, or of all of them
    [dark] = "dark.exr"             # a photograph with the lamp off
    [flat] = "flat.exr"             # and one of an evenly bright surface

    [scale]                         # one of these:
    intensity = 3.2                 # the lamp's, W/sr in units of the pictures, of lamps far away as if these were 1 m
                                    # away; or three numbers
    albedo = 0.5                    # of the ball: a guess
    card = {file = "card.exr", albedo = 0.18, normal = [0, -1, 0], lamp = [0, -1, 0.5], region = [200, 180, 260, 240]}
    ball = {file = "white.exr", albedo = 0.9, lamp = [0, -1, 0.5]}

    [[photograph]]
    files = ["a1.exr", "a2.exr"]    # exposures of one lamp
    [exposures] = [0.01, 0.08]      # by default those of EXIF
    lamp = [0.3, -1.1, 0.4]         # or direction = [0.2, -0.9, 0.4], of a lamp far away; or chrome = "a_chrome.exr",
                                    # with distance = 1.2, from the ball's centre, if it is not far away

Light positions (`light_positions`) are directions in the camera's axes; with a camera that is far they say all there is
to say (`descriptions`). A card stands where the ball does, and `region` is the part of its picture that it fills: left,
top, right and bottom, pixels. A file among dark, flat, card, ball and chrome may be a list of exposures as well, with
`exposures` beside it where it has a table of its own.
"""


from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import BoolArray, FloatArray, RealArray
from ..errors import DatasetError, printable
from ..samples import Samples
from . import lamp_scale, viewpoint
from .ball import BallPhotograph, check_bright
from .ball_finding import brightest, disc_of, find_ball
from .descriptions import Description, read, with_paths
from .lamps import KEYS, ChromeBall, alike, lamp_of, with_light_positions
from .light import Light, same_pictures
from .picture_files import read_picture_info
from .pictures import Part, Pictures, mask_of
from .samples import gathered, in_place
from .scale import reflected, scaled, too_bright
from .table import POSITIVE, Table

RADIUS = 0.025              # m, of a ball whose size does not matter


class BallMeasurement(NamedTuple):
    """What photographs measure."""

    samples: Samples
    photographs: list[BallPhotograph]
    """The ball is where its outline is, and the lamp has the intensity that belongs to the samples."""
    doubts: tuple[str, ...]
    """Those of the samples' notes which say that something is wrong."""


class Resolved(NamedTuple):
    """A description in which places are numbers."""

    description: Description
    size: tuple[int, int]
    """Height and width of the photographs, pixels."""


class _Stage(NamedTuple):
    """What all photographs of a description share: metres and radians."""

    view: viewpoint.Viewpoint
    camera: FloatArray
    """Its place, also where it is far."""
    ball: lamp_scale.MeasuredPlace
    mask: BoolArray
    notes: tuple[str, ...]


class _Checked(NamedTuple):
    """A description that has no other keys than it may have, and the photographs that light positions name."""

    table: Table
    description: Description
    notes: tuple[str, ...]


def measure(path: str | Path) -> Samples:
    """The samples that the photographs of a description make: a file of it, light positions, or a folder with either.

    Raises
    ------
    DatasetError
        If the description or a file is wrong; the message names file and key.
    ImportError
        If OpenImageIO is absent.
    """
    return measured(*read(path)).samples


def measured(description: Description, path: str | Path) -> BallMeasurement:
    """The same of a description that has been read, or made elsewhere; errors name the path, and files are beside it.

    Raises as `measure` does.
    """
    checked, path = _checked(description, path), Path(path)
    photographs, notes = _photographs(checked, path)
    name = checked.table.text("name", path.stem)
    photographs = in_place(photographs, name)
    samples = gathered(photographs, name, str(path))
    same = same_pictures([each.radiance for each in photographs], [each.name for each in photographs])
    samples = replace(samples, notes=(*samples.notes, *notes, *same))
    scale = checked.table.table("scale")
    if scale.has("albedo"):
        guessed = scaled(samples, scale.needed("albedo"))
        bright = guessed.notes[len(samples.notes) + 1:]         # after that of the guess
        # what is a guess of the samples' scale is one of the lamp's intensity
        share = float(samples.values.sum() / guessed.values.sum())
        return BallMeasurement(guessed, [replace(each, intensity=each.intensity * share) for each in photographs],
                               (*same, *bright))
    bright = too_bright(reflected(samples))
    return BallMeasurement(replace(samples, notes=(*samples.notes, *bright)), photographs, (*same, *bright))


def photographed(description: Description, path: str | Path) -> list[BallPhotograph]:
    """The photographs of a description, as they are: nothing is checked of what they show. Raises as `measure` does."""
    return _photographs(_checked(description, path), Path(path))[0]


def resolved(description: Description, path: str | Path) -> Resolved:
    """A description with numbers in the place of what its pictures say, as `measured` finds them, and absolute paths.

    The numbers are the camera's place and field of view, what it looks at, the ball's centre and the lamps, and of
    lamps far away their intensity, which is that of where they are put. Raises as `measure` does.
    """
    checked, path = _checked(description, path), Path(path)
    table = checked.table
    pictures = Pictures.from_tables(table.table("camera"), table.table("lamp"))
    lights = lights_of(table.tables("photograph"), pictures, path)
    stage = _stage(table, lights, pictures, path)
    lamps, are_far = _lamps(table, pictures, stage, path)
    view, given = stage.view, checked.description
    camera = {key: value for key, value in given["camera"].items()
              if key not in ("focal_length", "sensor_width", "direction")}
    camera |= {"position": stage.camera.tolist(), "look_at": (stage.camera - view.orientation[:, 2]).tolist(),
               "up": view.orientation[:, 1].tolist(), "field_of_view": float(np.degrees(view.field_of_view))}
    shots = [{key: value for key, value in shot.items() if key not in KEYS} | {"lamp": lamp.tolist()}
             for shot, lamp in zip(given["photograph"], lamps, strict=True)]
    places = {key: value for key, value in given.items() if key != "chrome"} | {
        "name": table.text("name", path.stem), "camera": camera, "photograph": shots,
        "ball": {**given["ball"], "centre": stage.ball.middle.tolist(), "radius": stage.ball.size},
        "lamp": {key: value for key, value in given.get("lamp", {}).items() if key not in ("positions", "distance")},
        "scale": lamp_scale.resolved(table.table("scale"), stage.ball, are_far)}
    return Resolved(with_paths(places, path.parent), view.rays.shape[:2])


def _checked(description: Description, path: str | Path) -> _Checked:
    path = Path(path)
    table = Table(description, "", path).only("name", "camera", "ball", "chrome", "lamp", "scale", "photograph")
    table.table("camera").only(*viewpoint.KEYS)
    ball = table.table("ball").only("centre", "radius", "mask")
    table.table("chrome").only("centre", "radius", "mask")
    table.table("lamp").only("radius", "positions", "distance", "dark", "flat")
    lamp_scale.check(table.table("scale"))
    centre = np.zeros(3) if _is_by_outline(ball) else ball.numbers("centre", 3)
    turn = viewpoint.orientation(table.table("camera"), centre)
    description, notes = with_light_positions(description, path, turn)
    table = Table(description, "", path)
    for each in table.tables("photograph"):
        each.only("files", "exposures", *KEYS)
    return _Checked(table, description, notes)


def _is_by_outline(ball: Table) -> bool:
    return bool(ball.value("centre") == "outline")


def size_of(tables: Sequence[Table], path: Path) -> tuple[int, int]:
    """Height and width of the photographs of tables. Raises DatasetError if they have several."""
    sizes: dict[tuple[int, int], Table] = {}
    for each in tables:
        sizes.setdefault(read_picture_info(each.files("files")[0]).size, each)
    if len(sizes) > 1:
        raise DatasetError("photographs of several sizes found: " + ", ".join(
            f"{name_of(each)} {width} x {height}" for (height, width), each in sizes.items()), path)
    return next(iter(sizes))


def lights_of(tables: Sequence[Table], pictures: Pictures, path: Path, part: Part | None = None,
              reduced: Callable[[Light], Light] = lambda light: light) -> list[Light]:
    """What a part of the photographs of tables shows, each of one size, and is kept of it: they are read one at a time.
    Raises DatasetError if one is black."""
    size_of(tables, path)
    lights = []
    for number, each in enumerate(tables):
        progress.report(number / len(tables), f"Reading {name_of(each)}")
        lights.append(reduced(pictures.of_lamp(each, "files", part)))
        if part is None:
            check_bright(lights[-1].radiance, each.files("files")[0])
    return lights


def name_of(photograph: Table) -> str:
    """The name of a photograph: that of its first file, as terminals can show it."""
    return printable(photograph.files("files")[0].name)


def _stage(table: Table, lights: Sequence[Light], pictures: Pictures, path: Path) -> _Stage:
    ball, camera, (height, width, _) = table.table("ball"), table.table("camera"), lights[0].radiance.shape
    centre = np.zeros(3) if _is_by_outline(ball) else ball.numbers("centre", 3)
    view = viewpoint.viewpoint(camera, pictures.said.values(), (height, width), centre, path)
    mask = mask_of(ball, (height, width))
    radius = ball.number("radius", RADIUS if view.position is None and not _any_is_near(table) else None)
    if radius is None:
        raise ball.error("radius", POSITIVE)
    notes: tuple[str, ...] = ()
    if view.position is None or _is_by_outline(ball):
        outline = find_ball(brightest([light.radiance for light in lights], mask), view.rays, str(path))
        if view.position is None:
            position = centre - outline.centre(np.zeros(3), radius)
            notes = f"The camera is {np.linalg.norm(position - centre):.4g} m away by the ball's outline",
        else:
            position, centre = view.position, outline.centre(view.position, radius)
            notes = "The ball's centre by its outline: {:.4g}, {:.4g}, {:.4g} m".format(*centre),
    else:
        position = view.position
    return _Stage(view, position, lamp_scale.MeasuredPlace(centre, radius),
                  np.ones((height, width), bool) if mask is None else mask, notes)


def _any_is_near(table: Table) -> bool:
    """Whether a lamp has a place, which says how large the ball is beside it."""
    return any(each.has("lamp") or each.has("distance") for each in table.tables("photograph"))


def _lamps(table: Table, pictures: Pictures, stage: _Stage, path: Path) -> tuple[list[FloatArray], bool]:
    """The place of each photograph's lamp, (3,), and whether they are far away."""
    tables = table.tables("photograph")
    shown = [pictures.of_lamp(each, "chrome").radiance if each.has("chrome") else None for each in tables]
    chrome = _chrome_ball(table.table("chrome"), [each for each in shown if each is not None], stage)
    lamps = [lamp_of(each, picture, stage.view, stage.camera, stage.ball.middle, chrome)
             for each, picture in zip(tables, shown, strict=True)]
    return [lamp.at(*stage.ball) for lamp in lamps], alike(lamps, path)


def _chrome_ball(chrome: Table, shown: Sequence[RealArray], stage: _Stage) -> ChromeBall:
    """Where the chrome ball of pictures is, which they show (h, w, channels)."""
    radius = chrome.number("radius", stage.ball.size) or stage.ball.size
    mask = mask_of(chrome, stage.mask.shape)
    if mask is not None:
        outline = disc_of(mask, stage.view.rays, chrome.files("mask")[0].name)
    elif _is_by_outline(chrome) and shown:
        outline = find_ball(brightest(shown), stage.view.rays, f"{chrome.path}: chrome")
    else:
        middle = chrome.numbers("centre", 3, stage.ball.middle.tolist()) if shown else stage.ball.middle
        return ChromeBall(middle, radius)
    return ChromeBall(outline.centre(stage.camera, radius), radius)


def _photographs(checked: _Checked, path: Path) -> tuple[list[BallPhotograph], tuple[str, ...]]:
    """The photographs of a description, and notes of how they were read."""
    table = checked.table
    pictures = Pictures.from_tables(table.table("camera"), table.table("lamp"))
    tables = table.tables("photograph")
    lights = lights_of(tables, pictures, path)
    stage = _stage(table, lights, pictures, path)

    def photograph(light: Light, lamp: FloatArray, intensity: FloatArray, name: str) -> BallPhotograph:
        return BallPhotograph(light.radiance, stage.view.rays, stage.camera, *stage.ball, lamp, intensity,
                              table.table("lamp").number("radius", 0.0) or 0.0, light.noise, stage.mask & light.known,
                              name)

    lamps, are_far = _lamps(table, pictures, stage, path)
    intensity, note = lamp_scale.intensity_of(table.table("scale"), pictures, lights[0].radiance.shape[2], stage.ball,
                                              are_far, photograph)
    photographs = [photograph(light, lamp, intensity, name_of(each))
                   for light, lamp, each in zip(lights, lamps, tables, strict=True)]
    return photographs, (*pictures.notes, *checked.notes, *stage.notes, *note)
