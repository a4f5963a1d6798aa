"""Leads users from their first import to the panel of the material."""

import contextlib
from collections.abc import Sequence

import bpy

from ..materials import material as materials


def show_first(context: bpy.types.Context, made: Sequence[bpy.types.Material]) -> None:
    """Show the material tab in the properties editors of the window, if these are the first measured materials."""
    if context.window is None or any(materials.is_measured(item) for item in bpy.data.materials if item not in made):
        return
    for area in context.window.screen.areas:
        if area.type == "PROPERTIES":
            with contextlib.suppress(TypeError):        # there is no such tab: the active object has no materials
                area.spaces.active.context = "MATERIAL"
