"""A chrome ball beside a flat sample, in its photographs or others, whose highlights say where the lamps are."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from .ball_finding import brightest, disc_of, find_ball
from .camera import places_of, rays_through
from .chrome import Highlight, lamp_of_highlight
from .description.capture_setup import BallSetup, Shot
from .lamps import ChromeBall, Lamp
from .pictures import Part, Pictures, mask_of

_ROOM = 1.2                 # times the ball's radius, around its middle, where it is looked for


class View(NamedTuple):
    """A camera beside a sample, and its pictures."""

    position: FloatArray
    turn: FloatArray
    """The rotation from its axes to the sample's: (3, 3)."""
    size: tuple[int, int]
    """Height and width, pixels."""
    angle: float
    """Of the width, radians."""

    def rays(self, part: Part) -> FloatArray:
        """Directions through the middles of a part's pixels: (h, w, 3)."""
        rows, columns = (np.arange(side)[each] + 0.5 for each, side in zip(part, self.size, strict=True))
        places = np.stack(np.meshgrid(columns, rows), axis=-1)
        return np.asarray(rays_through(places, self.size, self.angle) @ self.turn.T)

    def places(self, points: FloatArray) -> FloatArray:
        """Where points (..., 3) are, pixels from the left and the top: (..., 2)."""
        return places_of((points - self.position) @ self.turn, self.size, self.angle)


def chrome_ball(chrome: BallSetup, shots: Sequence[Shot], pictures: Pictures, view: View) -> ChromeBall:
    """Where the ball is: by its centre; by a mask; or by its outline in pictures of its own. If nothing else is said it
    lies in the sample's plane."""
    mask = mask_of(chrome, view.size)
    if mask is not None:
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        part = slice(max(rows[0] - 2, 0), rows[-1] + 3), slice(max(columns[0] - 2, 0), columns[-1] + 3)
        outline = disc_of(mask[part], view.rays(part), (chrome.mask or ())[0].name)
    elif chrome.centre is not None and not isinstance(chrome.centre, str) and chrome.radius is not None:
        return ChromeBall(chrome.centre, chrome.radius)
    elif all(each.chrome for each in shots):
        outline = find_ball(brightest([pictures.of_lamp(each, "chrome").radiance for each in shots]),
                            view.rays((slice(None), slice(None))), f"{chrome.path}: chrome")
    else:
        raise chrome.error("mask", "that, or centre (3 numbers) and radius")
    lying = float(view.position[2] / (1 - outline.axis[2] / np.sin(outline.half_angle)))
    radius = chrome.radius or lying
    return ChromeBall(outline.centre(view.position, radius), radius)


def lamps_shown(shots: Sequence[Shot], ball: ChromeBall, pictures: Pictures, view: View,
                distance: float | None) -> list[Lamp | None]:
    """The lamps of photographs that show a ball, so far from the sample's middle, if they do not say otherwise, or far
    away; None where there is no highlight."""
    far = float(np.linalg.norm(ball.centre - view.position))
    across = _ROOM * ball.radius / far * view.size[1] / view.angle + 2
    column, row = (slice(max(int(each - across), 0), max(int(each + across) + 1, 0))
                   for each in view.places(ball.centre))
    part = row, column
    found: list[Lamp | None] = []
    for shot in shots:
        key, away = "chrome" if shot.chrome else "files", shot.distance or distance
        light, name = pictures.of_lamp(shot, key, part), getattr(shot, key)[0].name
        try:
            shown = lamp_of_highlight(light.radiance, view.rays(part), view.position, ball.centre, ball.radius, name)
        except DatasetError:
            shown = None
        if shown is None or not shown.direction[2] > 0:     # or what is beside the ball is bright at its rim
            found.append(None)
            continue
        found.append(Lamp(shown.direction, True) if away is None
                     else Lamp(Highlight(shown.point, shown.direction, np.zeros(3)).at(away), False))
    return found
