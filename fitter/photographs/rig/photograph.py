"""What photographs of balls and of flat samples share: a picture, and where camera and lamp were."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...arrays import BoolArray, Directions, FloatArray, RealArray
from ...errors import DatasetError

STEEPEST = np.radians(80)   # polar angle beyond which a pixel says little: its own size spans many degrees there
TO_SIGMA = 1.4826           # from the median absolute deviation to the standard deviation of a normal distribution
_SATURATED = 4              # pixels that share the largest value are saturated, if they are so many


@dataclass(frozen=True, eq=False)
class Photograph:
    """A photograph of a scene with one lamp, to which a ball or a plane is added.

    Attributes
    ----------
    radiance : (height, width, channels) float64 or float32
        Linear, the top row first, with whatever was there without the lamp subtracted.
    rays : (height, width, 3) float64
        Directions from the camera through the pixels' centres, unit vectors.
    camera, lamp : (3,) float64
        Metres.
    intensity : (channels,) float64
        The lamp's radiant intensity, W/sr in the units of `radiance`: a Lambertian of albedo 1 that faces it at 1 m
        has the radiance intensity / pi.
    noise : (height, width, channels) float64 or float32, or None
        The standard deviation of each value, in the units of `radiance`.
    mask : (height, width) bool, or None
        The pixels that count, where not all do.
    name : str
        For messages: the file.

    Raises DatasetError if the arrays do not have these shapes or hold numbers that are not finite.
    """

    radiance: RealArray
    rays: FloatArray
    camera: FloatArray
    lamp: FloatArray
    intensity: FloatArray
    noise: RealArray | None = None
    mask: BoolArray | None = None
    name: str = "photograph"

    def __post_init__(self) -> None:
        radiance = self._set("radiance")
        if radiance.ndim != 3 or min(radiance.shape[:2]) < 2 or radiance.shape[2] not in (1, 3):
            raise DatasetError(f"radiance has the shape {radiance.shape}, expected (height, width, 1 or 3) of 2 x 2 "
                               f"pixels or more", self.name)
        lengths = np.linalg.norm(self._set("rays", (*radiance.shape[:2], 3)), axis=-1)
        if np.abs(lengths - 1).max() > 1e-3:
            raise DatasetError(f"rays have lengths from {lengths.min():g} to {lengths.max():g}, expected unit vectors",
                               self.name)
        for place in ("camera", "lamp"):
            self._set(place, (3,))
        intensity = self._set("intensity")
        if intensity.shape != radiance.shape[2:] or not (intensity > 0).all():
            raise DatasetError(f"an intensity of {intensity.tolist()} found, expected {radiance.shape[2]} numbers "
                               f"above 0", self.name)
        if self.noise is not None and not (self._set("noise", radiance.shape) >= 0).all():
            raise DatasetError("noise below 0 found", self.name)
        if self.mask is not None:
            mask = np.asarray(self.mask, dtype=bool)
            if mask.shape != radiance.shape[:2]:
                raise DatasetError(f"the mask has the shape {mask.shape}, expected {radiance.shape[:2]}", self.name)
            object.__setattr__(self, "mask", mask)

    def _set(self, field: str, shape: tuple[int, ...] | None = None) -> RealArray:
        array = np.asarray(getattr(self, field))
        array = array if array.dtype == np.float32 else array.astype(float)
        if shape is not None and array.shape != shape:
            raise DatasetError(f"{field} has the shape {array.shape}, expected {shape}", self.name)
        if not np.isfinite(array).all():
            raise DatasetError(f"{field} holds numbers that are not finite; leave out saturated pixels by a mask",
                               self.name)
        object.__setattr__(self, field, array)
        return array


def check_alike(photographs: Sequence[Photograph]) -> None:
    """Raise DatasetError, of the first that differs, if photographs differ in size or number of channels."""
    first = photographs[0]
    for other in photographs[1:]:
        if other.radiance.shape != first.radiance.shape:
            raise DatasetError("{1} x {0} pixels with {2} channels found, expected {4} x {3} pixels with {5} as in "
                               "{6}".format(*other.radiance.shape, *first.radiance.shape, first.name), other.name)


def to_local_angles(normal: FloatArray, light: FloatArray, view: FloatArray) -> Directions:
    """Directions to light and viewer about normals, all (n, 3) unit vectors, as angles: four (n,), phi_i is 0."""
    cross_i, cross_o = np.cross(normal, light), np.cross(normal, view)
    theta = [np.arctan2(np.linalg.norm(cross, axis=1), np.sum(normal * toward, axis=1))
             for cross, toward in ((cross_i, light), (cross_o, view))]
    turn = np.arctan2(np.sum(np.cross(cross_i, cross_o) * normal, axis=1), np.sum(cross_i * cross_o, axis=1))
    return theta[0], np.zeros(len(turn)), theta[1], turn


def mean_of_neighbours(picture: RealArray, beyond: Literal["constant", "edge"] = "edge") -> FloatArray:
    """The mean of the four neighbours of each pixel, (h, w, channels) to the same, beyond the picture its edge or 0."""
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode=beyond)
    return np.asarray((padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]) / 4)


def is_saturated(radiance: RealArray) -> BoolArray:
    """The pixels with a channel at that channel's largest value, where many share it: (..., channels) to (...)."""
    pixels = radiance.reshape(-1, radiance.shape[-1])
    at_most = (pixels == pixels.max(axis=0)) & (pixels > 0)
    return np.asarray((at_most & (at_most.sum(axis=0) >= _SATURATED)).any(axis=1)).reshape(radiance.shape[:-1])
