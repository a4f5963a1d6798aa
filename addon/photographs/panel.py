"""The panel of a scene with photographs of a ball or of a flat sample, in the sidebar of the 3D view."""

import math
from functools import partial
from typing import Any

import bpy

from ..core.annotations import not_none
from ..core.blender.previews import image_pixels
from ..core.storage.properties import draw_presets
from ..panel.layout import draw_warning, draw_wrapped, name_beside_value, picture_scale
from ..panel.main import draw_running
from ..work import icons
from . import describing, flat, operators
from . import settings as photographs
from .comparison import TIMES
from .settings import CARD, CHOSEN, GUESS, INTENSITY, WHITE_BALL

_ROWS, _NAME = 5, 12        # of the list; letters of a name that it has room for
_CORNERS = "Bottom Left", "Bottom Right", "Top Right", "Top Left"
_SIDES = "Region Left", "Top", "Right", "Bottom"


class MEASUREDBRDF_UL_photographs(bpy.types.UIList):
    """The photographs of a scene, and the angle of each lamp from the camera, or from a sample's normal"""

    def draw_item(self, _context: bpy.types.Context, layout: bpy.types.UILayout, data: Any, item: Any, _icon: int,
                  _active_data: Any, _active_property: str) -> None:
        row = layout.row()
        row.use_property_split = False
        row.prop(item, "used", text="")
        # of a series names differ at their ends
        row.label(text=item.name if len(item.name) <= _NAME else f"…{item.name[-_NAME:]}")
        lamp = item.lamp
        if lamp is not None and None not in (photographs.surface(data), data.camera):
            placed = describing.is_placed(lamp)
            row.label(text=f"{math.degrees(describing.phase_angle(data, lamp)):.0f}°" if placed else "not placed",
                      icon="NONE" if placed else "ERROR")


class _Sidebar:
    """What the panels share: where they are, and when."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Measured BRDF"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(photographs.get(not_none(context.scene)).photographs)


class MEASUREDBRDF_PT_photographs(_Sidebar, bpy.types.Panel):
    """Photographs of a ball or a flat sample, of which its material is measured"""

    bl_label = "Measure Photographs"

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = _layout(self), photographs.get(not_none(context.scene))
        row = layout.row()
        row.template_list(MEASUREDBRDF_UL_photographs.__name__, "", settings, "photographs", settings, "active",
                          rows=_ROWS)
        row.operator(operators.MEASUREDBRDF_OT_measure_photographs.bl_idname, text="", icon="ADD").to_scene = True
        _draw_photograph(layout, photographs.active(settings), photographs.is_flat(settings))
        _draw_work(layout, settings)


def _layout(panel: Any) -> bpy.types.UILayout:
    layout = not_none(panel.layout)
    name_beside_value(layout)
    return layout


def _draw_photograph(layout: bpy.types.UILayout, shot: Any, is_flat: bool) -> None:
    column = layout.column(align=True)
    for file in shot.files:
        column.prop(file, "filepath", text="File")
        if len(shot.files) > 1:
            column.prop(file, "exposure")
    if shot.lamp is None:
        draw_warning(layout, f"The lamp of {shot.name} has been deleted")
        return
    column = layout.column(align=True)
    column.prop(shot.lamp, "location", text="Lamp")
    if is_flat:
        column.prop(shot, "brightness")
    column.operator(operators.MEASUREDBRDF_OT_place_lamp.bl_idname, icon="SHADING_RENDERED",
                    text="By Chrome Balls or Positions...")


def _draw_work(layout: bpy.types.UILayout, settings: Any) -> None:
    """Draw what is done with the photographs; while a job runs its progress."""
    if draw_running(layout.row(align=True)):
        return
    if photographs.is_flat(settings):
        layout.operator(operators.MEASUREDBRDF_OT_fit_outline.bl_idname, icon="MESH_PLANE", text="Camera by Corners")
        layout.operator(flat.MEASUREDBRDF_OT_measure_sample.bl_idname, icon="MATERIAL")
    else:
        layout.operator(operators.MEASUREDBRDF_OT_fit_outline.bl_idname, icon="MESH_CIRCLE")
        draw_presets(layout, settings)
        layout.operator(operators.MEASUREDBRDF_OT_measure_ball.bl_idname, icon="MATERIAL")
    if settings.scale == GUESS:
        draw_wrapped(layout, "The scale is a guess", "INFO")


class MEASUREDBRDF_PT_photographs_stage(_Sidebar, bpy.types.Panel):
    """Camera, ball or sample, and lamp, and how the files are read"""

    bl_label = "Camera, Lamps and Files"
    bl_parent_id = "MEASUREDBRDF_PT_photographs"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = _layout(self), photographs.get(not_none(context.scene))
        if settings.camera is not None:
            if photographs.is_flat(settings):
                layout.prop(settings, "is_far", text="Camera Far Away")
            else:
                layout.prop(settings.camera, "location", text="Camera")
            column = layout.column(align=True)
            column.prop(settings.camera.data, "lens")
            column.prop(settings.camera.data, "sensor_width", text="Sensor Width")
        if settings.ball is not None:
            layout.prop(settings.ball, "location", text="Ball")
            layout.prop(settings, "radius")
        lamp = photographs.active(settings).lamp
        if lamp is not None:
            layout.prop(lamp.data, "shadow_soft_size", text="Lamp Radius")
        is_flat = photographs.is_flat(settings)
        for name in ("dark", "flat", "chrome_mask", *(("finds_brightness",) if is_flat else ("mask",)), "encoding",
                     "matrix", *(() if is_flat else ("samples",))):
            layout.prop(settings, name)


class MEASUREDBRDF_PT_photographs_sample(_Sidebar, bpy.types.Panel):
    """Where the flat sample is in the photographs, and what is made of it"""

    bl_label = "Sample"
    bl_parent_id = "MEASUREDBRDF_PT_photographs"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return photographs.is_flat(photographs.get(not_none(context.scene)))

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = _layout(self), photographs.get(not_none(context.scene))
        column = layout.column(align=True)
        if settings.sample is not None:
            column.prop(settings, "width")
            column.prop(settings, "height")
        layout.prop(settings, "drawn_corners")
        if settings.drawn_corners is None:
            column = layout.column(align=True)
            for number, corner in enumerate(_CORNERS):
                row = column.row(align=True)
                row.prop(settings, "corners", index=2 * number, text=corner)
                row.prop(settings, "corners", index=2 * number + 1, text="")
        for name in ("mask", "drawn_outline", "texels", "tile", "count"):
            layout.prop(settings, name)
        chosen = [name for name in CHOSEN if getattr(settings, name) is not None]
        for name in CHOSEN[:len(chosen) + 1]:
            layout.prop(settings, name)


class MEASUREDBRDF_PT_photographs_scale(_Sidebar, bpy.types.Panel):
    """How bright the lamp is"""

    bl_label = "Scale"
    bl_parent_id = "MEASUREDBRDF_PT_photographs"

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = _layout(self), photographs.get(not_none(context.scene))
        layout.prop(settings, "scale", text="By")
        fields = {GUESS: ("albedo",), INTENSITY: ("intensity",), WHITE_BALL: ("known", "known_albedo", "known_lamp"),
                  CARD: ("known", "known_albedo", "known_lamp", "normal")}[settings.scale or GUESS]
        for name in fields:
            if name != "normal" or not photographs.is_flat(settings):
                layout.prop(settings, name)
        if settings.scale == CARD:
            column = layout.column(align=True)
            for number, side in enumerate(_SIDES):
                column.prop(settings, "region", index=number, text=side)
        if settings.known and settings.scale in (WHITE_BALL, CARD):
            layout.prop(settings, "known_exposure")
        if settings.scale == GUESS:
            draw_wrapped(layout, "Colours are those of lamp and camera, and the scale is a guess. A grey card or a "
                                 "white ball has both right", "INFO")


class MEASUREDBRDF_PT_photographs_coverage(_Sidebar, bpy.types.Panel):
    """What the photographs have measured, and where to put the next lamp"""

    bl_label = "Report"
    bl_parent_id = "MEASUREDBRDF_PT_photographs"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(photographs.get(not_none(context.scene)).told)

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = _layout(self), photographs.get(not_none(context.scene))
        doubts = settings.doubts.splitlines()
        for line in settings.told.splitlines():
            draw_wrapped(layout, line, "ERROR" if line in doubts else "DOT")
            if "Values" in line:        # the setting that the line is about
                layout.prop(settings, "encoding")


class MEASUREDBRDF_PT_photographs_comparison(_Sidebar, bpy.types.Panel):
    """Ball or sample as it is rendered beside the photograph"""

    bl_label = "Comparison"
    bl_parent_id = "MEASUREDBRDF_PT_photographs"

    def draw(self, context: bpy.types.Context) -> None:
        layout, shot = _layout(self), photographs.active(photographs.get(not_none(context.scene)))
        layout.operator(operators.MEASUREDBRDF_OT_compare_photograph.bl_idname, icon="RENDER_STILL")
        if shot.comparison is None:
            return
        icon = icons.draw_at_once(("photograph", shot.comparison.session_uid, shot.difference),
                             partial(image_pixels, shot.comparison))
        layout.template_icon(icon_value=icon, scale=picture_scale(context, 1, 16))
        column = layout.column(align=True)
        judged = photographs.judge_render(shot.name, shot.difference)
        draw_wrapped(column, judged.words, "ERROR" if judged.is_bad else "DOT")
        draw_wrapped(column, f"Photograph and render; half of each, and what differs, {TIMES} times as bright", "DOT")


classes = (MEASUREDBRDF_UL_photographs, MEASUREDBRDF_PT_photographs, MEASUREDBRDF_PT_photographs_sample,
           MEASUREDBRDF_PT_photographs_scale,
           MEASUREDBRDF_PT_photographs_coverage, MEASUREDBRDF_PT_photographs_comparison,
           MEASUREDBRDF_PT_photographs_stage)
