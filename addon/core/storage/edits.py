"""How users want the fit of a material edited: slices say it, and without them no fit is edited."""

from collections.abc import Callable
from typing import NamedTuple

import bpy

from ..annotations import Arguments, as_text

edit_sources: list[Callable[[bpy.types.Material], Arguments]] = []
"""Functions that return keyword arguments of `fitter.edited` for a material."""


class Sliders(NamedTuple):
    """How a slice stores what `edit_sources` return: it rounds arguments as they are stored, and has a material want
    them, which is edited so already."""

    rounded: Callable[[Arguments], Arguments]
    move: Callable[[bpy.types.Material, Arguments], None]


sliders: list[Sliders] = []


def edit_arguments(material: bpy.types.Material) -> Arguments:
    """The keyword arguments of `fitter.edited` that are wanted of a material; empty where nothing is."""
    return {name: value for wanted in edit_sources for name, value in wanted(material).items()}


def is_as_wanted(material: bpy.types.Material) -> bool:
    return (material.measured_brdf.adjusted or as_text({})) == as_text(edit_arguments(material))
