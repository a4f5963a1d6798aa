"""Photographs of a flat sample as a description says they were taken.

The lens is without distortion. The camera's place follows from the corners of a rectangle (three unknowns of its place;
its turn is that which brings four rays closest to them: W. Kabsch, Acta Crystallographica A32, 1976).
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray
from ..errors import DatasetError
from ..least_squares import damped_step, levenberg_marquardt
from . import lamp_scale, viewpoint
from .ball import saturated
from .camera import pixel_angle, rays_through
from .description.capture_setup import (
    MOST_TEXELS,
    BallSetup,
    CameraSetup,
    CaptureSetup,
    LampSetup,
    SampleSetup,
    ScaleSetup,
    Shot,
)
from .flat import frame_of, pixels_of, points_of, texel_corners
from .flat_chrome import View, chrome_ball, lamps_shown
from .flat_judging import lamp_brightness
from .flat_photograph import FlatPhotograph, corners_of, interpolate_bilinear, observed, pixel_of, texel_means
from .lamp_scale import MeasuredPlace
from .lamps import Lamp, alike, placed_lamp
from .light import Light, same_pictures
from .picture_files import read_picture_info
from .pictures import Part, Pictures, mask_of
from .scale import GUESSED
from .setup import Resolved, lights_of, size_of

_DEFAULT_TEXELS = 1024      # along the width
_OFF = 3.0                  # pixels that a corner may be off: an edge is found within one by hand
_BESIDE = 32                # pixels that are kept around the sample
_MANY, _ROOM = 4, 1 << 22   # pixels of a texel along both axes whose mean is kept; of a part that is kept as it is
_EDGE = 1.5                 # pixels from the sample's edge, within which they see what is beside it too
_MEASURED = 0.02            # of its distance, by which a camera's place may be wrong that somebody has measured
_ROUNDS = 40                # toward the camera's place; it takes 10
_GUESSED = 32, 32           # points of a sample whose albedo is a guess


class Flat(NamedTuple):
    """What `maps_from_flat` takes of a description."""

    name: str
    photographs: list[FlatPhotograph]
    corners: FloatArray
    shape: tuple[int, int]
    materials: tuple[Path, ...]
    """Files; empty where these are to be found."""
    number: int | None
    """How many there are then, where that is known."""
    notes: tuple[str, ...]
    doubts: tuple[str, ...]
    """What is wrong with the photographs, in words."""
    albedo: float | None
    """That was guessed."""


class _Pose(NamedTuple):
    """A camera beside a sample."""

    position: FloatArray
    turn: FloatArray
    """The rotation from its axes to the sample's: (3, 3)."""
    off: FloatArray
    """By how much the corners' rays miss them: (4, 3), radians."""

    def pixels_off(self, view: View) -> float:
        """The same of the worst, pixels."""
        return float(np.linalg.norm(self.off, axis=1).max() / (2 * np.tan(view.angle / 2) / view.size[1]))


class _Scene(NamedTuple):
    """A sample and a camera, before what the pictures show is read."""

    pictures: Pictures
    sample: SampleSetup
    places: FloatArray
    """The corners in the pictures: (4, 2)."""
    whole: FloatArray
    """And where they are: (4, 3)."""
    pose: _Pose
    view: View

    @property
    def length(self) -> float:
        """The sample's diagonal."""
        return float(np.hypot(self.sample.width, self.sample.height))


def flat(setup: CaptureSetup) -> Flat:
    """The photographs of a flat sample that a description shows.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    pictures, sample, places, whole, pose, view = scene = _scene(setup)
    shape = _shape(setup, places, sample.height / sample.width)
    window = _Window.enclosing(view, whole, places, shape, mask_of(sample, view.size))
    lights, notes = lights_of(setup, pictures, window.part, window.reduced), setup.notes
    lamps, shots, note = _lamps_and_photographs(setup, pictures, view)
    notes += note
    lights = [light for light, shot in zip(lights, setup.photographs, strict=True) if shot in shots]
    are_far = alike(lamps, setup.path)
    scale, what = _scale(setup.scale, view, scene.length)
    intensity, note = lamp_scale.intensity_of(scale, pictures, lights[0].radiance.shape[2], what, are_far)
    toward = window.toward
    if window.corners is None:
        lights = _without_rim(lights, toward, pose, np.array([sample.width, sample.height]) / 2)
    photographs = [FlatPhotograph(light.radiance, toward, pose.position, each.at(np.zeros(3), scene.length), intensity,
                                  light.noise, light.known, shot.name)
                   for light, each, shot in zip(lights, lamps, shots, strict=True)]
    frame = frame_of(whole, photographs)    # lamps are not behind it
    brightness = _brightness(setup, photographs, whole, frame)
    if brightness is not None:
        photographs = [replace(each, intensity=each.intensity * by) for each, by in zip(photographs, brightness,
                                                                                        strict=True)]
        notes += f"The lamps differ in brightness from {brightness.min():.2f} to {brightness.max():.2f}",
    if scale.albedo is not None:
        share = _albedo(photographs, whole) / scale.albedo
        photographs = [replace(each, intensity=each.intensity * share) for each in photographs]
        note = GUESSED.format(f"{scale.albedo:g}"), *note
    where = "The camera is at {:.4g}, {:.4g}, {:.4g} m by the corners, which are within {:.1f} pixels".format(
        *pose.position, scene.pose.pixels_off(view))
    files, number = (setup.materials, None) if isinstance(setup.materials, tuple) else ((), setup.materials)
    return Flat(setup.title, photographs, whole, shape, files, number, (*pictures.notes, *notes, where, *note),
                same_pictures([light.radiance for light in lights], [each.name for each in photographs]), scale.albedo)


def resolved(setup: CaptureSetup) -> Resolved:
    """A description with numbers in the place of what its pictures say, as `flat` finds them: the camera's place, what
    it looks at, its field of view, and the lamps. Raises as `flat` does."""
    scene = _scene(setup)
    pose, view = scene.pose, scene.view
    lamps, shots, _ = _lamps_and_photographs(setup, scene.pictures, view)
    _check_count(setup.lamp, len(shots))
    scale, what = _scale(setup.scale, view, scene.length)
    return Resolved(replace(
        setup, name=setup.title, chrome=None, notes=(), camera=replace(
            setup.camera, position=pose.position, look_at=pose.position - pose.turn[:, 2], up=pose.turn[:, 1],
            field_of_view=float(np.degrees(view.angle))),
        lamp=replace(setup.lamp, positions=None, distance=None, ball=None),
        scale=lamp_scale.resolved(scale, what, alike(lamps, setup.path)),
        photographs=tuple(replace(shot, lamp=lamp.at(np.zeros(3), scene.length), direction=None, chrome=None,
                                  distance=None) for shot, lamp in zip(shots, lamps, strict=True))), view.size,
        setup.camera.is_far)


def _scene(setup: CaptureSetup) -> _Scene:
    sample, size = setup.need_sample(), size_of(setup)
    places = places_of(sample, size)
    x, y = sample.width / 2, sample.height / 2
    whole = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
    angle = viewpoint.field_of_view(setup.camera, (read_picture_info(each.files[0]) for each in setup.photographs))
    pose = _pose(setup.camera, rays_through(places, size, angle), whole, angle / size[1])
    view = View(pose.position, pose.turn, size, angle)
    if (off := pose.pixels_off(view)) > _OFF:
        raise sample.error("corners", f"those of a rectangle of {2 * x:g} x {2 * y:g} m that this lens sees, within "
                                      f"{_OFF:g} pixels: one is {off:.1f} off")
    return _Scene(Pictures(setup.camera, setup.lamp), sample, places, whole, pose, view)


def _lamps_and_photographs(setup: CaptureSetup, pictures: Pictures,
                           view: View) -> tuple[list[Lamp], list[Shot], tuple[str, ...]]:
    """The lamps, photographs but those whose chrome ball shows none, and notes."""
    found = _lamps(setup, pictures, view)
    lamps = [each for each in found if each is not None]
    if not lamps:
        raise setup.error("chrome", "a ball that shows the lamp in some photograph")
    missing = [each.name for each, one in zip(setup.photographs, found, strict=True) if one is None]
    return (lamps, [each for each, one in zip(setup.photographs, found, strict=True) if one is not None],
            (f"Left out, for the chrome ball shows no lamp there: {', '.join(missing)}",) if missing else ())


def _brightness(setup: CaptureSetup, photographs: list[FlatPhotograph], corners: FloatArray,
                frame: FloatArray) -> FloatArray | None:
    """How bright the lamps are beside what is given: (p, 1 or channels); None where they are alike."""
    given = setup.lamp.brightness
    if given is None:
        return None
    if isinstance(given, str):
        return lamp_brightness(observed(photographs, points_of(corners, _GUESSED), frame[2]), frame)
    _check_count(setup.lamp, len(photographs))
    return given[:, None]


def _check_count(lamp: LampSetup, count: int) -> None:
    given = lamp.brightness
    if given is not None and not isinstance(given, str) and len(given) != count:
        raise lamp.error("brightness", f"{count} numbers")


def _lamps(setup: CaptureSetup, pictures: Pictures, view: View) -> list[Lamp | None]:
    """The lamps of photographs, or where these do not say them by a chrome ball in them; None where that shows none."""
    shots = setup.photographs
    if all(each.lamp is None and each.direction is None for each in shots):
        ball = chrome_ball(setup.chrome or BallSetup(where="chrome", path=setup.path), shots, pictures, view)
        return lamps_shown(shots, ball, pictures, view, setup.lamp.distance)
    turn = view.turn if setup.is_by_light_positions else None
    return [placed_lamp(each, np.zeros(3), turn, setup.lamp.ball) for each in shots]


def corners_natural_order(corners: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Corners in the order of a description, (4, 2), in pixels of a picture of this height and width.

    They are given in any order, as `to_pixels` takes places. What is lowest there is the sample's lower edge.
    """
    off = corners - corners.mean(axis=0)
    around = corners[np.argsort(np.arctan2(off[:, 1], off[:, 0]))]
    # the edges from the first to the second and from the fourth to the third run to the right
    turned = [np.roll(around, -first, axis=0) for first in range(4)]
    best = max(turned, key=lambda each: float((each[1] - each[0] + each[2] - each[3])[0]))
    return to_pixels(best, size)


def to_pixels(places: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Places from the middle of a picture to the right and upward, shares of its longer side, (n, 2): pixels from the
    left and the top of the picture, which has this height and width."""
    return np.asarray(np.array(size[::-1]) / 2 + max(size) * places * (1, -1))


def places_of(sample: SampleSetup, size: tuple[int, int]) -> FloatArray:
    """The corners in the pictures, (4, 2), which run counter-clockwise there."""
    places = sample.corners
    if places is None:
        raise sample.error("corners", "four places of two numbers, pixels from the left and the top")
    if not ((places >= 0) & (places <= size[::-1])).all():
        raise sample.error("corners", f"four places in pictures of {size[1]} x {size[0]} pixels: the sample is not "
                                      f"whole in them")
    sides = np.roll(places, -1, axis=0) - places
    (a, b), (c, d) = np.roll(sides, 1, axis=0).T, sides.T
    turns = a * d - b * c
    if (turns > 0).all():
        raise sample.error("corners", "them counter-clockwise: bottom left, bottom right, top right, top left")
    if not (turns < 0).all():
        raise sample.error("corners", "them one after the other around the sample: they are crossed")
    return places


def _pose(camera: CameraSetup, toward: FloatArray, corners: FloatArray, pixel: float) -> _Pose:
    """Where a camera is that sees the corners (4, 3) in the directions (4, 3) of its own axes; `pixel` is an angle."""
    spread = np.linalg.norm(toward - toward.mean(axis=0), axis=1).sum()
    distance = float(np.linalg.norm(corners, axis=1).sum() / spread)
    given = camera.position
    if isinstance(given, str):
        return _aim_camera(np.array([0, 0, distance]), toward, corners)
    if given is not None and not given[2] > 0:
        raise camera.error("position", "one above the sample, z more than 0")
    tilts = [(0.0, 0.0), (0.6, 0.0), (-0.6, 0.0), (0.0, 0.6), (0.0, -0.6)]
    starts = [given] if given is not None else [distance * np.array([a, b, np.sqrt(1 - a * a - b * b)])
                                                for a, b in tilts]

    def miss(position: FloatArray) -> FloatArray:
        off = _aim_camera(position, toward, corners).off.ravel() / pixel
        return off if given is None else np.append(off, (position - given) / (_MEASURED * np.linalg.norm(given)))

    ends = [end for start in starts if (end := _descended(miss, start))[2] > 0]
    return _aim_camera(min(ends or starts, key=lambda end: float((miss(end) ** 2).sum())), toward, corners)


def _descended(miss: Callable[[FloatArray], FloatArray], position: FloatArray) -> FloatArray:
    """Where the least squares of what a function misses are, near a position."""
    def evaluate(place: FloatArray) -> tuple[float, FloatArray]:
        off = miss(place)
        return float(off @ off), off

    def linearise(place: FloatArray, off: FloatArray) -> Callable[[float], FloatArray]:
        step = 1e-6 * float(np.linalg.norm(place))
        slope = np.stack([(miss(place + step * axis) - off) / step for axis in np.eye(3)], axis=1)
        return lambda damping: place - damped_step(slope.T @ slope, slope.T @ off, damping)

    return levenberg_marquardt(position, evaluate, linearise, steps=_ROUNDS, tries=8, grow=10, shrink=10, enough=0,
                               damping=1e-3)[0]


def _aim_camera(position: FloatArray, toward: FloatArray, corners: FloatArray) -> _Pose:
    """A camera at this position, turned so that its rays miss the corners least."""
    there = corners - position
    there /= np.linalg.norm(there, axis=1, keepdims=True)
    u, _, v = np.linalg.svd(there.T @ toward)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
    return _Pose(position, turn, toward @ turn.T - there)


def _without_rim(lights: list[Light], toward: FloatArray, pose: _Pose, half: FloatArray) -> list[Light]:
    """The same, but pixels that see the sample's edge, or what is right beside it, have what is seen as far within it.

    `half` is of the sample's width and height. Copies of one pixel would look saturated, mirror images do not.
    """
    step = _EDGE * pixel_angle(toward) * float(pose.position @ pose.position) / pose.position[2]
    seen = (pose.position - toward * (pose.position[2] / np.minimum(toward[..., 2:], -1e-9)))[..., :2]
    within = np.clip(seen, *(sign * np.maximum(half - step, 0) for sign in (-1, 1)))
    rim = (seen != within).any(axis=2) & (np.abs(seen - within) < 2 * step).all(axis=2)
    there = np.column_stack([(2 * within - seen)[rim], np.zeros(int(rim.sum()))]) - pose.position
    place = pixel_of(toward, there / np.linalg.norm(there, axis=1, keepdims=True))
    corner, share, _ = corners_of(place, rim.shape)
    filled = []
    for light in lights:
        radiance, noise, known = light.radiance.copy(), light.noise.copy(), light.known.copy()
        radiance[rim], noise[rim] = (interpolate_bilinear(each, corner, share) for each in light[:2])
        known[rim] = interpolate_bilinear(light.known[..., None].astype(float), corner, share)[:, 0] > 1 - 1e-9
        filled.append(Light(radiance, noise, known))
    return filled


class _Window(NamedTuple):
    """What is kept of photographs: a part of their pixels, or where texels are larger the means of these."""

    part: Part
    toward: FloatArray
    """The directions in which pixels or texels are seen: (h, w, 3)."""
    mask: BoolArray | None
    """Of the pixels of the part that count."""
    corners: FloatArray | None = None
    """The corners of texels, rows and columns of the part's pixels: (h + 1, w + 1, 2)."""
    pixels: int = 1
    """Pixels of a texel along both axes."""

    @classmethod
    def enclosing(cls, view: View, whole: FloatArray, places: FloatArray, shape: tuple[int, int],
           mask: BoolArray | None) -> "_Window":
        """Of pictures in which the corners `whole` (4, 3) of a sample are at these places, (4, 2)."""
        first, last = np.floor(places.min(axis=0)) - _BESIDE, np.ceil(places.max(axis=0)) + _BESIDE
        columns, rows = (slice(max(int(a), 0), min(int(b), side))
                         for a, b, side in zip(first, last, view.size[::-1], strict=True))
        part, count = (rows, columns), pixels_of(places, shape)
        mask = None if mask is None else mask[part]
        if count < _MANY and (count == 1 or (rows.stop - rows.start) * (columns.stop - columns.start) < _ROOM):
            return cls(part, view.rays(part), mask)
        # what is right beside the sample's edge gets into the pixels there
        sides = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
        corners = view.places(texel_corners(whole, shape, _EDGE / sides[[1, 3]].min(), _EDGE / sides[[0, 2]].min()))
        toward = points_of(whole, shape).reshape(*shape, 3) - view.position
        toward /= np.linalg.norm(toward, axis=2, keepdims=True)
        return cls(part, toward[::-1], mask, corners[::-1, :, ::-1] - (rows.start + 0.5, columns.start + 0.5), count)

    def reduced(self, light: Light) -> Light:
        """What is kept of a part's light."""
        if self.mask is not None:
            light = light._replace(known=light.known & self.mask)
        if self.corners is None:
            return light
        spent = saturated(light.radiance.reshape(-1, light.radiance.shape[2])).reshape(light.known.shape)
        return texel_means(light._replace(known=light.known & ~spent), self.corners, self.pixels)


def _shape(setup: CaptureSetup, places: FloatArray, aspect: float) -> tuple[int, int]:
    """Texels: (height, width)."""
    sides = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    count = round(setup.texels or float(np.clip(max(sides[0], sides[2]), 1, _DEFAULT_TEXELS)))
    if not 1 <= count <= MOST_TEXELS or max(round(count * aspect), 1) > MOST_TEXELS:
        raise setup.error("texels", f"1 to {MOST_TEXELS} along each side")
    return max(round(count * aspect), 1), count


def _scale(scale: ScaleSetup, view: View, length: float) -> tuple[ScaleSetup, MeasuredPlace]:
    """The scale, and what its lamps light: a card is where the sample's plane is seen in its region."""
    card = scale.card
    if card is None:
        return scale, MeasuredPlace(np.zeros(3), length)
    left, top, right, bottom = card.region if card.region is not None else np.zeros(4)
    ray = view.turn @ rays_through(np.array([left + right, top + bottom]) / 2, view.size, view.angle)
    if card.region is None or not ray[2] < 0:
        raise card.error("region", "a part of the picture in which the sample's plane is seen, left, top, right and "
                                   "bottom")
    faces = np.array([0.0, 0, 1]) if card.normal is None else card.normal
    return (replace(scale, card=replace(card, normal=faces)),
            MeasuredPlace(view.position - view.position[2] / ray[2] * ray, length))


def _albedo(photographs: list[FlatPhotograph], corners: FloatArray) -> float:
    """The albedo of a sample under lamps of these intensities, as if it were Lambertian: the mean over it and the
    channels of the median over the lamps, since a highlight is under few of them."""
    seen = observed(photographs, points_of(corners, _GUESSED), np.array([0.0, 0, 1]))
    seen = seen.some(np.flatnonzero(seen.good.any(axis=1)))
    light = np.where(seen.good, seen.lit.light[..., 2], np.nan)[..., None] * seen.lit.brought
    albedo = np.nanmedian(np.pi * seen.radiance / light, axis=1).mean() if len(light) else 0.0
    if not albedo > 0:
        raise DatasetError("nothing is bright between the corners: no sample is in the picture", photographs[0].name)
    return float(albedo)
