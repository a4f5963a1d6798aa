"""A photograph of a flat sample under one lamp, and what points of the sample show in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..errors import DatasetError
from .ball import STEEPEST, saturated

_STEPS = 12                 # of Newton's method toward a pixel, which doubles the digits; of 120 degrees it takes 7
_EXACT = 1e-9               # of a pixel: a step at which it ends
_TOUCHED = 1e-3             # share of a pixel that does not count, which may be in a texel
_FLOOR = 1e-3               # of the picture's typical brightness, where its noise is not known
_LEAST_NOISE = 1e-3         # of that, which nothing is below: files may say that black has none


@dataclass(frozen=True, eq=False)
class FlatPhotograph:
    """A photograph of a flat sample, and where camera and lamp were.

    Attributes
    ----------
    radiance : (height, width, channels) float64
        Linear, the top row first, with whatever was there without the lamp subtracted.
    rays : (height, width, 3) float64
        Directions from the camera through the pixels' centres, unit vectors.
    camera, lamp : (3,) float64
        Positions, metres.
    intensity : (channels,) float64
        The lamp's radiant intensity, W/sr in the units of `radiance`, as of a `BallPhotograph`.
    noise : (height, width, channels) float64, or None
        The standard deviation of each value, in the units of `radiance`.
    mask : (height, width) bool, or None
        The pixels that count, where not all do.
    name : str
        For messages: the file.

    Raises
    ------
    DatasetError
        If the arrays do not have these shapes or hold numbers that are not finite.
    """

    radiance: FloatArray
    rays: FloatArray
    camera: FloatArray
    lamp: FloatArray
    intensity: FloatArray
    noise: FloatArray | None = None
    mask: BoolArray | None = None
    name: str = "photograph"

    def __post_init__(self) -> None:
        radiance = self._set("radiance")
        if radiance.ndim != 3 or min(radiance.shape) < 1 or min(radiance.shape[:2]) < 2 or radiance.shape[2] not in (
                1, 3):
            raise DatasetError(f"radiance has the shape {radiance.shape}, expected (height, width, 1 or 3) of 2 x 2 "
                               f"pixels or more", self.name)
        lengths = np.linalg.norm(self._set("rays", (*radiance.shape[:2], 3)), axis=-1)
        if np.abs(lengths - 1).max() > 1e-3:
            raise DatasetError(f"rays have lengths from {lengths.min():g} to {lengths.max():g}, expected unit vectors",
                               self.name)
        for field in ("camera", "lamp"):
            self._set(field, (3,))
        if not (self._set("intensity", radiance.shape[2:]) > 0).all():
            raise DatasetError(f"an intensity of {self.intensity.tolist()} found, expected {radiance.shape[2]} numbers "
                               f"above 0", self.name)
        if self.noise is not None and not (self._set("noise", radiance.shape) >= 0).all():
            raise DatasetError("noise below 0 found", self.name)
        mask = np.ones(radiance.shape[:2], bool) if self.mask is None else np.asarray(self.mask, dtype=bool)
        if mask.shape != radiance.shape[:2]:
            raise DatasetError(f"the mask has the shape {mask.shape}, expected {radiance.shape[:2]}", self.name)
        object.__setattr__(self, "mask", mask)

    @cached_property
    def counts(self) -> FloatArray:
        """1 for pixels that count and are not saturated, 0 for others: (height, width, 1)."""
        spent = saturated(self.radiance.reshape(-1, self.radiance.shape[2])).reshape(self.radiance.shape[:2])
        return np.asarray((~spent if self.mask is None else self.mask & ~spent)[..., None].astype(float))

    @cached_property
    def floor(self) -> float:
        """The noise that is taken for granted where it is not known, in the units of `radiance`."""
        bright = self.radiance[self.radiance > 0]
        return _FLOOR * float(np.median(bright)) if len(bright) else _FLOOR

    def _set(self, field: str, shape: tuple[int, ...] | None = None) -> FloatArray:
        array = np.asarray(getattr(self, field), dtype=float)
        if shape is not None and array.shape != shape:
            raise DatasetError(f"{field} has the shape {array.shape}, expected {shape}", self.name)
        if not np.isfinite(array).all():
            raise DatasetError(f"{field} holds numbers that are not finite; leave out saturated pixels by a mask",
                               self.name)
        object.__setattr__(self, field, array)
        return array


class Lit(NamedTuple):
    """How n points look at p cameras and lamps."""

    light: FloatArray
    """Unit vectors to the lamps: (n, p, 3)."""
    view: FloatArray
    """And to the cameras."""
    brought: FloatArray
    """I / d^2: (n, p, channels)."""


class Observed(NamedTuple):
    """What n points show in p photographs."""

    lit: Lit
    radiance: FloatArray
    """(n, p, channels)."""
    noise: FloatArray
    """Its standard deviation, by the photographs' noise or a floor."""
    good: BoolArray
    """Where it counts: (n, p)."""

    def some(self, which: IntArray) -> "Observed":
        """Those of some points, by their numbers."""
        return Observed(Lit(*(part[which] for part in self.lit)), self.radiance[which], self.noise[which],
                        self.good[which])

    def shots(self, which: IntArray) -> "Observed":
        """What some photographs show, by their numbers."""
        return Observed(Lit(*(part[:, which] for part in self.lit)), self.radiance[:, which], self.noise[:, which],
                        self.good[:, which])


def lit(points: FloatArray, camera: FloatArray, lamp: FloatArray, intensity: FloatArray) -> Lit:
    """How points (n, 3) look at cameras (p, 3) and lamps (p, 3) of the intensities (p, channels)."""
    to_lamp, to_camera = (place - points[:, None] for place in (lamp, camera))
    far = np.linalg.norm(to_lamp, axis=2, keepdims=True)
    return Lit(to_lamp / far, to_camera / np.linalg.norm(to_camera, axis=2, keepdims=True), intensity / far ** 2)


def observed(photographs: Sequence[FlatPhotograph], points: FloatArray, normal: FloatArray) -> Observed:
    """What points (n, 3) of a plane with this normal, (3,), show in photographs.

    They do not count where they are outside the picture, masked, saturated, or where lamp or camera stand more than
    `STEEPEST` from the plane's normal.
    """
    camera, lamp, intensity = (np.array([getattr(each, name) for each in photographs])
                               for name in ("camera", "lamp", "intensity"))
    seen = lit(points, camera, lamp, intensity)
    shape = (len(points), *intensity.shape)
    radiance, noise, good = np.zeros(shape), np.zeros(shape), np.zeros(shape[:2], bool)
    pixel = np.zeros((len(points), 2))
    for k, each in enumerate(photographs):
        before = photographs[k - 1]
        if k == 0 or each.rays is not before.rays or (each.camera != before.camera).any():
            pixel = pixel_of(each.rays, -seen.view[:, k])
        corner, share, inside = corners_of(pixel, each.radiance.shape[:2])
        radiance[:, k] = between(each.radiance, corner, share)
        noise[:, k] = each.floor if each.noise is None else np.maximum(between(each.noise, corner, share),
                                                                       _LEAST_NOISE * each.floor)
        good[:, k] = inside & (between(each.counts, corner, share)[:, 0] > 1 - _TOUCHED)
    steepest = np.minimum(seen.light @ normal, seen.view @ normal)
    return Observed(seen, radiance, noise, good & (steepest > np.cos(STEEPEST)))


def pixel_of(rays: FloatArray, toward: FloatArray) -> FloatArray:
    """Where directions are in a picture: row and column, the first pixel's centre being 0, 0; by Newton's method.

    Parameters
    ----------
    rays : (height, width, 3)
    toward : (n, 3)

    Returns
    -------
    (n, 2) float64
        Outside the picture somewhere outside it.

    Examples
    --------
    >>> from .camera import rays
    >>> picture = rays(20, 30, 1.0)
    >>> pixel_of(picture, picture[[3, 19], [7, 29]]).round(9).tolist()
    [[3.0, 7.0], [19.0, 29.0]]
    """
    place = np.tile((np.array(rays.shape[:2]) - 1) / 2, (len(toward), 1))
    for _ in range(_STEPS):
        corner, share, _ = corners_of(place, rays.shape[:2])
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


def corners_of(place: FloatArray, size: tuple[int, ...]) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The first of the four pixels around each place, the shares of the others along both axes, and which are inside.

    Those outside are moved to the edge.
    """
    last = np.array(size) - 1
    held = np.clip(place, 0, last)
    corner = np.minimum(held.astype(int), last - 1)
    return corner, held - corner, np.asarray((np.abs(place - held) < 1e-6).all(axis=1))


def between(picture: FloatArray, corner: FloatArray, share: FloatArray) -> FloatArray:
    """A picture (h, w, k) at places between its pixels: (n, k)."""
    (row, column), y, x = corner.T, share[:, :1], share[:, 1:]
    return np.asarray((1 - y) * ((1 - x) * picture[row, column] + x * picture[row, column + 1])
                      + y * ((1 - x) * picture[row + 1, column] + x * picture[row + 1, column + 1]))
