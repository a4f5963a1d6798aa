"""Photographs of a flat sample as a description says they were taken."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray
from ...errors import DatasetError
from ..description.capture_setup import MOST_TEXELS, CaptureSetup, SampleSetup
from ..pictures import Light, Part, Pictures, read_mask, same_pictures
from ..rig.camera import CameraView, field_of_view, find_view, pixel_angle, rays_through
from ..rig.lamps import GUESSED, MeasuredPlace, Scene, find_lamps, lamp_intensity, place_scene
from ..rig.photograph import is_saturated
from .judging import lamp_brightness
from .maps import pixels_per_texel, sample_frame, texel_corners, texel_points
from .photograph import FlatPhotograph, find_pixels, interpolate_bilinear, observe, pixel_corners, texel_means

_DEFAULT_TEXELS = 1024      # along the width
_OFF = 3.0                  # pixels that a corner may be off: an edge is found within one by hand
_BESIDE = 32                # pixels that are kept around the sample
_MANY, _ROOM = 4, 1 << 22   # pixels of a texel along both axes whose mean is kept; of a part that is kept as it is
_EDGE = 1.5                 # pixels from the sample's edge, within which they see what is beside it too
_GUESSED = 32, 32           # points of a sample whose albedo is a guess


class Flat(NamedTuple):
    """What `maps_from_flat` takes of a description."""

    name: str
    view: CameraView
    photographs: list[FlatPhotograph]
    corners: FloatArray
    shape: tuple[int, int]
    materials: tuple[Path, ...]     # files; empty where these are to be found
    number: int | None              # how many there are then, where that is known
    notes: tuple[str, ...]
    doubts: tuple[str, ...]         # what is wrong with the photographs, in words
    albedo: float | None            # that was guessed


def read_sample(setup: CaptureSetup) -> Flat:
    """The photographs of a flat sample that a description shows.

    Raises DatasetError if the description or a file is wrong, with file and key; ImportError without OpenImageIO.
    """
    pictures, sample = Pictures(setup), setup.need_sample()
    scene = locate_sample(setup, pictures)
    view, places, whole = scene.view, corner_places(sample, scene.view.size), sample_corners(sample)
    shape = _shape(setup, places, sample.height / sample.width)
    window = _Window.enclosing(view, whole, places, shape, read_mask(sample, view.size))
    setup, shots = scene.setup, scene.setup.photographs
    lights = pictures.read_photographs(shots, window.part, window.reduce)
    intensity, note = lamp_intensity(scene, pictures, lights[0].radiance.shape[2])
    if window.corners is None:
        lights = _fill_rim(lights, window.toward, view.position, np.array([sample.width, sample.height]) / 2)
    photographs = [FlatPhotograph(light.radiance, window.toward, view.position, lamp, intensity, light.noise,
                                  light.known, shot.name)
                   for light, lamp, shot in zip(lights, scene.lamps, shots, strict=True)]
    frame = sample_frame(whole, photographs)    # lamps are not behind it
    brightness, differ = setup.lamp.brightness, tuple[str, ...]()
    if brightness is not None:
        by = (lamp_brightness(observe(photographs, texel_points(whole, _GUESSED), frame[2]), frame)
              if isinstance(brightness, str) else brightness[:, None])
        photographs = [replace(each, intensity=each.intensity * factor)
                       for each, factor in zip(photographs, by, strict=True)]
        differ = f"The lamps differ in brightness from {by.min():.2f} to {by.max():.2f}",
    albedo = setup.scale.albedo
    if albedo is not None:
        share = _albedo(photographs, whole) / albedo
        photographs = [replace(each, intensity=each.intensity * share) for each in photographs]
        note = GUESSED.format(f"{albedo:g}"), *note
    files, number = (setup.materials, None) if isinstance(setup.materials, tuple) else ((), setup.materials)
    return Flat(setup.title, view, photographs, whole, shape, files, number,
                (*pictures.notes, *scene.notes, *differ, *note),
                same_pictures([light.radiance for light in lights], [each.name for each in photographs]),
                albedo)


def locate_sample(setup: CaptureSetup, pictures: Pictures) -> Scene:
    """The scene of a flat sample, the camera by its corners, without photographs whose chrome ball shows no lamp."""
    sample, size = setup.need_sample(), pictures.size
    whole, middle = sample_corners(sample), MeasuredPlace(np.zeros(3), float(np.hypot(sample.width, sample.height)))
    places = corner_places(sample, size)
    angle = field_of_view(setup.camera, pictures.infos)
    view, off = find_view(setup.camera, places, whole, size, angle)
    if off > _OFF:
        raise sample.error("corners", f"those of a rectangle of {sample.width:g} x {sample.height:g} m that this lens "
                                      f"sees, within {_OFF:g} pixels: one is {off:.1f} off")
    lamps = find_lamps(setup, pictures, view, middle)
    missing = [shot.name for shot, lamp in zip(setup.photographs, lamps, strict=True) if lamp is None]
    if len(missing) == len(lamps):
        raise setup.error("chrome", "a ball that shows the lamp in some photograph")
    brightness, count = setup.lamp.brightness, len(lamps) - len(missing)
    if isinstance(brightness, np.ndarray) and len(brightness) != count:
        raise setup.lamp.error("brightness", f"{count} numbers")
    notes = setup.notes
    if missing:
        notes += f"Left out, for the chrome ball shows no lamp there: {', '.join(missing)}",
    notes += "The camera is at {:.4g}, {:.4g}, {:.4g} m by the corners, which are within {:.1f} pixels".format(
        *view.position, off),
    known, card = middle, setup.scale.card
    if card is not None:        # it lies where the sample's plane is seen in its region
        left, top, right, bottom = card.region if card.region is not None else np.zeros(4)
        ray = view.orientation @ rays_through(np.array([left + right, top + bottom]) / 2, size, angle)
        if card.region is None or not ray[2] < 0:
            raise card.error("region", "a part of the picture in which the sample's plane is seen, left, top, right "
                                       "and bottom")
        known = middle._replace(middle=view.position - view.position[2] / ray[2] * ray)
        if card.normal is None:
            setup = replace(setup, scale=replace(setup.scale, card=replace(card, normal=np.array([0.0, 0, 1]))))
    return place_scene(setup, view, middle, lamps, known, notes)


def sample_corners(sample: SampleSetup) -> FloatArray:
    """The corners of a sample: (4, 3), metres."""
    return np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * (sample.width / 2, sample.height / 2, 0)


def order_corners(corners: FloatArray, size: tuple[int, int]) -> FloatArray:
    """Corners in the order of a description, (4, 2), pixels, of those in any order that `to_pixels` takes: what is
    lowest there is the sample's lower edge."""
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


def corner_places(sample: SampleSetup, size: tuple[int, int]) -> FloatArray:
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


def _fill_rim(lights: list[Light], toward: FloatArray, position: FloatArray, half: FloatArray) -> list[Light]:
    """Light whose pixels that see the sample's edge, or what is right beside it, have what is seen as far within it:
    copies of one pixel would look saturated, mirror images do not. `half` is of the sample's width and height."""
    step = _EDGE * pixel_angle(toward) * float(position @ position) / position[2]
    seen = (position - toward * (position[2] / np.minimum(toward[..., 2:], -1e-9)))[..., :2]
    within = np.clip(seen, *(sign * np.maximum(half - step, 0) for sign in (-1, 1)))
    rim = (seen != within).any(axis=2) & (np.abs(seen - within) < 2 * step).all(axis=2)
    there = np.column_stack([(2 * within - seen)[rim], np.zeros(int(rim.sum()))]) - position
    corner, share, _ = pixel_corners(find_pixels(toward, there), rim.shape)
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
    toward: FloatArray                  # the directions in which pixels or texels are seen: (h, w, 3)
    mask: BoolArray | None              # of the pixels of the part that count
    corners: FloatArray | None = None   # of texels, rows and columns of the part's pixels: (h + 1, w + 1, 2)
    pixels: int = 1                     # pixels of a texel along both axes

    @classmethod
    def enclosing(cls, view: CameraView, whole: FloatArray, places: FloatArray, shape: tuple[int, int],
                  mask: BoolArray | None) -> "_Window":
        """Of pictures in which the corners `whole` (4, 3) of a sample are at these places, (4, 2)."""
        first, last = np.floor(places.min(axis=0)) - _BESIDE, np.ceil(places.max(axis=0)) + _BESIDE
        columns, rows = (slice(max(int(a), 0), min(int(b), side))
                         for a, b, side in zip(first, last, view.size[::-1], strict=True))
        part, count = (rows, columns), pixels_per_texel(places, shape)
        mask = None if mask is None else mask[part]
        if count < _MANY and (count == 1 or (rows.stop - rows.start) * (columns.stop - columns.start) < _ROOM):
            return cls(part, view.rays(part), mask)
        # what is right beside the sample's edge gets into the pixels there
        sides = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
        corners = view.project(texel_corners(whole, shape, _EDGE / sides[[1, 3]].min(), _EDGE / sides[[0, 2]].min()))
        toward = texel_points(whole, shape).reshape(*shape, 3) - view.position
        toward /= np.linalg.norm(toward, axis=2, keepdims=True)
        return cls(part, toward[::-1], mask, corners[::-1, :, ::-1] - (rows.start + 0.5, columns.start + 0.5), count)

    def reduce(self, light: Light) -> Light:
        """What is kept of a part's light."""
        if self.mask is not None:
            light = light._replace(known=light.known & self.mask)
        if self.corners is None:
            return light
        return texel_means(light._replace(known=light.known & ~is_saturated(light.radiance)), self.corners, self.pixels)


def _shape(setup: CaptureSetup, places: FloatArray, aspect: float) -> tuple[int, int]:
    """Texels: (height, width)."""
    sides = np.linalg.norm(np.roll(places, -1, axis=0) - places, axis=1)
    count = round(setup.texels or float(np.clip(max(sides[0], sides[2]), 1, _DEFAULT_TEXELS)))
    if not 1 <= count <= MOST_TEXELS or max(round(count * aspect), 1) > MOST_TEXELS:
        raise setup.error("texels", f"1 to {MOST_TEXELS} along each side")
    return max(round(count * aspect), 1), count


def _albedo(photographs: list[FlatPhotograph], corners: FloatArray) -> float:
    """The albedo of a sample under lamps of these intensities, as if it were Lambertian: the mean over it and the
    channels of the median over the lamps, since a highlight is under few of them."""
    seen = observe(photographs, texel_points(corners, _GUESSED), np.array([0.0, 0, 1]))
    seen = seen.some(np.flatnonzero(seen.good.any(axis=1)))
    light = np.where(seen.good, seen.lit.light[..., 2], np.nan)[..., None] * seen.lit.brought
    albedo = np.nanmedian(np.pi * seen.radiance / light, axis=1).mean() if len(light) else 0.0
    if not albedo > 0:
        raise DatasetError("nothing is bright between the corners: no sample is in the picture", photographs[0].name)
    return float(albedo)
