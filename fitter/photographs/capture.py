"""A description with numbers in the place of what its pictures say."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .ball.measuring import locate_ball
from .description.capture_setup import CaptureSetup
from .flat.reading import locate_sample
from .pictures.reading import Pictures
from .rig.lamps import are_far
from .rig.scale import resolve_scale


class Resolved(NamedTuple):
    """A description in which places are numbers."""

    setup: CaptureSetup
    size: tuple[int, int]   # height and width of the photographs, pixels
    is_far: bool = False    # whether nobody knows how far the camera was


def resolve(setup: CaptureSetup) -> Resolved:
    """A description with the camera's place and field of view, what it looks at, the ball's centre and the lamps, as
    they are measured with; of lamps far away with the intensity that belongs to where they are put.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    pictures = Pictures(setup)
    scene = (locate_sample(setup, pictures) if setup.ball is None
             else locate_ball(setup, pictures, pictures.read_photographs()))
    view, what = scene.view, scene.what
    return Resolved(replace(
        setup, name=setup.title, chrome=None, notes=(), camera=replace(
            setup.camera, position=view.position, look_at=view.position - view.orientation[:, 2],
            up=view.orientation[:, 1], field_of_view=float(np.degrees(view.angle)), direction=None),
        ball=setup.ball and replace(setup.ball, centre=what.middle, radius=what.size),
        lamp=replace(setup.lamp, positions=None, distance=None, ball=None),
        scale=resolve_scale(scene.scale, scene.lit, are_far(scene.lamps, setup.path)),
        photographs=tuple(replace(shot, lamp=lamp.place(*what), direction=None, chrome=None, distance=None)
                          for shot, lamp in zip(scene.shots, scene.lamps, strict=True))), view.size,
        setup.camera.is_far)
