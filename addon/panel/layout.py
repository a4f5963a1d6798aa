"""What the panels share: where they are, and how they draw text."""

import textwrap
from collections.abc import Collection
from functools import lru_cache
from typing import Any, Literal

import blf
import bpy

from ..core.blender.active_material import active_material
from ..core.shading import material as materials
from ..work.job import Job

_Icon = Literal["BLANK1", "CHECKMARK", "DOT", "ERROR", "INFO", "MATERIAL", "NONE"]
_CHARACTER_WIDTH, _MARGIN = 5.9, 60  # pixels at a scale of 1: of a character on average, and beside texts with an icon
_TABS = 30                  # pixels at a scale of 1: of the tabs of a sidebar
_EDGE_PIXELS, _BUTTON = 24, 14  # pixels at a scale of 1: beside buttons, and beside the text of one
_SHORTEST, _LEAST = 20, 8   # characters of a line, where the width is not known, and of the narrowest
_NARROWEST_CHARACTER = 0.3  # of characters on average, in sizes of the font
_NARROW = 40                # characters: less is narrow
_GAP = 2                    # characters between the columns of a table
_UNIT, _LARGEST = 20, 9     # pixels of an icon of the scale 1, and the largest scale
_BESIDE = 40                # pixels of a region beside its pictures


class MaterialPanel:
    """A mix-in for panels in the material tab, shown where a material has a file of measurements."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and bool(context.material.measured_brdf.filepath)


class SubPanel(MaterialPanel):
    """A mix-in for closed panels below the main one, shown where a material is measured, or a mix of such."""

    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.is_shown(context.material)


def has_data(context: bpy.types.Context) -> bool:
    """Whether the material of the context has a file of measurements, or a measured BRDF to show."""
    material = getattr(context, "material", None)
    return material is not None and (bool(material.measured_brdf.filepath) or materials.is_shown(material))


def has_measured(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """For `poll`: whether the active material is measured, or a mix of such."""
    target = active_material(context)
    if target is None or not materials.is_shown(target):
        cls.poll_message_set("There is no active material with a measured BRDF")
        return False
    return True


def name_beside_value(layout: bpy.types.UILayout) -> None:
    """Draw properties as Blender's panels do, without the dots of keyframes."""
    layout.use_property_split = True
    layout.use_property_decorate = False


def draw_wrapped(layout: bpy.types.UILayout, text: str, icon: _Icon = "ERROR") -> None:
    """Draw text in several lines, with an icon at the first."""
    column = layout.column(align=True)
    for number, line in enumerate(wrap_text(text)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


def wrap_text(text: str) -> tuple[str, ...]:
    """Text in lines as wide as the region that is drawn."""
    return _wrap(text, 1, _MARGIN, 0, True)


def on_buttons(text: str, columns: float, beside: int = 0, width: int = 0) -> tuple[str, ...]:
    """The text of a button in lines, each for a button of its own, where buttons stand in so many columns.

    In pixels at a scale of 1: `beside` is what stands beside each, and `width` that of a pop-up, else of the region.
    """
    if bpy.context.region is None:
        return text,
    return _wrap(text, columns, _EDGE_PIXELS, _BUTTON + beside, False, width)


def _wrap(text: str, columns: float, margin: int, beside: int, breaks_words: bool, width: int = 0) -> tuple[str, ...]:
    """Text in lines as wide as a column: of the region without a margin, and each without what is beside the text."""
    region, preferences = bpy.context.region, bpy.context.preferences
    if region is None:
        return _broken(text, _SHORTEST, True)
    scale = preferences.system.ui_scale
    whole = scale * width or region.width - scale * (margin + _tabs(region))
    size = scale * preferences.ui_styles[0].widget.points
    return _lines(text, int(whole / columns - scale * beside), size, breaks_words)


def fits(text: str) -> bool:
    return bpy.context.region is None or len(wrap_text(text)) == 1


@lru_cache(maxsize=512)
def _lines(text: str, width: int, size: float, breaks_words: bool) -> tuple[str, ...]:
    """Text in lines of so many pixels, by the font of the interface; the longest lines of equally many characters."""
    blf.size(0, size)
    for characters in range(min(len(text), int(width / size / _NARROWEST_CHARACTER)), _LEAST, -1):
        lines = _broken(text, characters, breaks_words)
        if all(blf.dimensions(0, line)[0] <= width for line in lines):
            return lines
    return _broken(text, _LEAST, breaks_words)


def _broken(text: str, characters: int, breaks_words: bool) -> tuple[str, ...]:
    return tuple(textwrap.wrap(text, characters, break_long_words=breaks_words))


def draw_warning(layout: bpy.types.UILayout, text: str) -> None:
    column = layout.box().column(align=True)
    column.alert = True
    draw_wrapped(column, text)


def draw_picture(layout: bpy.types.UILayout, icon: int, job: Job[Any], scale: float) -> None:
    """Draw a picture, or until there is one how far it is: a slider below stays in its place while it is dragged."""
    if icon:
        layout.template_icon(icon_value=icon, scale=scale)
    elif job.finished is None:
        layout.progress(factor=job.fraction, text=job.doing)
    if job.error is not None:
        draw_warning(layout, str(job.error))


def picture_button(layout: bpy.types.UILayout, operator: str, icon: int, scale: float) -> Any:
    """A picture that is a button: its properties.

    Blender's pictures are no buttons. One that is not seen lies over the picture, after a gap of negative height.
    """
    layout.template_icon(icon_value=icon, scale=scale)
    back, over = layout.column(), layout.column()
    back.scale_y, over.scale_y = -scale, scale
    back.label(text="")
    return over.operator(operator, text="", emboss=False)


def room() -> int:
    """How many characters fit beside one another into the region that is drawn."""
    region, scale = bpy.context.region, bpy.context.preferences.system.ui_scale
    if region is None:
        return _SHORTEST
    return max(int((region.width / scale - _MARGIN - _tabs(region)) / _CHARACTER_WIDTH), _SHORTEST)


def _tabs(region: bpy.types.Region) -> int:
    return _TABS if region.type == "UI" else 0


def is_narrow(characters: int = _NARROW) -> bool:
    """Whether so many characters do not fit beside one another into the region that is drawn."""
    return room() < characters


def choices(layout: bpy.types.UILayout, texts: Collection[str]) -> bpy.types.UILayout:
    """A layout for buttons with these texts: as many beside one another as fit, in rows that are nearly full."""
    columns, rows = len(texts), 1
    while columns > 1 and is_narrow(columns * (max(map(len, texts)) + _GAP)):
        rows += 1
        columns = -(-len(texts) // rows)
    return layout.grid_flow(row_major=True, columns=columns, even_columns=True, even_rows=True, align=True)


def draw_value(layout: bpy.types.UILayout, name: str, text: str, share: float = 0.4, icon: _Icon = "NONE") -> None:
    """Draw a name and its value beside it; below it, in as many lines as it takes, where one of them would be cut.

    `share` is that of the name in the width; of less than 0.4 names begin at the left.
    """
    if len(on_buttons(name, 1 / share)) > 1 or len(on_buttons(text, 1 / (1 - share))) > 1:
        layout.label(text=name)
        draw_wrapped(layout, text, "BLANK1" if icon == "NONE" else icon)
        return
    split = layout.split(factor=share)
    split.alignment = "RIGHT" if share >= 0.4 else "EXPAND"
    split.label(text=name)
    split.alignment = "LEFT"
    split.label(text=text, icon=icon)


def picture_scale(context: bpy.types.Context, columns: int, largest: float = _LARGEST) -> float:
    """The scale of pictures that share the width of the region in this many columns."""
    region = context.region
    if region is None:
        return largest
    width = region.width / context.preferences.system.ui_scale
    return min(max((width - _BESIDE) / columns / _UNIT, 3.0), largest)
