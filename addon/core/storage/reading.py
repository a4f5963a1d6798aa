"""How the measurements of a material are read: as its settings say, into the colour space of the open file."""

import functools
from typing import Any

import bpy
import numpy as np
from mathutils import Color

from ....fitter.colours import COLOURS, DEFAULT_COLOURS, conversion, xyz_matrix
from ....fitter.formats import is_there, open_choices
from ....fitter.formats.reading import OPTIONS
from ..annotations import Arguments
from . import paths
from .properties import Choices

GREY = "grey"               # in the place of a colour space: the same in every one
_SAME_MATRIX = 0.01         # of the entries of two matrices to XYZ: spaces differ by 0.1, Blender's rounding by 0.0001


def scene_colours() -> str:
    """The linear colour space of the open file, since Blender 5.0, or of all; one of `COLOURS`, or empty."""
    axes = (Color(axis).from_scene_linear_to_xyz_d65() for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return _space_name(tuple((axis.r, axis.g, axis.b) for axis in axes))


@functools.cache
def _space_name(axes: tuple[tuple[float, ...], ...]) -> str:
    """The space whose red, green and blue have these XYZ; empty if it is none of `COLOURS`."""
    mine = np.array(axes).T
    return next((name for name in COLOURS
                 if np.allclose(mine, xyz_matrix(DEFAULT_COLOURS) @ conversion(name, DEFAULT_COLOURS), rtol=0,
                                atol=_SAME_MATRIX)), "")


def load_arguments(choices: Choices) -> Arguments:
    options = {name: option.value(getattr(choices, name)) for name, option in OPTIONS.items()}
    return {**options, "colours": scene_colours() or DEFAULT_COLOURS}


def use_reading(choices: Choices, options: Arguments) -> None:
    for name, option in OPTIONS.items():
        setattr(choices, name, option.to_stored(options.get(name, option.default)))


def draw_reading(layout: bpy.types.UILayout, choices: Any, path: str) -> None:
    """Draw the options of reading that a file's format has, which few files need, in a closed sub-section."""
    shown = [name for name in OPTIONS if name in open_choices(path)]
    if not shown:
        return
    header, body = layout.panel("MEASUREDBRDF_reading", default_closed=True)
    header.label(text="Units and Conventions")
    if body is not None:
        for name in shown:
            body.prop(choices, name)


def other_colours(settings: Any, here: str) -> str:
    """The colour space that a material was fitted for, by its settings, if it is not `scene_colours`; else empty."""
    return "" if settings.colours in (GREY, here) or not here else settings.colours


def has_file(material: bpy.types.Material) -> bool:
    """Whether the measurements of a material are where its settings say, or are a published fit."""
    return bool(material.measured_brdf.filepath) and is_there(paths.absolute(material))
