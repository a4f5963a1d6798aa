"""What the panels share: where they are, and how they draw text."""

import textwrap
from typing import Literal

import bpy

_CHARACTER, _MARGIN = 5.6, 75       # pixels at a scale of 1: of a character on average, and beside texts with an icon
_SHORTEST = 20              # line, characters


class MaterialPanel:
    """A mix-in for panels in the material tab, shown where a material has a file of measurements."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and bool(context.material.measured_brdf.filepath)


def draw_row(layout: bpy.types.UILayout, *texts: str) -> None:
    """Draw texts beside one another, in columns of equal width."""
    row = layout.row()
    for text in texts:
        row.label(text=text)


def draw_wrapped(layout: bpy.types.UILayout, text: str, icon: Literal["ERROR", "INFO"] = "ERROR") -> None:
    """Draw text in several lines, with an icon at the first."""
    for number, line in enumerate(wrapped(text)):
        layout.label(text=line, icon=icon if number == 0 else "BLANK1")


def wrapped(text: str) -> list[str]:
    """Text in lines as wide as the region that is drawn."""
    region, scale = bpy.context.region, bpy.context.preferences.system.ui_scale
    room = (region.width / scale - _MARGIN) / _CHARACTER if region is not None else 0
    return textwrap.wrap(text, max(int(room), _SHORTEST))


def draw_warning(layout: bpy.types.UILayout, text: str) -> None:
    """Draw text in a red box."""
    column = layout.box().column(align=True)
    column.alert = True
    draw_wrapped(column, text)
