"""How the measurements of a material are read: as its settings say, into the colour space of the open file."""

import functools
from typing import Any

import bpy
import numpy as np
from mathutils import Color

from ...fitter.colours import COLOURS, DEFAULT, conversion, to_xyz
from ...fitter.formats import choices_of, illuminants, is_there
from ...fitter.formats.reading import ENCODINGS
from . import paths
from .annotations import Arguments
from .properties import AS_THE_FILE_SAYS, READING, Choices

_ISOTROPIC = {"isotropic": True, "anisotropic": False}       # the choices, and the option of `fitter.load`
GREY = "grey"               # in the place of a colour space: the same in every one
_SAME = 0.01                # of the entries of two matrices to XYZ: spaces differ by 0.1, Blender's rounding by 0.0001


def scene_colours() -> str:
    """The linear colour space of the open file, one of `COLOURS`; empty if it is another.

    Since Blender 5.0 a file has its own; before, the OpenColorIO configuration has one for all. Colours are converted
    from either.
    """
    axes = (Color(axis).from_scene_linear_to_xyz_d65() for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    return _named(tuple((axis.r, axis.g, axis.b) for axis in axes))


@functools.cache
def _named(axes: tuple[tuple[float, ...], ...]) -> str:
    """The space whose red, green and blue have these XYZ; empty if it is none of `COLOURS`."""
    mine = np.array(axes).T
    return next((name for name in COLOURS
                 if np.allclose(mine, to_xyz(DEFAULT) @ conversion(name, DEFAULT), rtol=0, atol=_SAME)), "")


def load_arguments(choices: Choices) -> Arguments:
    """The keyword arguments of `fitter.load` that choices, and the open file, ask for."""
    said = {name: getattr(choices, name) for name in ("angles", "quantity", "symmetry")}
    return {**{name: None if value in ("", AS_THE_FILE_SAYS) else value for name, value in said.items()},
            "illuminant": choices.illuminant or illuminants.DEFAULT, "colours": scene_colours() or DEFAULT,
            "isotropic": _ISOTROPIC.get(choices.isotropic),
            "encoding": None if choices.encoding in ("", ENCODINGS[0]) else choices.encoding,
            "keep_unmeasured": choices.keep_unmeasured, "columns": choices.columns or None}


def use_reading(choices: Choices, angles: str | None = None, quantity: str | None = None,
                illuminant: str = illuminants.DEFAULT, isotropic: bool | None = None, symmetry: str | None = None,
                encoding: str | None = None, keep_unmeasured: bool = False, columns: str | None = None) -> None:
    """Choose the options of reading as `fitter.load` has them."""
    choices.angles, choices.quantity = angles or AS_THE_FILE_SAYS, quantity or AS_THE_FILE_SAYS
    choices.symmetry, choices.encoding = symmetry or AS_THE_FILE_SAYS, encoding or ENCODINGS[0]
    choices.illuminant, choices.keep_unmeasured, choices.columns = illuminant, keep_unmeasured, columns or ""
    choices.isotropic = next((name for name, value in _ISOTROPIC.items() if value == isotropic), AS_THE_FILE_SAYS)


def draw_reading(layout: bpy.types.UILayout, choices: Any, path: str) -> None:
    """Draw the options of reading that a file's format has, which few files need, in a closed sub-section."""
    shown = [name for name in READING if name in choices_of(path)]
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
