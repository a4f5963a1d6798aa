"""A material beside the pinned one: a split sphere, two curves, and numbers side by side; and renders of both."""

import math
from typing import Any

import bpy

from ...fitter.pictures import PAIR, split
from ...fitter.quality import verdict
from ..core import material as materials
from ..core import rendered
from ..core.annotations import present
from ..panel.layout import MaterialPanel, draw_picture, draw_row, draw_wrapped, is_narrow, picture_scale
from ..work import modal
from . import looks
from . import questions as compared
from . import settings as comparison
from .operators import SIZE, MEASUREDBRDF_OT_pin, MEASUREDBRDF_OT_render_look

_HEADINGS = "", "A", "B"
_TWO_ABREAST = 36           # characters that two pictures, or two columns of numbers, need beside one another


class MeasuredPanel(MaterialPanel):
    """A mix-in for panels shown where a material has a measured BRDF, whether or not its measurements are there."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.group_node(context.material) is not None


class MEASUREDBRDF_PT_compare_with(MeasuredPanel, bpy.types.Panel):
    """This material beside another one"""

    bl_label = "Compare With"
    bl_order = 30
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = present(self.layout), present(context.scene), present(context.material)
        chosen = comparison.of(scene)
        row = layout.row(align=True)
        row.prop(chosen, "pinned", text="")
        row.operator(MEASUREDBRDF_OT_pin.bl_idname, text="", icon="PINNED")
        other = comparison.pinned(scene, material)
        if other is None:
            text = ("This is the pinned material: choose another one to compare it with" if chosen.pinned == material
                    else "Choose a measured material, or pin this one and choose another")
            draw_wrapped(layout, text, "INFO")
            return
        _draw_names(layout, material, other)
        _draw_pictures(layout, context, material, other)
        columns = [_numbers(each, scene) for each in (material, other)]
        rows = [(name, mine, columns[1][name]) for name, mine in columns[0].items()]
        column = layout.column(align=True)
        if is_narrow(_TWO_ABREAST):
            for name, *values in rows:
                column.label(text=name)
                draw_row(column, *(f"{heading}: {value}" for heading, value in zip(_HEADINGS[1:], values, strict=True)))
            return
        for name, *values in (_HEADINGS, *rows):
            parts = column.split(factor=0.4)
            parts.label(text=name)
            draw_row(parts, *values)


class MEASUREDBRDF_PT_look(MeasuredPanel, bpy.types.Panel):
    """A render by Cycles, on a sphere or a shader ball, with the pinned material beside it"""

    bl_label = "Test Render"
    bl_order = 40
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = present(self.layout), present(context.scene), present(context.material)
        chosen = comparison.of(scene)
        layout.row().prop(chosen, "shape", expand=True)
        layout.row().prop(chosen, "lighting", expand=True)
        other = comparison.pinned(scene, material)
        wanted = [material] if other is None else [material, other]
        keys = tuple(looks.key(scene, each, SIZE) for each in wanted)
        pictures = [looks.known(key) for key in keys]
        known = [picture for picture in pictures if picture is not None]
        row = layout.row()
        row.enabled = modal.running is None
        row.operator(MEASUREDBRDF_OT_render_look.bl_idname, text="Render Both" if other is not None else "Render",
                     icon="RENDER_STILL")
        if len(known) < len(wanted):
            return
        picture = known[0]
        if other is not None:
            picture = split(*((known[1], picture) if chosen.flipped else (picture, known[1])), chosen.divide)
        name = "look" if other is None else f"looks {chosen.flipped} {chosen.divide:.2f}"
        layout.template_icon(icon_value=looks.icon(name, keys, picture), scale=picture_scale(context, 1, 16))
        if other is not None:
            _draw_line(layout, chosen)
            _draw_names(layout, material, other)


def _draw_names(layout: bpy.types.UILayout, material: bpy.types.Material, other: bpy.types.Material) -> None:
    column = layout.column(align=True)
    for letter, each, color in zip("AB", (material, other), PAIR, strict=True):
        column.label(text=f"{letter}: {each.name}", icon_value=compared.swatch(color))


def _draw_line(layout: bpy.types.UILayout, chosen: Any) -> None:
    row = layout.row(align=True)
    row.label(text="B | A" if chosen.flipped else "A | B")
    row.prop(chosen, "divide", text="", slider=True)
    row.prop(chosen, "flipped", text="", icon="ARROW_LEFTRIGHT")


def _draw_pictures(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material,
                   other: bpy.types.Material) -> None:
    chosen = comparison.of(present(context.scene))
    columns = 1 if is_narrow(_TWO_ABREAST) else 2
    scale = picture_scale(context, columns)
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True)
    left, right = (other, material) if chosen.flipped else (material, other)
    column = grid.column()
    draw_picture(column, *compared.split_sphere(left, right, chosen.divide), scale)
    _draw_line(column, chosen)
    column = grid.column()
    draw_picture(column, *compared.polar(material, other, chosen.theta), scale)
    column.prop(chosen, "theta", slider=True)


def _numbers(material: bpy.types.Material, scene: bpy.types.Scene) -> dict[str, str]:
    """The numbers of a material as text, by name, as far as they are known."""
    settings, figures = material.measured_brdf, compared.figures(material)
    error = f"{rendered.in_scene(material, scene).error:.1%}"
    wait = "..." if figures.finished is None else "-"
    found = figures.result
    fitted = settings.coefficients > 0
    return {"Match": verdict.grade(settings.match, verdict.MATCH_LIMITS) if settings.match >= 0 else "-",
            "Between Angles": verdict.grade(settings.between, verdict.BETWEEN_LIMITS) if settings.between >= 0 else "-",
            "Coefficients": f"{found.coefficients:,}" if found is not None else wait,
            "Bytes": f"{found.nbytes:,}" if found is not None else wait,
            "RMSE": f"{settings.rmse:.3g}" if fitted and math.isfinite(settings.rmse) else "-",
            "Albedo %": _percent(found.albedo) if found is not None else wait,
            "Highlight Error": error}


def _percent(albedo: Any) -> str:
    shown = [f"{100 * each:.0f}" for each in albedo]
    return shown[0] if len(set(shown)) == 1 else " ".join(shown)


classes = (MEASUREDBRDF_PT_compare_with, MEASUREDBRDF_PT_look)
