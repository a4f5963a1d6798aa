"""What the panels share: where they are, and how they draw text."""

import textwrap
from typing import Literal

import bpy

_LINE = 52                  # characters


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
    for number, line in enumerate(textwrap.wrap(text, _LINE)):
        layout.label(text=line, icon=icon if number == 0 else "BLANK1")


def draw_warning(layout: bpy.types.UILayout, text: str) -> None:
    """Draw text in a red box."""
    column = layout.box().column(align=True)
    column.alert = True
    draw_wrapped(column, text)
