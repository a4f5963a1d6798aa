"""What the panels share: where they are, and how they draw text."""

import textwrap
from collections.abc import Sequence
from typing import Literal

import bpy

from ..materials import material as materials

_Icon = Literal["CHECKMARK", "DOT", "ERROR", "INFO", "MATERIAL"]
_CHARACTER, _MARGIN = 5.9, 60       # pixels at a scale of 1: of a character on average, and beside texts with an icon
_TABS = 30                  # pixels at a scale of 1: of the tabs of a sidebar
_SHORTEST = 20              # line, characters
_NARROW = 40                # characters: less is narrow
_GAP = 2                    # characters between the columns of a table


class MaterialPanel:
    """A mix-in for panels in the material tab, shown where a material has a file of measurements."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and bool(context.material.measured_brdf.filepath)


def has_data(context: bpy.types.Context) -> bool:
    """Whether the material of the context has a file of measurements, or a measured BRDF to show."""
    return context.material is not None and (bool(context.material.measured_brdf.filepath)
                                             or materials.is_shown(context.material))


def draw_row(layout: bpy.types.UILayout, *texts: str) -> None:
    """Draw texts beside one another, in columns of equal width."""
    row = layout.row()
    for text in texts:
        row.label(text=text)


def draw_wrapped(layout: bpy.types.UILayout, text: str, icon: _Icon = "ERROR") -> None:
    """Draw text in several lines, with an icon at the first."""
    column = layout.column(align=True)
    for number, line in enumerate(wrapped(text)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def wrapped(text: str) -> list[str]:
    """Text in lines as wide as the region that is drawn."""
    return textwrap.wrap(text, room())


def draw_warning(layout: bpy.types.UILayout, text: str) -> None:
    """Draw text in a red box."""
    column = layout.box().column(align=True)
    column.alert = True
    draw_wrapped(column, text)


def room() -> int:
    """How many characters fit beside one another into the region that is drawn."""
    region, scale = bpy.context.region, bpy.context.preferences.system.ui_scale
    if region is None:
        return _SHORTEST
    margin = _MARGIN + (_TABS if region.type == "UI" else 0)
    return max(int((region.width / scale - margin) / _CHARACTER), _SHORTEST)


def is_narrow(characters: int = _NARROW) -> bool:
    """Whether so many characters do not fit beside one another into the region that is drawn."""
    return room() < characters


def choices(layout: bpy.types.UILayout, longest: int) -> bpy.types.UILayout:
    """A layout for four buttons, of which the longest text has so many characters: beside one another, if they fit."""
    columns = 2 if is_narrow(4 * (longest + _GAP)) else 4
    return layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)


def draw_table(layout: bpy.types.UILayout, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Draw a table of texts; where the region is too narrow, the rows over one another, each cell with its heading."""
    cells = [headings, *rows]
    widest = max((len(text) for row in cells for text in row), default=0)
    column = layout.column(align=True)
    if not is_narrow(len(headings) * (widest + _GAP)):
        for row in cells:
            draw_row(column, *row)
        return
    for first, *others in rows:
        column.label(text=first)
        for heading, text in zip(headings[1:], others, strict=True):
            draw_value(column, heading, text)
        column.separator()


def draw_value(layout: bpy.types.UILayout, name: str, text: str) -> None:
    """Draw a name and its value beside it."""
    split = layout.split(factor=0.4)
    split.alignment = "RIGHT"
    split.label(text=name)
    split.alignment = "LEFT"
    split.label(text=text)
