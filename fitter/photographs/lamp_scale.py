"""How bright the lamps of a description are."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from .ball import BallPhotograph
from .description.capture_setup import Known, ScaleSetup
from .lamps import FAR, Lamp, alike, placed_lamp
from .light import Light
from .picture_files import read_picture_info
from .pictures import Pictures
from .scale import intensity_of_ball, intensity_of_card


class MeasuredPlace(NamedTuple):
    """What is measured: where it is, (3,), and its size; metres."""

    middle: FloatArray
    size: float


def intensity_of(scale: ScaleSetup, pictures: Pictures, channels: int, what: MeasuredPlace, lamps_are_far: bool,
                 photograph: Callable[[Light, FloatArray, FloatArray, str], BallPhotograph] | None = None,
                 ) -> tuple[FloatArray, tuple[str, ...]]:
    """The radiant intensity of lamps, (channels,), W/sr in units of the pictures, and a note of where it is from.

    Of lamps far away the intensity that is given is that at a distance of 1 m, which is their irradiance. `photograph`
    makes one of light, lamp, intensity and name, for a ball of known albedo.
    """
    # of a lamp that brings the irradiance 1
    unit = np.full(channels, (FAR * what.size) ** 2 if lamps_are_far else 1.0)
    if scale.albedo is not None:
        return unit, ("Colours are those that the lamp and the camera give",)
    if scale.intensity is not None:
        if scale.intensity.ndim and len(scale.intensity) != channels:
            raise scale.error("intensity", f"a number above 0, or {channels}")
        return unit * scale.intensity, ("The lamp's intensity as it was given",)
    known = scale.ball or scale.card
    assert known is not None
    lamp, albedo = _lamp(known, what, lamps_are_far), known.albedo
    if albedo.ndim and len(albedo) != channels:
        raise known.error("albedo", f"a number above 0, or {channels}")
    if scale.ball is not None and photograph is not None:
        white = photograph(pictures.of_lamp(known, "file"), lamp, unit, known.file[0].name)
        return intensity_of_ball(white, albedo), ("Scale and colour by a ball of known albedo",)
    part = _region(known, pictures)
    try:
        assert known.normal is not None
        return (intensity_of_card(part, what.middle, known.normal, lamp, albedo),
                ("Scale and colour by a card of known albedo",))
    except DatasetError as error:
        raise DatasetError(str(error), known.file[0]) from error


def resolved(scale: ScaleSetup, what: MeasuredPlace, lamps_are_far: bool) -> ScaleSetup:
    """The scale with what belongs to the places of lamps far away, in the place of directions."""
    if not lamps_are_far or scale.albedo is not None:
        return scale
    if scale.intensity is not None:
        return replace(scale, intensity=scale.intensity * (FAR * what.size) ** 2)
    card, ball = (each and replace(each, lamp=placed_lamp(each, what.middle).at(*what), direction=None)
                  for each in (scale.card, scale.ball))
    return replace(scale, card=card, ball=ball)


def _region(card: Known, pictures: Pictures) -> FloatArray:
    """The radiance of the pixels that a card fills: (n, channels)."""
    height, width = read_picture_info(card.file[0]).size
    left, top, right, bottom = (0, 0, 0, 0) if card.region is None else card.region.astype(int).tolist()
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        raise card.error("region", f"left, top, right and bottom within {width} x {height} pixels")
    light = pictures.of_lamp(card, "file", (slice(top, bottom), slice(left, right)))
    part = light.radiance[light.known]
    if not len(part):
        raise DatasetError("the card is saturated", card.file[0])
    return np.asarray(part)


def _lamp(known: Known, what: MeasuredPlace, others_are_far: bool) -> FloatArray:
    """The place of the lamp that lights what is known."""
    lamp = placed_lamp(known, what.middle)
    alike([lamp, Lamp(lamp.toward, others_are_far)], known.path)
    return lamp.at(*what)
