"""Lamps of a description: where they are, by a place, a direction, or a highlight on a chrome ball, and how bright.

A Lambertian of the albedo rho that faces a lamp at the distance d has the radiance rho I / (pi d^2). So a card or a
painted ball of known albedo tells the radiant intensity I in each channel, in the units of the pictures, and with it
the colour of the lamp and of the camera.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import ArrayLike, BoolArray, FloatArray, RealArray
from ...errors import DatasetError
from ...imaging.picture_files import read_picture_info
from ...quality.albedo import DARKEST_SURFACE
from ..description.capture_setup import BallSetup, CaptureSetup, Known, Shot
from ..pictures import WHOLE, Part, Pictures, bounds, read_mask
from .ball_finding import brightest, disc_outline, find_ball, regions
from .camera import CameraView

FAR = 1e4                   # sizes of what it lights, to a lamp far away, which lights all of it alike to 1e-4
_BRIGHT = 0.5               # of the brightest pixel: what is the lamp's image
_WITHIN = 0.97              # of the ball's radius: pixels at its rim see what is beside it, too
_SPREAD = 0.3               # of the ball's radius, that this image may have
_ANOTHER = 0.5              # of its light, from which another patch is another lamp: less is dust, or a reflection
_ROOM = 1.2                 # times the ball's radius, around its middle, where it is looked for in a sample's pictures
GUESSED = "The scale is a guess: an albedo of {} was given"
NEAR_NORMAL = np.radians(60)    # polar angle up to which real paints are Lambertian enough
SHARE_ANGLES = np.arcsin(np.sqrt((np.arange(6) + 0.5) / 6))     # of equal shares of the light that leaves a Lambertian
_BRIGHTEST = 1.02           # share of the light that a white paint may seem to reflect, by its noise


class MeasuredPlace(NamedTuple):
    """What is measured, or a chrome ball: where it is, (3,), and its size; metres."""

    middle: FloatArray
    size: float


class LampPlace(NamedTuple):
    """A lamp of a description."""

    place: FloatArray   # (3,), metres
    is_far: bool        # whether only its direction is known


class Highlight(NamedTuple):
    """The line from a point of a ball toward the lamp."""

    point: FloatArray       # on the ball: (3,), metres
    direction: FloatArray   # unit vector: (3,)

    def lamp(self, what: MeasuredPlace, distance: float | None) -> LampPlace:
        """The lamp on the line that is so far, metres, or far away, from the middle of what is measured. DatasetError
        if the ball is farther."""
        if distance is None:
            return LampPlace(what.middle + FAR * what.size * self.direction, True)
        off = self.point - what.middle
        if not distance > np.linalg.norm(off):
            raise DatasetError(f"a lamp {distance:g} m from the middle of the ball found, expected more than its "
                               f"radius")
        along = float(off @ self.direction)
        length = np.sqrt(along ** 2 + distance ** 2 - off @ off) - along
        return LampPlace(np.asarray(self.point + self.direction * length), False)


class Scene(NamedTuple):
    """A description in which places are numbers."""

    setup: CaptureSetup     # of lamps far away with the intensity that belongs to where they are put
    view: CameraView
    what: MeasuredPlace     # the ball, or the middle of a sample with its diagonal
    lamps: list[FloatArray]     # of the photographs: (3,) each, metres
    notes: tuple[str, ...]
    is_far: bool            # whether nobody knows how far the camera was
    unit: float             # the radiant intensity that is taken for granted until an albedo tells it, W/sr
    known_place: FloatArray     # of a card or ball of known albedo: (3,), metres


def place_scene(setup: CaptureSetup, view: CameraView, what: MeasuredPlace, lamps: Sequence[LampPlace | None],
                known: MeasuredPlace, notes: tuple[str, ...]) -> Scene:
    """The scene of a description with `what` is measured, its lamps, and the place of a card or ball of `known` albedo;
    photographs whose lamp is None are not in it."""
    found = [(shot, lamp) for shot, lamp in zip(setup.photographs, lamps, strict=True) if lamp is not None]
    is_far = _are_far([lamp for _, lamp in found], setup.path)
    unit, scale = (FAR * what.size) ** 2 if is_far else 1.0, setup.scale
    if scale.intensity is not None:
        scale = replace(scale, intensity=scale.intensity * unit)
    for key in ("card", "ball"):
        if (each := getattr(scale, key)) is not None:
            lamp = place_lamp(each, known)
            _are_far([lamp, lamp._replace(is_far=is_far)], each.path)
            scale = replace(scale, **{key: replace(each, lamp=lamp.place, direction=None)})
    places = [lamp.place for _, lamp in found]
    placed = replace(
        setup, name=setup.title, chrome=None, notes=(), scale=scale, camera=replace(
            setup.camera, position=view.position, look_at=view.position - view.orientation[:, 2],
            up=view.orientation[:, 1], field_of_view=float(np.degrees(view.angle)), direction=None),
        ball=setup.ball and replace(setup.ball, centre=what.middle, radius=what.size),
        lamp=replace(setup.lamp, positions=None, distance=None, ball=None),
        photographs=tuple(replace(shot, lamp=place, direction=None, chrome=None, distance=None)
                          for (shot, _), place in zip(found, places, strict=True)))
    return Scene(placed, view, what, places, notes, setup.camera.is_far, unit, known.middle)


def find_lamps(setup: CaptureSetup, pictures: Pictures, view: CameraView,
               what: MeasuredPlace) -> list[LampPlace | None]:
    """The lamp of each photograph: at its place, in its direction, or where a chrome ball shows it; None where the
    photograph of a flat sample shows none."""
    shots, is_flat = setup.photographs, setup.sample is not None
    turn = view.orientation if setup.lamp.positions else None     # light positions are in the camera's axes
    mirrored = [each for each in shots if each.lamp is None and each.direction is None]
    if not mirrored or (is_flat and len(mirrored) < len(shots)):
        return [place_lamp(each, what, turn, setup.lamp.ball) for each in shots]
    chrome = setup.chrome or BallSetup(where="chrome", path=setup.path)
    if not is_flat:                 # it is in the place of the ball
        chrome = replace(chrome, centre=what.middle if chrome.centre is None else chrome.centre,
                         radius=chrome.radius or what.size)
    ball = _find_chrome_ball(chrome, mirrored, pictures, view)
    part = _part_around(ball, view) if is_flat else None
    rays = view.rays(part or WHOLE)

    def find_lamp(shot: Shot) -> LampPlace | None:
        if shot not in mirrored:
            return place_lamp(shot, what, turn)
        key = "chrome" if shot.chrome else "files"
        light, name = pictures.lamp_light(shot, key, part), getattr(shot, key)[0].name
        try:
            shown = find_highlight(light.radiance, rays, view.position, *ball, name)
        except DatasetError:
            if is_flat:
                return None
            raise
        if not is_flat:
            return shown.lamp(what if shot.distance is None else ball, shot.distance)
        # what is beside it is bright at its rim
        return shown.lamp(what, shot.distance or setup.lamp.distance) if shown.direction[2] > 0 else None

    return [find_lamp(shot) for shot in shots]


def place_lamp(given: Shot | Known, what: MeasuredPlace, turn: FloatArray | None = None,
               ball: FloatArray | None = None) -> LampPlace:
    """The lamp of a photograph that has its place or direction. `turn` (3, 3) is from the axes of the direction to the
    scene's, and the direction holds at `ball` (3,), by default in the middle of what is measured."""
    if given.lamp is not None:
        return LampPlace(given.lamp, False)
    if given.direction is None:
        raise given.error("lamp", "a position, or instead of it a direction")
    direction = given.direction if turn is None else turn @ given.direction
    distance = given.distance if isinstance(given, Shot) else None
    return Highlight(what.middle if ball is None else ball, direction).lamp(what, distance)


def _are_far(lamps: Sequence[LampPlace], path: Path) -> bool:
    """Whether the lamps of photographs, one or more, are far. DatasetError if some are, and others are not: it is not
    known then how bright they are beside each other."""
    if len({lamp.is_far for lamp in lamps}) > 1:
        raise DatasetError("some lamps have a place, and some only a direction, expected the same of all: give chrome "
                           "balls their distance, or places in the place of directions", path)
    return lamps[0].is_far


def _find_chrome_ball(chrome: BallSetup, shots: Sequence[Shot], pictures: Pictures, view: CameraView) -> MeasuredPlace:
    """Where the ball is: by a mask; by its centre; or by its outline in pictures of its own. If its radius is not said
    it lies in the plane z = 0."""
    mask = read_mask(chrome, view.size)
    if mask is not None:
        part = bounds(mask, 2)
        outline = disc_outline(mask[part], view.rays(part), (chrome.mask or ())[0].name)
    elif chrome.place is not None and chrome.radius is not None:
        return MeasuredPlace(chrome.place, chrome.radius)
    elif all(each.chrome for each in shots):
        outline = find_ball(brightest([pictures.lamp_light(each, "chrome").radiance for each in shots]), view.rays(),
                            f"{chrome.path}: chrome")
    else:
        raise chrome.error("mask", "that, or centre (3 numbers) and radius")
    radius = chrome.radius or float(view.position[2] / (1 - outline.axis[2] / np.sin(outline.half_angle)))
    return MeasuredPlace(outline.centre(view.position, radius), radius)


def _part_around(ball: MeasuredPlace, view: CameraView) -> Part:
    """The rows and columns of pictures that have a ball."""
    across = _ROOM * ball.size / float(np.linalg.norm(ball.middle - view.position)) * view.size[1] / view.angle + 2
    columns, rows = (slice(max(int(each - across), 0), max(int(each + across) + 1, 0))
                     for each in view.project(ball.middle))
    return rows, columns


def find_highlight(radiance: RealArray, rays: FloatArray, camera: ArrayLike, centre: ArrayLike, radius: float,
                   name: str = "photograph") -> Highlight:
    """The line to a lamp whose image a chrome ball shows.

    Its image is the largest bright patch of the radiance, (height, width, channels), which may be saturated. Raises
    DatasetError if the ball is not in the picture, is dark, or shows more than one lamp.
    """
    camera, centre = (np.asarray(place, dtype=float) for place in (camera, centre))
    axis = centre - camera
    nearest = rays @ axis
    miss = np.linalg.norm(axis - nearest[..., None] * rays, axis=-1)
    grey = np.where((miss < _WITHIN * radius) & (nearest > 0), radiance.mean(axis=2), 0.0)
    if not grey.max() > 0:
        raise DatasetError("no highlight found: the chrome ball is not in the picture, or dark", name)
    bright = _largest_patch(np.where(grey >= _BRIGHT * grey.max(), grey, 0.0), name)
    ray = np.average(rays[bright], axis=0, weights=grey[bright])
    ray /= np.linalg.norm(ray)
    spread = np.linalg.norm(rays[bright] - ray, axis=1).max() * np.linalg.norm(axis)
    if spread > _SPREAD * radius:
        raise DatasetError("a highlight as large as the chrome ball found: it is dark, or reflects the room", name)
    along = float(ray @ axis)
    point = camera + ray * (along - np.sqrt(max(radius ** 2 - axis @ axis + along ** 2, 0.0)))
    normal = (point - centre) / radius
    return Highlight(point, ray - 2 * (ray @ normal) * normal)


def _largest_patch(grey: FloatArray, name: str) -> BoolArray:
    """The pixels above 0 that touch and have most light: (height, width)."""
    there = grey > 0
    part = bounds(there)
    first, *others = sorted(regions(there[part]), key=lambda each: -float(grey[part][each].sum()))
    if others and grey[part][others[0]].sum() > _ANOTHER * grey[part][first].sum():
        raise DatasetError("more than one highlight found on the chrome ball", name)
    found = np.zeros_like(there)
    found[part] = first
    return found


def lamp_intensity(scene: Scene, pictures: Pictures, channels: int) -> tuple[FloatArray, tuple[str, ...]]:
    """The radiant intensity of the lamps of a scene, (channels,), W/sr in units of the pictures, and a note of where it
    is from; until an albedo tells it the one that is taken for granted."""
    scale, given = scene.setup.scale, pictures.setup.scale
    if scale.intensity is not None:
        if scale.intensity.ndim and len(scale.intensity) != channels:
            raise given.error("intensity", f"a number above 0, or {channels}")
        return np.ones(channels) * scale.intensity, ("The lamp's intensity as it was given",)
    known = scale.ball or scale.card
    if known is not None and known.albedo.ndim and len(known.albedo) != channels:
        raise known.error("albedo", f"a number above 0, or {channels}")
    if scale.card is None:
        return np.full(channels, scene.unit), ("Colours are those that the lamp and the camera give",)
    card = scale.card
    assert card.lamp is not None
    assert card.normal is not None
    return (intensity_of_card(_read_region(card, pictures), scene.known_place, card.normal, card.lamp, card.albedo,
                              card.file[0]), ("Scale and colour by a card of known albedo",))


def _read_region(card: Known, pictures: Pictures) -> FloatArray:
    """The radiance of the pixels that a card fills: (n, channels)."""
    height, width = read_picture_info(card.file[0]).size
    left, top, right, bottom = (0, 0, 0, 0) if card.region is None else card.region.astype(int).tolist()
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        raise card.error("region", f"left, top, right and bottom within {width} x {height} pixels")
    light = pictures.lamp_light(card, "file", (slice(top, bottom), slice(left, right)))
    part = light.radiance[light.known]
    if not len(part):
        raise DatasetError("the card is saturated", card.file[0])
    return np.asarray(part)


def intensity_of_card(radiance: ArrayLike, point: ArrayLike, normal: ArrayLike, lamp: ArrayLike, albedo: ArrayLike,
                      name: str | Path) -> FloatArray:
    """The intensity of a lamp whose light is seen on a card in pixels of this radiance, (..., channels): (channels,),
    W/sr in the units of the radiance.

    The point is where the card is, the normal where it faces, the albedo .18 of a grey one, or one for each channel.
    Raises DatasetError, of the file `name`, if the lamp does not light the card, or the card is dark.
    """
    away, normal, values = np.subtract(lamp, point), np.asarray(normal), np.asarray(radiance, dtype=float)
    distance, length = np.linalg.norm(away), np.linalg.norm(normal)
    cosine = away @ normal / (distance * length) if distance * length else 0.0
    if cosine <= 0:
        raise DatasetError("the card does not face the lamp", name)
    return check_intensity(np.pi * values.reshape(-1, values.shape[-1]).mean(axis=0) * distance ** 2
                           / (np.asarray(albedo) * cosine), "card", name)


def check_intensity(intensity: FloatArray, what: str, name: str | Path) -> FloatArray:
    """An intensity by what has a known albedo. DatasetError, of a file or its name, where that was dark."""
    if not (intensity > 0).all():
        raise DatasetError(f"the {what} of known albedo is dark in a channel", name)
    return np.asarray(intensity)


def implausible_light(light: FloatArray, albedo: float | None = None) -> tuple[str, ...]:
    """A note where more is reflected than arrives, (angles, channels), or next to nothing; `albedo` is the one that was
    given."""
    upright = SHARE_ANGLES < NEAR_NORMAL            # what grazes is a guess
    most = light[upright].max()
    if DARKEST_SURFACE <= most <= _BRIGHTEST:
        return ()
    why = "the lamp's intensity, a card's albedo or a distance is wrong"
    if most < DARKEST_SURFACE:
        why = why if albedo is None else "was the albedo meant that was given?"
        return f"Only {most:.2g} of the light leaves, less than of the blackest paints: {why}",
    angle = np.degrees(SHARE_ANGLES[upright][light[upright].max(axis=1).argmax()])
    why = why if albedo is None else f"an albedo of {albedo / most:.2g} is the largest that it can have"
    return f"More light leaves than arrives, {most:.3g} of it at {angle:.0f} degrees: {why}",
