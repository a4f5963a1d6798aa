"""How users want the fit of a material edited: slices say it, and without them no fit is edited."""

from collections.abc import Callable

import bpy

from .annotations import Arguments
from .properties import as_text

wanted_by: list[Callable[[bpy.types.Material], Arguments]] = []
"""Functions that return keyword arguments of `fitter.edited` for a material."""


def edit_arguments(material: bpy.types.Material) -> Arguments:
    """The keyword arguments of `fitter.edited` that are wanted of a material; empty where nothing is."""
    return {name: value for wanted in wanted_by for name, value in wanted(material).items()}


def is_as_wanted(material: bpy.types.Material) -> bool:
    """Whether the shader of a material has been edited as is wanted."""
    return (material.measured_brdf.adjusted or as_text({})) == as_text(edit_arguments(material))
