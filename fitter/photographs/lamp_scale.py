"""How bright the lamps of a description are, by its table `scale`."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from .ball import BallPhotograph
from .descriptions import Description
from .lamps import FAR, Lamp, alike, direction_of
from .light import Light
from .picture_files import read_picture_info
from .pictures import Pictures
from .scale import intensity_of_ball, intensity_of_card
from .table import Table, is_number

SCALES = ("intensity", "albedo", "card", "ball")
_LAMP = "lamp", "direction"


class MeasuredPlace(NamedTuple):
    """What is measured: where it is, (3,), and its size; metres."""

    middle: FloatArray
    size: float


def check(scale: Table, ways: Sequence[str] = SCALES) -> None:
    """Raise DatasetError if a table says none of these ways, or more than one."""
    if sum(map(scale.only(*ways).has, ways)) != 1:
        found = ", ".join(filter(scale.has, ways)) or "nothing"
        raise DatasetError(f"scale has {found}, expected one of {', '.join(ways)}", scale.path)


def intensity_of(scale: Table, pictures: Pictures, channels: int, what: MeasuredPlace, lamps_are_far: bool,
                 photograph: Callable[[Light, FloatArray, FloatArray, str], BallPhotograph] | None = None,
                 ) -> tuple[FloatArray, tuple[str, ...]]:
    """The radiant intensity of lamps, (channels,), W/sr in units of the pictures, and a note of where it is from.

    Of lamps far away the intensity that is given is that at a distance of 1 m, which is their irradiance. `photograph`
    makes one of light, lamp, intensity and name, for a ball of known albedo.
    """
    # of a lamp that brings the irradiance 1
    unit = np.full(channels, (FAR * what.size) ** 2 if lamps_are_far else 1.0)
    if scale.has("albedo"):
        if scale.needed("albedo") > 1:
            raise scale.error("albedo", "more than 0 and at most 1, of what reflects no more than it gets")
        return unit, ("Colours are those that the lamp and the camera give",)
    if scale.has("intensity"):
        given = _intensity(scale)
        if given.ndim and len(given) != channels:
            raise scale.error("intensity", f"a number above 0, or {channels}")
        return unit * given, ("The lamp's intensity as it was given",)
    if scale.has("ball") and photograph is not None:
        known = scale.table("ball").only("file", "exposures", "albedo", *_LAMP)
        white = photograph(pictures.of_lamp(known, "file"), _lamp(known, what, lamps_are_far), unit,
                           known.files("file")[0].name)
        return intensity_of_ball(white, _albedo(known, channels)), ("Scale and colour by a ball of known albedo",)
    card = scale.table("card").only("file", "exposures", "albedo", "normal", "region", *_LAMP)
    part, name = _region(card, pictures), card.files("file")[0]
    try:
        return intensity_of_card(part, what.middle, card.numbers("normal", 3), _lamp(card, what, lamps_are_far),
                                 _albedo(card, channels)), ("Scale and colour by a card of known albedo",)
    except DatasetError as error:
        raise DatasetError(str(error), name) from error


def resolved(scale: Table, what: MeasuredPlace, lamps_are_far: bool) -> Description:
    """The table `scale` with what belongs to the places of lamps far away, in the place of directions."""
    key = next(filter(scale.has, SCALES))
    given = scale.value(key)
    if not lamps_are_far or key == "albedo":
        return {key: given}
    if key == "intensity":
        return {key: (_intensity(scale) * (FAR * what.size) ** 2).tolist()}
    place = Lamp(direction_of(scale.table(key)), True).at(*what)
    return {key: {name: value for name, value in given.items() if name != "direction"} | {"lamp": place.tolist()}}


def _intensity(scale: Table) -> FloatArray:
    """The intensity that is given: (), or (channels,)."""
    value = scale.value("intensity")
    numbers = value if isinstance(value, list) else [value]
    if not numbers or not all(is_number(each) and each > 0 for each in numbers):
        raise scale.error("intensity", "a number above 0, or one for each channel")
    return np.array(value, dtype=float)


def _region(card: Table, pictures: Pictures) -> FloatArray:
    """The radiance of the pixels that a card fills: (n, channels)."""
    left, top, right, bottom = card.numbers("region", 4).astype(int).tolist()
    height, width = read_picture_info(card.files("file")[0]).size
    if not (0 <= left < right <= width and 0 <= top < bottom <= height):
        raise card.error("region", f"left, top, right and bottom within {width} x {height} pixels")
    light = pictures.of_lamp(card, "file", (slice(top, bottom), slice(left, right)))
    part = light.radiance[light.known]
    if not len(part):
        raise DatasetError("the card is saturated", card.files("file")[0])
    return np.asarray(part)


def _lamp(table: Table, what: MeasuredPlace, others_are_far: bool) -> FloatArray:
    """The place of the lamp that lights what is known."""
    lamp = Lamp(direction_of(table), True) if table.has("direction") else Lamp(table.numbers("lamp", 3), False)
    alike([lamp, Lamp(lamp.toward, others_are_far)], table.path)
    return lamp.at(what.middle, what.size)


def _albedo(table: Table, channels: int) -> FloatArray:
    if isinstance(table.value("albedo"), list):
        return table.numbers("albedo", channels)
    return np.full(channels, table.needed("albedo"))
