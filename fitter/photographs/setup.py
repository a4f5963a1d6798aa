"""Photographs of a ball as a description says they were taken: `measured` reads, places and gathers them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .. import progress
from ..arrays import BoolArray, FloatArray, RealArray
from ..errors import DatasetError
from ..samples import Samples
from . import lamp_scale, viewpoint
from .ball import BallPhotograph, check_bright
from .ball_finding import brightest, disc_of, find_ball
from .capture_setup import BallSetup, CaptureSetup, Shot
from .lamps import ChromeBall, Lamp, alike, mirrored_lamp, placed_lamp
from .light import Light, same_pictures
from .picture_files import read_picture_info
from .pictures import Part, Pictures, mask_of
from .samples import gathered, in_place
from .scale import implausible_light, reflected, scaled

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

    setup: CaptureSetup
    size: tuple[int, int]
    """Height and width of the photographs, pixels."""
    is_far: bool = False
    """Whether nobody knows how far the camera was."""


class _Stage(NamedTuple):
    """What all photographs of a description share: metres and radians."""

    view: viewpoint.Viewpoint
    camera: FloatArray
    """Its place, also where it is far."""
    ball: lamp_scale.MeasuredPlace
    mask: BoolArray
    notes: tuple[str, ...]


def measured(setup: CaptureSetup) -> BallMeasurement:
    """The samples that the photographs of a description make.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    photographs, notes = _photographs(setup)
    photographs = in_place(photographs, setup.title)
    samples = gathered(photographs, setup.title, str(setup.path))
    same = same_pictures([each.radiance for each in photographs], [each.name for each in photographs])
    samples = replace(samples, notes=(*samples.notes, *notes, *same))
    if setup.scale.albedo is not None:
        guessed = scaled(samples, setup.scale.albedo)
        bright = guessed.notes[len(samples.notes) + 1:]         # after that of the guess
        # what is a guess of the samples' scale is one of the lamp's intensity
        share = float(samples.values.sum() / guessed.values.sum())
        return BallMeasurement(guessed, [replace(each, intensity=each.intensity * share) for each in photographs],
                               (*same, *bright))
    bright = implausible_light(reflected(samples))
    return BallMeasurement(replace(samples, notes=(*samples.notes, *bright)), photographs, (*same, *bright))


def photographed(setup: CaptureSetup) -> list[BallPhotograph]:
    """The photographs of a description, as they are: nothing is checked of what they show. Raises as `measured`."""
    return _photographs(setup)[0]


def resolved(setup: CaptureSetup) -> Resolved:
    """A description with numbers in the place of what its pictures say, as `measured` finds them.

    The numbers are the camera's place and field of view, what it looks at, the ball's centre and the lamps, and of
    lamps far away their intensity, which is that of where they are put. Raises as `measured` does.
    """
    pictures = Pictures(setup.camera, setup.lamp)
    stage = _stage(setup, lights_of(setup, pictures), pictures)
    lamps, are_far = _lamps(setup, pictures, stage)
    view = stage.view
    return Resolved(replace(
        setup, name=setup.title, chrome=None, notes=(), camera=replace(
            setup.camera, position=stage.camera, look_at=stage.camera - view.orientation[:, 2],
            up=view.orientation[:, 1], field_of_view=float(np.degrees(view.field_of_view)), direction=None),
        ball=replace(setup.of_ball(), centre=stage.ball.middle, radius=stage.ball.size),
        lamp=replace(setup.lamp, positions=None, distance=None),
        scale=lamp_scale.resolved(setup.scale, stage.ball, are_far),
        photographs=tuple(replace(shot, lamp=lamp, direction=None, chrome=None, distance=None)
                          for shot, lamp in zip(setup.photographs, lamps, strict=True))), view.rays.shape[:2],
        setup.camera.is_far)


def size_of(setup: CaptureSetup) -> tuple[int, int]:
    """Height and width of the photographs. Raises DatasetError if they have several."""
    sizes: dict[tuple[int, int], Shot] = {}
    for each in setup.photographs:
        sizes.setdefault(read_picture_info(each.files[0]).size, each)
    if len(sizes) > 1:
        raise DatasetError("photographs of several sizes found: " + ", ".join(
            f"{each.name} {width} x {height}" for (height, width), each in sizes.items()), setup.path)
    return next(iter(sizes))


def lights_of(setup: CaptureSetup, pictures: Pictures, part: Part | None = None,
              reduced: Callable[[Light], Light] = lambda light: light) -> list[Light]:
    """What a part of the photographs shows, each of one size, and is kept of it: they are read one at a time. Raises
    DatasetError if one is black."""
    size_of(setup)
    lights = []
    for number, each in enumerate(setup.photographs):
        progress.report(number / len(setup.photographs), f"Reading {each.name}")
        lights.append(reduced(pictures.of_lamp(each, "files", part)))
        if part is None:
            check_bright(lights[-1].radiance, each.files[0])
    return lights


def _stage(setup: CaptureSetup, lights: Sequence[Light], pictures: Pictures) -> _Stage:
    ball, (height, width, _) = setup.of_ball(), lights[0].radiance.shape
    centre = np.zeros(3) if ball.centre is None or isinstance(ball.centre, str) else ball.centre
    view = viewpoint.viewpoint(setup.camera, pictures.said.values(), (height, width), centre)
    mask, radius = mask_of(ball, (height, width)), ball.radius or RADIUS
    notes: tuple[str, ...] = ()
    if view.position is None or ball.is_by_outline:
        outline = find_ball(brightest([light.radiance for light in lights], mask), view.rays, str(setup.path))
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


def _lamps(setup: CaptureSetup, pictures: Pictures, stage: _Stage) -> tuple[list[FloatArray], bool]:
    """The place of each photograph's lamp, (3,), and whether they are far away."""
    shown = {number: pictures.of_lamp(each, "chrome").radiance for number, each in enumerate(setup.photographs)
             if each.chrome}
    turn = stage.view.orientation if setup.is_by_light_positions else None
    lamps: list[Lamp] = []
    if shown:
        chrome = _chrome_ball(setup.chrome or BallSetup(), [*shown.values()], stage, setup.path)
    for number, each in enumerate(setup.photographs):
        lamps.append(mirrored_lamp(each, shown[number], stage.view, stage.camera, chrome) if number in shown
                     else placed_lamp(each, stage.ball.middle, turn))
    return [lamp.at(*stage.ball) for lamp in lamps], alike(lamps, setup.path)


def _chrome_ball(chrome: BallSetup, shown: Sequence[RealArray], stage: _Stage, path: Path) -> ChromeBall:
    """Where the chrome ball of pictures is, which they show (h, w, channels)."""
    radius, mask = chrome.radius or stage.ball.size, mask_of(chrome, stage.mask.shape)
    if mask is not None:
        outline = disc_of(mask, stage.view.rays, (chrome.mask or ())[0].name)
    elif chrome.is_by_outline:
        outline = find_ball(brightest(shown), stage.view.rays, f"{path}: chrome")
    else:
        centre = chrome.centre
        return ChromeBall(stage.ball.middle if centre is None or isinstance(centre, str) else centre, radius)
    return ChromeBall(outline.centre(stage.camera, radius), radius)


def _photographs(setup: CaptureSetup) -> tuple[list[BallPhotograph], tuple[str, ...]]:
    """The photographs of a description, and notes of how they were read."""
    pictures = Pictures(setup.camera, setup.lamp)
    lights = lights_of(setup, pictures)
    stage = _stage(setup, lights, pictures)

    def photograph(light: Light, lamp: FloatArray, intensity: FloatArray, name: str) -> BallPhotograph:
        return BallPhotograph(light.radiance, stage.view.rays, stage.camera, *stage.ball, lamp, intensity,
                              setup.lamp.radius, light.noise, stage.mask & light.known, name)

    lamps, are_far = _lamps(setup, pictures, stage)
    intensity, note = lamp_scale.intensity_of(setup.scale, pictures, lights[0].radiance.shape[2], stage.ball, are_far,
                                              photograph)
    photographs = [photograph(light, lamp, intensity, each.name)
                   for light, lamp, each in zip(lights, lamps, setup.photographs, strict=True)]
    return photographs, (*pictures.notes, *setup.notes, *stage.notes, *note)
