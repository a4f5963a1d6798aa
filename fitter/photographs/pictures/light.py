"""Light from pixels: exposures merged by their noise, sRGB made linear, photographs of a dark room and an even surface.

A pixel that is p of white has the variance READ^2 + SHOT p + step^2 / 12: of the electronics, of the photons, and of
rounding to steps. Exposures are averaged with weights of the inverse variance of what they say of the radiance
(M. Granados, B. Ajdin, M. Wand, C. Theobalt, H.-P. Seidel, H. P. A. Lensch: Optimal HDR Reconstruction with Linear
Digital Cameras, CVPR 2010).
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray, RealArray
from ...errors import DatasetError

SATURATED = 0.95            # of white: pixels above it are left out
READ, SHOT = 5e-4, 5e-5     # noise of a camera at ISO 100: 10 of 20,000 electrons, and the root of their number
_ROUNDS = 2                 # of the mean, whose weights depend on it
_CENTRE = 0.04              # of a picture's sides: the part whose brightness others are compared with


class Exposure(NamedTuple):
    """One photograph of several that differ in exposure."""

    pixels: FloatArray          # linear, 1 for white, where the camera is saturated: (height, width, channels)
    step: FloatArray | float = 0.0      # of 1, between two values that the file can hold, of each or of all
    exposure: float = 1.0       # time times sensitivity, in any unit: `picture_files.camera_exposure`


class Light(NamedTuple):
    """The light that reached the camera: radiance, its standard deviation, both (h, w, channels), and where it is known
    (h, w)."""

    radiance: RealArray
    noise: RealArray
    known: BoolArray

    def convert(self, matrix: FloatArray) -> "Light":
        """The same in other colours, by a matrix (3, 3)."""
        return Light(self.radiance @ matrix.T, np.sqrt(self.noise ** 2 @ (matrix ** 2).T), self.known)


def check_bright(radiance: RealArray, where: str | Path) -> None:
    """Raise DatasetError, of a file or its name, where a photograph is black: whatever is predicted of it is right."""
    if not (radiance > 0).any():
        raise DatasetError("a black photograph: none of its pixels is above 0, expected what a lamp lights", where)


def same_pictures(pictures: Sequence[RealArray], names: Sequence[str]) -> tuple[str, ...]:
    """A line that tells of photographs, (h, w, channels), which repeat another one's picture, if there are any."""
    sums = [float(picture.sum()) for picture in pictures]
    same = [number for number, picture in enumerate(pictures) if any(
        sums[before] == sums[number] and np.array_equal(pictures[before], picture) for before in range(number))]
    return () if not same else (f"{len(same)} of {len(pictures)} photographs repeat the picture of another one, "
                                f"{names[same[0]]} for one: expected each under a lamp of its own",)


def merge_exposures(exposures: Sequence[Exposure]) -> Light:
    """The light that one or more exposures of one size saw, in units of white at an exposure of 1.

    Examples
    --------
    The longer exposure is saturated in the first pixel.

    >>> short, long = (Exposure(np.minimum([[[0.5], [0.01]]], 1 / t) * t, exposure=t) for t in (1.0, 8.0))
    >>> light = merge_exposures([short, long])
    >>> light.radiance.ravel().round(6).tolist(), bool(light.noise[0, 1, 0] < light.noise[0, 0, 0])
    ([0.5, 0.01], True)
    """
    good = [np.asarray((each.pixels < SATURATED).all(axis=2)) for each in exposures]
    known = np.asarray(np.any(good, axis=0))
    radiance, shortest = np.zeros(exposures[0].pixels.shape), min(exposures, key=lambda each: each.exposure)
    for number in range(1 + _ROUNDS):
        total, weights = np.zeros_like(radiance), np.zeros_like(radiance)
        for each, is_good in zip(exposures, good, strict=True):
            # first as if nothing were there but the noise of the dark
            expected = np.maximum(radiance * each.exposure, 0) if number else 0.0
            variance = READ ** 2 + SHOT * expected + np.square(each.step) / 12
            weight = is_good[..., None] * each.exposure ** 2 / variance
            total, weights = total + weight * each.pixels / each.exposure, weights + weight
        # where all are saturated, it is as bright as that at least
        radiance = np.divide(total, weights, out=shortest.pixels / shortest.exposure, where=weights > 0)
    noise = np.divide(1, np.sqrt(weights), out=np.zeros_like(weights), where=weights > 0)
    return Light(radiance, noise, known)


def subtract_dark(light: Light, dark: Light) -> Light:
    """Light less what was there with the lamp off."""
    return Light(light.radiance - dark.radiance, np.hypot(light.noise, dark.noise), light.known & dark.known)


def middle_part(size: tuple[int, ...]) -> tuple[slice, slice]:
    """The rows and columns of a picture whose brightness others are compared with."""
    rows, columns = (slice(int(side * (0.5 - _CENTRE)), int(side * (0.5 + _CENTRE)) + 1) for side in size)
    return rows, columns


def divide_flat(light: Light, flat: Light, middle: RealArray) -> Light:
    """Light without the vignetting that a photograph of an evenly bright surface shows, in whose middle this is
    `middle`, (channels,): what is seen there stays as it is."""
    share = flat.radiance / np.where(middle > 0, middle, 1)
    seen = flat.known & (share > 0).all(axis=2)
    share = np.where(seen[..., None], share, 1.0)
    return Light(light.radiance / share, light.noise / share, light.known & seen)
