"""A photograph of a flat sample under one lamp, and what points of the sample show in it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray, RealArray
from ..pictures import Light
from ..rig.photograph import STEEPEST, Photograph, is_saturated

_STEPS = 12                 # of Newton's method toward a pixel, which doubles the digits; of 120 degrees it takes 7
_EXACT = 1e-9               # of a pixel: a step at which it ends
_TOUCHED = 1e-3             # share of a pixel that does not count, which may be in a texel
_BESIDE = 1.0               # pixel, by which a place may be beside the outermost centres
_SPENT = 0.05               # of a texel's points, which may be saturated or masked
_FLOOR = 1e-3               # of the picture's typical brightness, where its noise is not known
_LEAST_NOISE = 1e-3         # of that, which nothing is below: files may say that black has none


class FlatPhotograph(Photograph):
    """A photograph of a flat sample; attributes and errors are those of a `Photograph`."""

    @cached_property
    def counts(self) -> BoolArray:
        """Which pixels count and are not saturated: (height, width)."""
        good = ~is_saturated(self.radiance)
        return good if self.mask is None else self.mask & good

    def average_texels(self, points: FloatArray, count: int) -> "FlatPhotograph":
        """The same with a pixel for each texel, the mean of its pixels: `points` (h + 1, w + 1, 3) are the corners of
        texels, each of which has so many pixels along both axes."""
        places = find_pixels(self.rays, (points - self.camera).reshape(-1, 3)).reshape(*points.shape[:2], 2)
        noise = np.zeros_like(self.radiance[..., :1]) if self.noise is None else self.noise
        light = texel_means(Light(self.radiance, noise, self.counts), places, count)
        middle = (points[:-1, :-1] + points[1:, 1:]) / 2 - self.camera
        return replace(self, radiance=light.radiance, noise=None if self.noise is None else light.noise,
                       mask=light.known, rays=middle / np.linalg.norm(middle, axis=2, keepdims=True))

    @cached_property
    def floor(self) -> float:
        """The noise that is taken for granted where it is not known, in the units of `radiance`."""
        bright = self.radiance[self.radiance > 0]
        return _FLOOR * float(np.median(bright)) if len(bright) else _FLOOR


class ShadingGeometry(NamedTuple):
    """How n points look at p cameras and lamps."""

    light: FloatArray       # unit vectors to the lamps: (n, p, 3)
    view: FloatArray        # and to the cameras
    brought: FloatArray     # I / d^2: (n, p, channels)


class Observed(NamedTuple):
    """What n points show in p photographs."""

    lit: ShadingGeometry
    radiance: FloatArray    # (n, p, channels)
    noise: FloatArray       # its standard deviation, by the photographs' noise or a floor
    good: BoolArray         # where it counts: (n, p)

    def some(self, which: Any) -> "Observed":
        """Those of some points, by their numbers; by `np.s_[:, numbers]`, of some photographs."""
        return Observed(ShadingGeometry(*(part[which] for part in self.lit)), *(part[which] for part in self[1:]))


def shading_geometry(points: FloatArray, camera: FloatArray, lamp: FloatArray,
                     intensity: FloatArray) -> ShadingGeometry:
    """How points (n, 3) look at cameras (p, 3) and lamps (p, 3) of the intensities (p, channels)."""
    to_lamp, to_camera = (place - points[:, None] for place in (lamp, camera))
    far = np.linalg.norm(to_lamp, axis=2, keepdims=True)
    to_camera = to_camera / np.linalg.norm(to_camera, axis=2, keepdims=True)
    return ShadingGeometry(to_lamp / far, to_camera, intensity / far ** 2)


def observe(photographs: Sequence[FlatPhotograph], points: FloatArray, normal: FloatArray) -> Observed:
    """What points (n, 3) of a plane with this normal, (3,), show in photographs. They do not count outside the picture,
    masked, saturated, or where lamp or camera stand more than `STEEPEST` from the normal."""
    camera, lamp, intensity = (np.array([getattr(each, name) for each in photographs])
                               for name in ("camera", "lamp", "intensity"))
    seen = shading_geometry(points, camera, lamp, intensity)
    shape = (len(points), *intensity.shape)
    radiance, noise, good = np.zeros(shape), np.zeros(shape), np.zeros(shape[:2], bool)
    pixel = np.zeros((len(points), 2))
    for k, each in enumerate(photographs):
        before = photographs[k - 1]
        same = each.rays is before.rays or np.array_equal(each.rays, before.rays)
        if k == 0 or not same or (each.camera != before.camera).any():
            pixel = find_pixels(each.rays, -seen.view[:, k])
        corner, share, inside = pixel_corners(pixel, each.radiance.shape[:2])
        radiance[:, k] = interpolate_bilinear(each.radiance, corner, share)
        noise[:, k] = each.floor if each.noise is None else np.maximum(interpolate_bilinear(each.noise, corner, share),
                                                                       _LEAST_NOISE * each.floor)
        good[:, k] = inside & (interpolate_bilinear(each.counts[..., None], corner, share)[:, 0] > 1 - _TOUCHED)
    steepest = np.minimum(seen.light @ normal, seen.view @ normal)
    return Observed(seen, radiance, noise, good & (steepest > np.cos(STEEPEST)))


def texel_means(light: Light, places: FloatArray, count: int) -> Light:
    """The means of what texels see, (h, w, channels), whose corners are at places (h + 1, w + 1, 2), rows and columns
    of pixels: of count^2 points in each that are not saturated or masked. It is known where nearly all count."""
    height, width = places.shape[0] - 1, places.shape[1] - 1
    radiance, variance = (np.zeros((height * width, each.shape[2])) for each in light[:2])
    number = np.zeros((height * width, 1))
    for y, x in np.ndindex(count, count):
        v, u = (y + 0.5) / count, (x + 0.5) / count
        place = ((1 - v) * ((1 - u) * places[:-1, :-1] + u * places[:-1, 1:])
                 + v * ((1 - u) * places[1:, :-1] + u * places[1:, 1:])).reshape(-1, 2)
        corner, share, inside = pixel_corners(place, light.known.shape)
        counts = (inside & (interpolate_bilinear(light.known[..., None], corner, share)[:, 0] > 1 - _TOUCHED))[:, None]
        radiance += np.where(counts, interpolate_bilinear(light.radiance, corner, share), 0)
        variance += np.where(counts, interpolate_bilinear(light.noise, corner, share) ** 2, 0)
        number += counts
    some = np.maximum(number, 1)
    shape = height, width, -1
    return Light((radiance / some).reshape(shape).astype(np.float32),
                 (np.sqrt(variance) / some).reshape(shape).astype(np.float32),
                 number.reshape(height, width) >= (1 - _SPENT) * count ** 2)


def find_pixels(rays: FloatArray, toward: FloatArray) -> FloatArray:
    """Where directions (n, 3), of any length, are in a picture of rays (height, width, 3): rows and columns (n, 2), the
    first pixel's centre being 0, 0, and outside the picture somewhere outside it; by Newton's method."""
    place = np.tile((np.array(rays.shape[:2]) - 1) / 2, (len(toward), 1))
    for _ in range(_STEPS):
        corner, share, _ = pixel_corners(place, rays.shape[:2])
        row, column = corner.T
        a, b, c, d = rays[row, column], rays[row, column + 1], rays[row + 1, column], rays[row + 1, column + 1]
        y, x = share[:, :1], share[:, 1:]
        here = (1 - y) * ((1 - x) * a + x * b) + y * ((1 - x) * c + x * d)
        # toward = s (here + dy d(here)/dy + dx d(here)/dx)
        along = np.stack([here, (1 - x) * (c - a) + x * (d - b), (1 - y) * (b - a) + y * (d - c)], axis=2)
        step = np.linalg.solve(along, toward[..., None])[..., 0]
        forward = np.where(step[:, :1] > 0, step[:, :1], np.inf)
        before, place = place, np.where(step[:, :1] > 0, corner + share + step[:, 1:] / forward, -1.0)
        if np.abs(place - before).max(initial=0) < _EXACT:
            break
    return np.asarray(place)


def pixel_corners(place: FloatArray, size: tuple[int, ...]) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The first of the four pixels around each place, which is moved to the edge from outside, the shares of the others
    along both axes, and which are inside: within a pixel of the outermost centres, since a sample may fill its
    pictures."""
    last = np.array(size) - 1
    held = np.clip(place, 0, last)
    corner = np.minimum(held.astype(int), last - 1)
    return corner, held - corner, np.asarray((np.abs(place - held) < _BESIDE).all(axis=1))


def interpolate_bilinear(picture: RealArray | BoolArray, corner: FloatArray, share: FloatArray) -> FloatArray:
    """A picture (h, w, k) at places between its pixels: (n, k)."""
    (row, column), y, x = corner.T, share[:, :1], share[:, 1:]
    return np.asarray((1 - y) * ((1 - x) * picture[row, column] + x * picture[row, column + 1])
                      + y * ((1 - x) * picture[row + 1, column] + x * picture[row + 1, column + 1]))
