"""A photograph of a ball under one lamp, and what each of its pixels measures.

A curved sample shows many pairs of directions at once: S. Marschner, S. Westin, E. Lafortune, K. Torrance: Image-based
BRDF Measurement, Applied Optics 39(16), 2000. At a point with the normal n and a lamp of the radiant intensity I at the
distance d in the direction l, the radiance is L = f(l, v) I (n . l) / d^2. For a lamp that is a ball itself, evenly
bright and wholly above the horizon, f is the mean over the lamp.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, Directions, FloatArray, IntArray, RealArray, select_directions
from ...errors import DatasetError
from ..rig.camera import pixel_angle
from ..rig.photograph import STEEPEST, TO_SIGMA, Photograph, is_saturated, mean_of_neighbours, to_local_angles

LIMB_MARGIN = 1.5           # pixels at the ball's outline that are left out: lenses blur it, and it is half background
SHADOW = 0.04               # m, radius of the camera: its shadow is where it hides the lamp from the middle of the ball
_PLACED = 0.2               # pixels by which the ball's outline may be wrong
_AIMED = np.radians(0.25)   # by which a lamp's direction may be wrong: with more, a fit trusts too little that grazes


@dataclass(frozen=True, eq=False, init=False, kw_only=True)
class BallPhotograph(Photograph):
    """A photograph of a ball, and where it was: the other attributes and errors are those of a `Photograph`.

    Attributes
    ----------
    centre : (3,) float64
        Of the ball, metres.
    radius, lamp_radius : float
        Of the ball, and of a lamp that is a ball, metres.
    noise
        By default it is estimated from the pixels.

    Raises DatasetError also if camera or lamp are in the ball.
    """

    centre: FloatArray
    radius: float
    lamp_radius: float

    def __init__(self, radiance: RealArray, rays: FloatArray, camera: FloatArray, centre: FloatArray, radius: float,
                 lamp: FloatArray, intensity: FloatArray, lamp_radius: float = 0.0, noise: RealArray | None = None,
                 mask: BoolArray | None = None, name: str = "photograph") -> None:
        for field, value in (("centre", centre), ("radius", radius), ("lamp_radius", lamp_radius)):
            object.__setattr__(self, field, value)
        super().__init__(radiance, rays, camera, lamp, intensity, noise, mask, name)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._set("centre", (3,))
        if not (self.radius > 0 and np.isfinite(self.radius)):
            raise DatasetError(f"a ball with the radius {self.radius:g} found, expected more than 0", self.name)
        if not (self.lamp_radius >= 0 and np.isfinite(self.lamp_radius)):
            raise DatasetError(f"a lamp with the radius {self.lamp_radius:g} found, expected 0 or more", self.name)
        if np.linalg.norm(self.camera - self.centre) <= self.radius:
            raise DatasetError("the camera is inside the ball", self.name)
        if np.linalg.norm(self.lamp - self.centre) <= self.radius + self.lamp_radius:
            raise DatasetError("the lamp is inside the ball, or touches it", self.name)
        toward = self.centre - self.lamp
        along = (self.camera - self.lamp) @ toward / (toward @ toward)
        if 0 < along < 1 and np.linalg.norm(self.lamp + along * toward - self.camera) < SHADOW:
            raise DatasetError("the lamp is behind the camera, whose shadow falls on the ball: move the lamp aside",
                               self.name)

    @property
    def sight(self) -> tuple[FloatArray, float, float]:
        """The ball as the camera sees it: the direction to its centre, (3,), the distance, and the angle of its limb
        from that direction, radians."""
        toward = self.centre - self.camera
        distance = float(np.linalg.norm(toward))
        return toward / distance, distance, float(np.arcsin(self.radius / distance))

    @property
    def phase_angle(self) -> float:
        """The angle between camera and lamp, seen from the ball's centre, radians."""
        toward = [(place - self.centre) / np.linalg.norm(place - self.centre) for place in (self.camera, self.lamp)]
        return float(np.arctan2(np.linalg.norm(np.cross(toward[0], toward[1])), toward[0] @ toward[1]))


class BallPixels(NamedTuple):
    """What pixels of a photograph see of the ball. The arrays are those of n pixels."""

    pixel: IntArray         # their indices in the picture, row by row
    directions: Directions  # to the lamp's centre and to the camera, about the normal; the lamp's azimuth is 0
    irradiance: FloatArray  # cos theta_i / d^2, for a radiant intensity of 1: (n,)
    grain: float            # the angle of a pixel over the ball's, seen from the camera


def visible_pixels(photograph: BallPhotograph) -> BallPixels:
    """The pixels of the ball at whose points neither the camera nor any part of the lamp is steeper than `STEEPEST`,
    with the directions there, and the irradiance for each W/sr of the lamp. DatasetError, which says why, if there is
    none."""
    axis, distance, limb = photograph.sight
    rays = photograph.rays.reshape(-1, 3)
    size = pixel_angle(photograph.rays)
    # by the sine: exact where the angle is small
    off_axis = np.arctan2(np.linalg.norm(np.cross(rays, axis), axis=1), rays @ axis)
    pixel = np.flatnonzero(off_axis < limb - LIMB_MARGIN * size)
    if not len(pixel):
        raise DatasetError("no pixel sees the ball: it is not in the picture, or too small there", photograph.name)
    ray = rays[pixel]
    closest = distance * (ray @ axis)           # along a ray, where it passes the ball's centre
    point = photograph.camera + ray * (closest - np.sqrt(
        np.maximum(photograph.radius ** 2 - (distance * np.sin(off_axis[pixel])) ** 2, 0)))[:, None]
    normal = (point - photograph.centre) / photograph.radius
    away = photograph.lamp - point
    far = np.linalg.norm(away, axis=1)
    directions = to_local_angles(normal, away / far[:, None], -ray)
    of_lamp = np.arcsin(np.minimum(photograph.lamp_radius / far, 1))
    good = (directions[0] + of_lamp < STEEPEST) & (directions[2] < STEEPEST)
    if not good.any():
        raise DatasetError("the lamp is behind the ball, or so far to its side that the camera sees nothing that is "
                           "lit", photograph.name)
    return BallPixels(pixel[good], select_directions(directions, good), np.cos(directions[0][good]) / far[good] ** 2,
                      float(size / limb))


class PixelReflectances(NamedTuple):
    """The reflectance at pixels that can be trusted."""

    seen: BallPixels
    reflectance: FloatArray     # 1/sr: (n, channels)
    deviation: FloatArray       # its relative standard deviation: (n,)
    left_out: int               # how many of the pixels that are lit were saturated, dark or masked


def measure_pixels(photograph: BallPhotograph) -> PixelReflectances:
    """The reflectance at pixels that are neither saturated, dark nor masked. DatasetError if there is none."""
    lit = visible_pixels(photograph)
    radiance = photograph.radiance.reshape(-1, photograph.radiance.shape[2])
    neighbours = mean_of_neighbours(photograph.radiance).reshape(radiance.shape)[lit.pixel]
    noise = (_noise(photograph, lit.pixel) if photograph.noise is None
             else photograph.noise.reshape(radiance.shape)[lit.pixel])
    # what a pixel's neighbours show is free of its own noise: pixels whose noise is bright are not preferred
    good = (neighbours.mean(axis=1) > noise.mean(axis=1)) & ~is_saturated(radiance)[lit.pixel]
    if photograph.mask is not None:
        good &= photograph.mask.ravel()[lit.pixel]
    if not good.any():
        raise DatasetError("nothing of the ball is lit: all of its pixels are dark, saturated or masked",
                           photograph.name)
    seen_well = BallPixels(lit.pixel[good], select_directions(lit.directions, good), lit.irradiance[good], lit.grain)
    value = radiance[seen_well.pixel] / (photograph.intensity * seen_well.irradiance[:, None])
    relative = noise[good].mean(axis=1) / neighbours[good].mean(axis=1)
    # what small errors of the ball's and the lamp's place do to the normal, and to the cosine of incidence
    turned = np.hypot(_PLACED * seen_well.grain / np.cos(seen_well.directions[2]), _AIMED)
    deviation = np.hypot(relative, np.tan(seen_well.directions[0]) * turned)
    return PixelReflectances(seen_well, value, deviation, int((~good).sum()))


def _noise(photograph: BallPhotograph, pixel: IntArray) -> FloatArray:
    """The standard deviation of pixels (n,) by their difference from their neighbours: (n, channels). It is a share of
    the brightness, the median over the ball, and what the pixels beside the ball have."""
    channels = photograph.radiance.shape[2]
    neighbours = mean_of_neighbours(photograph.radiance).reshape(-1, channels)
    residual = np.abs(photograph.radiance.reshape(-1, channels) - neighbours) * TO_SIGMA / np.sqrt(1.25)
    axis, _, limb = photograph.sight
    beyond = min(limb + LIMB_MARGIN * pixel_angle(photograph.rays), np.pi)
    dark = photograph.rays.reshape(-1, 3) @ axis <= np.cos(beyond)
    floor = np.median(residual[dark], axis=0) if dark.any() else np.zeros(channels)
    bright = neighbours[pixel] > 3 * floor
    share = np.array([np.median(residual[pixel, k][bright[:, k]] / neighbours[pixel, k][bright[:, k]])
                      if bright[:, k].any() else 0.0 for k in range(channels)])
    return np.asarray(np.hypot(share * np.maximum(neighbours[pixel], 0), floor))
