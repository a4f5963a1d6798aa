"""Presets: named sets of keyword arguments for `fit`, in the order of all lists: from small to exact, then the
paper's."""

from typing import TypedDict

from . import MethodName


class Preset(TypedDict):
    """Keyword arguments for `fit`."""

    diffuse_level: int
    specular_level: int | None
    compression: float
    method: MethodName


PRESETS: dict[str, Preset] = {
    # for look development: at most 6 KiB a channel
    "Draft": {"diffuse_level": 3, "specular_level": 5, "compression": 99.0, "method": "kriging"},
    # for rendering scenes: at most 16 KiB a channel
    "Standard": {"diffuse_level": 4, "specular_level": 5, "compression": 98.2, "method": "kriging"},
    # for narrow highlights: keeps every sample as it was measured
    "Reference": {"diffuse_level": 5, "specular_level": 6, "compression": 98.5, "method": "kriging"},
    # exactly the method of Kameya and Lewis 2002, with the compressed fit that they recommend: (4, 6, 95)
    "Paper": {"diffuse_level": 4, "specular_level": 6, "compression": 95.0, "method": "mba"},
}

PRESET_DESCRIPTIONS: dict[str, str] = {
    "Draft": "A fit of a few KB, for look development: only the smooth shape, without narrow highlights",
    "Standard": "A fit of a few tens of KB, for rendering: close to the measurements, and smooth between them",
    "Reference": "A larger fit: matches every sample, including the narrowest highlights",
    "Paper": "The method and the levels of Kameya and Lewis (2002): highlights can ripple between the measured "
             "directions",
}
