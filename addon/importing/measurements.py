"""What a material is made from: its file of measurements, how it is fitted, and what the file holds."""

from typing import Any

import bpy

from ...fitter import ColumnsUnknownError, SampleUnknownError
from ...fitter.formats import open_choices
from ...fitter.model import published
from ..core.annotations import not_none
from ..core.blender.active_material import can_change
from ..core.shading import material as materials
from ..core.storage.outcomes import Data
from ..core.storage.properties import OFFERED, is_as_fitted, is_preset
from ..core.storage.reading import draw_reading, other_colours, scene_colours
from ..panel.costs import draw_cost
from ..panel.layout import SubPanel, choices, draw_value, draw_warning, draw_wrapped, has_data, name_beside_value
from ..work import queries
from ..work.job import Job
from . import asking, fit, relink


class MEASUREDBRDF_PT_data(SubPanel, bpy.types.Panel):
    """File, preset and refit; directions, gaps and values of the measurements"""

    bl_label = "Measurements"
    bl_order = 60

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_data(context)

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), not_none(context.material)
        name_beside_value(layout)
        parts = materials.measured_parts(material)
        if parts == [material]:
            draw_source(layout, material)
            _draw_description(layout, queries.data(material))
            return
        for part in parts:
            draw_wrapped(layout, part.name, "MATERIAL")
            _draw_description(layout, queries.data(part))


def _draw_description(layout: bpy.types.UILayout, data: Job[Data]) -> None:
    if data.result is None:
        return
    layout.label(text=data.result.description.name)
    column = layout.column(align=True)
    for label, text, worrying in data.result.description.rows():
        row = column.column(align=True)
        row.alert = worrying
        draw_value(row, label, text, 0.3, "ERROR" if worrying else "NONE")


def draw_source(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings, fitted = material.measured_brdf, materials.is_measured(material)
    body = layout.column()
    body.enabled = can_change(material)
    data = queries.data(material)
    _draw_file(body, settings)
    _draw_state(body, settings, data, fitted)
    _draw_fit(body, settings, data, fitted)


def _draw_file(layout: bpy.types.UILayout, settings: Any) -> None:
    if published.parse_virtual_path(settings.filepath) is not None:
        return
    layout.prop(settings, "filepath")
    if "sample" in open_choices(settings.filepath):
        row = layout.row(align=True)
        row.prop(settings, "sample")
        row.operator_context = "INVOKE_DEFAULT"
        row.operator(asking.MEASUREDBRDF_OT_choose_sample.bl_idname, text="", icon="VIEWZOOM").for_material = True
    draw_reading(layout, settings, settings.filepath)


def _draw_state(layout: bpy.types.UILayout, settings: Any, data: Job[Data], fitted: bool) -> None:
    if data.finished is None:
        layout.label(text="Reading the measurements", icon="TIME")
    elif isinstance(data.error, SampleUnknownError | ColumnsUnknownError):
        draw_warning(layout, str(data.error))
        row = layout.row()
        row.operator_context = "INVOKE_DEFAULT"
        if isinstance(data.error, SampleUnknownError):
            asked = row.operator(asking.MEASUREDBRDF_OT_choose_sample.bl_idname, icon="VIEWZOOM")
            asked.refit = fit.AS_CHOSEN if fitted else ""
        else:
            asked = row.operator(asking.MEASUREDBRDF_OT_name_columns.bl_idname, icon="QUESTION")
            asked.complaint = str(data.error)
        asked.for_material = True
    elif data.error is not None:
        if fitted:
            draw_wrapped(layout, f"The material renders without its measurements. {data.error}", "INFO")
        else:
            draw_warning(layout, str(data.error))
        _draw_relink(layout, fitted)
    elif fitted and (space := other_colours(settings, here := scene_colours())):
        draw_warning(layout, f"Fitted for colours in {space}; those of this file are in {here}. Refit it")
    elif fitted and data.result is not None and data.result.digest != settings.digest:
        draw_warning(layout, "The measurements have changed since the fit. Refit to use them")


def _draw_relink(layout: bpy.types.UILayout, fitted: bool) -> None:
    row = layout.row(align=True)
    for refit, text in ((False, "Relink..."), (True, "Relink and Refit..." if fitted else "Relink and Fit...")):
        row.operator(relink.MEASUREDBRDF_OT_find_file.bl_idname, text=text).refit = refit
    layout.operator(relink.MEASUREDBRDF_OT_find_missing.bl_idname, text="Find Missing Measurements...", icon="VIEWZOOM")


def _draw_fit(layout: bpy.types.UILayout, settings: Any, data: Job[Data], fitted: bool) -> None:
    buttons = choices(layout, OFFERED)
    for name in OFFERED:
        buttons.operator(fit.MEASUREDBRDF_OT_use_preset.bl_idname, text=name,
                         depress=is_preset(settings, name)).preset = name
    row = layout.row(align=True)
    row.scale_y = 1.3
    row.operator(fit.MEASUREDBRDF_OT_fit.bl_idname, text="Refit" if fitted else "Fit", icon="SURFACE_DATA")
    if fitted and not is_as_fitted(settings, None):
        draw_wrapped(layout, "The settings have changed since the fit. Refit to use them", "INFO")
    if not fitted or not is_as_fitted(settings, None if data.result is None else data.result.digest):
        draw_cost(layout, settings, data.result)


classes = (MEASUREDBRDF_PT_data,)
