"""How bright lamps are: their radiant intensity in the units of the pictures, by a description.

A Lambertian of the albedo rho that faces a lamp at the distance d has the radiance rho I / (pi d^2). So a card or a
painted ball of known albedo tells I in each channel, and with it the colour of the lamp and of the camera.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...arrays import ArrayLike, FloatArray
from ...errors import DatasetError
from ...imaging.picture_files import read_picture_info
from ...quality.albedo import DARKEST_SURFACE
from ..description.capture_setup import Known
from ..pictures.reading import Pictures
from .lamps import Scene

GUESSED = "The scale is a guess: an albedo of {} was given"
NEAR_NORMAL = np.radians(60)    # polar angle up to which real paints are Lambertian enough
SHARE_ANGLES = np.arcsin(np.sqrt((np.arange(6) + 0.5) / 6))     # of equal shares of the light that leaves a Lambertian
_BRIGHTEST = 1.02           # share of the light that a white paint may seem to reflect, by its noise


def lamp_intensity(scene: Scene, pictures: Pictures, channels: int,
                   by_ball: Callable[[Known, FloatArray, FloatArray], FloatArray] | None = None,
                   ) -> tuple[FloatArray, tuple[str, ...]]:
    """The radiant intensity of the lamps of a scene, (channels,), W/sr in units of the pictures, and a note of where it
    is from. `by_ball` tells it of a photograph of a ball of known albedo, its lamp, and the intensity that is taken
    for granted."""
    unit, scale, given = np.full(channels, scene.unit), scene.setup.scale, pictures.setup.scale
    if scale.albedo is not None:
        return unit, ("Colours are those that the lamp and the camera give",)
    if scale.intensity is not None:
        if scale.intensity.ndim and len(scale.intensity) != channels:
            raise given.error("intensity", f"a number above 0, or {channels}")
        return np.ones(channels) * scale.intensity, ("The lamp's intensity as it was given",)
    known = scale.ball or scale.card
    assert known is not None
    assert known.lamp is not None
    if known.albedo.ndim and len(known.albedo) != channels:
        raise known.error("albedo", f"a number above 0, or {channels}")
    if scale.ball is not None and by_ball is not None:
        return by_ball(known, known.lamp, unit), ("Scale and colour by a ball of known albedo",)
    assert known.normal is not None
    return (intensity_of_card(_read_region(known, pictures), scene.known_place, known.normal, known.lamp, known.albedo,
                              known.file[0]), ("Scale and colour by a card of known albedo",))


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

    Examples
    --------
    >>> intensity_of_card([0.18 / np.pi], (0, 0, 0), (0, 0, 1), (0, 0, 2), 0.18, "card.exr").round(6).tolist()
    [4.0]
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
