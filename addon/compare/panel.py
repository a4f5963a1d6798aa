"""A material beside the pinned one: a split sphere, two curves, and numbers side by side; and renders of both."""

import math
from functools import partial
from typing import Any, cast

import bpy
import numpy as np

from ...fitter.arrays import SingleArray
from ...fitter.drawing import Color
from ...fitter.pictures import PAIR, split
from ...fitter.quality import verdict
from ..core import material as materials
from ..core import rendered
from ..core.annotations import not_none
from ..panel.layout import MaterialPanel, draw_picture, draw_row, draw_wrapped, is_narrow, picture_scale
from ..work import icons, queries, queue
from ..work.job import Job
from . import looks
from . import settings as comparison
from . import work as comparisons
from .operators import MEASUREDBRDF_OT_pin, MEASUREDBRDF_OT_render_look

_HEADINGS = "", "A", "B"
_TWO_ABREAST = 36           # characters that two pictures, or two columns of numbers, need beside one another


class MeasuredPanel(MaterialPanel):
    """A mix-in for panels shown where a material has a measured BRDF, whether or not its measurements are there, or is
    a mix of some."""

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.is_shown(context.material)


class MEASUREDBRDF_PT_compare_with(MeasuredPanel, bpy.types.Panel):
    """This material beside another one"""

    bl_label = "Compare With"
    bl_order = 30
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = not_none(self.layout), not_none(context.scene), not_none(context.material)
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
            parts = column.split(factor=0.48)
            parts.label(text=name)
            draw_row(parts, *values)


class MEASUREDBRDF_PT_look(MeasuredPanel, bpy.types.Panel):
    """A render by Cycles, on a sphere or a shader ball, with the pinned material beside it"""

    bl_label = "Test Render"
    bl_order = 40
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = not_none(self.layout), not_none(context.scene), not_none(context.material)
        chosen = comparison.of(scene)
        layout.row().prop(chosen, "shape", expand=True)
        layout.row().prop(chosen, "lighting", expand=True)
        other = comparison.pinned(scene, material)
        wanted = [material] if other is None else [material, other]
        renders = [render for each in wanted if (render := looks.known(looks.key(scene, each))) is not None]
        layout.operator(MEASUREDBRDF_OT_render_look.bl_idname, text="Render Both" if other is not None else "Render",
                        icon="RENDER_STILL")
        if len(renders) < len(wanted):
            return
        key = ("look", *(render.number for render in renders), round(chosen.divide, 2))
        icon = icons.at_once(key, lambda: _side_by_side([render.picture for render in renders], chosen.divide))
        layout.template_icon(icon_value=icon, scale=picture_scale(context, 1, 16))
        if other is not None:
            _draw_line(layout, chosen)
            _draw_names(layout, material, other)


def _side_by_side(pictures: list[SingleArray], at: float) -> SingleArray:
    return split(pictures[0], pictures[1], at) if len(pictures) > 1 else pictures[0]


def _draw_names(layout: bpy.types.UILayout, material: bpy.types.Material, other: bpy.types.Material) -> None:
    column = layout.column(align=True)
    for letter, each, color in zip("AB", (material, other), PAIR, strict=True):
        column.label(text=f"{letter}: {each.name}", icon_value=_swatch(color))


def _swatch(color: Color) -> int:
    return icons.at_once(("swatch", color), lambda: np.full((16, 16, 4), (*color, 1), dtype=np.float32))


def _draw_line(layout: bpy.types.UILayout, chosen: Any) -> None:
    row = layout.row(align=True)
    row.label(text="A | B")
    row.prop(chosen, "divide", text="", slider=True)


def _draw_pictures(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material,
                   other: bpy.types.Material) -> None:
    chosen = comparison.of(not_none(context.scene))
    columns = 1 if is_narrow(_TWO_ABREAST) else 2
    scale = picture_scale(context, columns)
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True)
    first, second = _shown(material), _shown(other)
    column, at = grid.column(), round(chosen.divide, 2)
    draw_picture(column, *icons.icon(("split", (first.digest, second.digest), at),
                                     partial(comparisons.split_sphere, first, second, at)), scale)
    _draw_line(column, chosen)
    column, settings = grid.column(), material.measured_brdf
    theta = round(settings.shown_theta, 3)
    draw_picture(column, *icons.icon(("polar of two", (first.digest, second.digest), theta),
                                     partial(comparisons.polar, first, second, theta)), scale)
    column.prop(settings, "shown_theta", slider=True)


def _numbers(material: bpy.types.Material, scene: bpy.types.Scene) -> dict[str, str]:
    """The numbers of a material as text, by name, as far as they are known."""
    settings, shown = material.measured_brdf, _shown(material)
    figures: Job[comparisons.Figures] = queue.ask(("figures", shown.digest), partial(comparisons.figures, shown))
    parts = [part.measured_brdf for part in materials.measured_parts(material)]
    error = f"{rendered.in_scene(material, scene).error:.1%}"
    wait = "..." if figures.finished is None else "-"
    fitted, known = settings.coefficients > 0, figures.result
    return {"Match": _worst([part.match for part in parts], verdict.MATCH_LIMITS),
            "Between Measured Angles": _worst([part.between for part in parts], verdict.BETWEEN_LIMITS),
            "Coefficients": f"{known.coefficients:,}" if known is not None else wait,
            "Bytes": f"{known.nbytes:,}" if known is not None else wait,
            "RMSE": f"{settings.rmse:.3g}" if fitted and math.isfinite(settings.rmse) else "-",
            "Albedo %": _percent(known.albedo) if known is not None else wait,
            "Highlight Error": error}


def _shown(material: bpy.types.Material) -> comparisons.Shown:
    return cast(comparisons.Shown, queries.shown(material))


def _worst(errors: list[float], limits: tuple[float, ...]) -> str:
    """The grade of the worst of a mix's parts, or of the one material, where all are known."""
    return verdict.grade(max(errors), limits) if min(errors, default=-1) >= 0 else "-"


def _percent(albedo: Any) -> str:
    shown = [f"{100 * each:.0f}" for each in albedo]
    return shown[0] if len(set(shown)) == 1 else " ".join(shown)


classes = (MEASUREDBRDF_PT_compare_with, MEASUREDBRDF_PT_look)
