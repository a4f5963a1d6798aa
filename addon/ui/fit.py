"""The main panel: the file, the settings of the fit, and its result."""

import math
from typing import Any

import bpy

from ...fitter import PRESETS
from .. import manual, versions
from ..annotations import present
from ..jobs import modal, queries, tasks
from ..jobs.job import Job
from ..materials import material as materials
from ..materials.properties import NO_SPECULAR_LEVEL, is_preset
from ..materials.reading import draw_reading, other_colours, scene_colours
from ..operators import assets, fit, import_data, presets, samples, update
from .comparison import draw_cost
from .layout import MaterialPanel, draw_warning, draw_wrapped, wrapped


class MEASUREDBRDF_PT_material(MaterialPanel, bpy.types.Panel):
    """A material of measured reflectance"""

    bl_label = "Measured BRDF"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and hasattr(context.object.data, "materials")

    def draw_header_preset(self, _context: bpy.types.Context) -> None:
        manual.draw_link(present(self.layout))

    def draw(self, context: bpy.types.Context) -> None:
        layout = present(self.layout)
        layout.use_property_split = True
        layout.use_property_decorate = False
        if modal.running is not None:
            _draw_progress(layout, modal.running)
        if context.material is None:
            layout.operator(import_data.MEASUREDBRDF_OT_import_data.bl_idname, icon="IMPORT")
            return
        settings = context.material.measured_brdf
        column = layout.column()
        column.prop(settings, "filepath")
        row = column.row(align=True)
        row.prop(settings, "sample")
        row.operator_context = "INVOKE_DEFAULT"
        row.operator(samples.MEASUREDBRDF_OT_choose_sample.bl_idname, text="", icon="VIEWZOOM").for_material = True
        fitted = materials.is_measured(context.material)
        if not settings.filepath:
            layout.operator(import_data.MEASUREDBRDF_OT_import_data.bl_idname, icon="IMPORT")
            return
        draw_reading(layout, settings)
        data = queries.data(context.material)
        _draw_version(layout, context.material)
        _draw_data_state(layout, settings, data, fitted)
        _draw_choices(layout, settings)
        draw_cost(layout, settings, data.result)
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.enabled = modal.running is None
        row.operator(fit.MEASUREDBRDF_OT_fit.bl_idname, text="Refit" if fitted else "Fit", icon="SURFACE_DATA")
        if fitted:
            _draw_result(layout.box(), settings, materials.tangent_input(context.material) is not None)
            layout.operator(assets.MEASUREDBRDF_OT_save_asset.bl_idname, icon="ASSET_MANAGER")


def _draw_progress(layout: bpy.types.UILayout, job: Job[Any]) -> None:
    row = layout.row(align=True)
    row.progress(factor=job.fraction, text=job.doing)
    row.operator(modal.MEASUREDBRDF_OT_cancel.bl_idname, text="", icon="X")


def _draw_version(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Offer an update if an older version made the material."""
    if versions.made_by(material) != versions.CURRENT and materials.is_outdated(material):
        column = layout.box().column()
        draw_wrapped(column, f"Made by version {versions.made_by(material)}; this is {versions.CURRENT}. It renders as "
                     "before. An update brings the improvements to all materials of this file", "INFO")
        column.operator(update.MEASUREDBRDF_OT_update_materials.bl_idname, icon="FILE_REFRESH")


def _draw_data_state(layout: bpy.types.UILayout, settings: Any, data: Job[tasks.Data], fitted: bool) -> None:
    """Say if the file is being read, cannot be read, or has changed since the fit."""
    if data.finished is None:
        layout.label(text="Reading the measurements", icon="TIME")
    elif data.error is not None:
        draw_warning(layout, str(data.error))
        layout.operator(fit.MEASUREDBRDF_OT_find_file.bl_idname, icon="FILE_FOLDER")
    elif fitted and (space := other_colours(settings, here := scene_colours())):
        draw_warning(layout, f"Fitted for colours in {space}; those of this file are in {here}. Refit it")
    elif fitted and data.result is not None and data.result.digest != settings.digest:
        draw_warning(layout, "The measurements have changed since the fit. Refit to use them")


def _draw_choices(layout: bpy.types.UILayout, settings: Any) -> None:
    row = layout.row(align=True)
    for name in PRESETS:
        row.operator(presets.MEASUREDBRDF_OT_use_preset.bl_idname, text=name,
                     depress=is_preset(settings, name)).preset = name
    column = layout.column(align=True)
    levels = column.column(align=True)
    levels.active = not settings.use_tolerance
    levels.prop(settings, "diffuse_level", slider=True)
    levels.prop(settings, "specular_level", slider=True)
    row = levels.row()
    row.active = settings.specular_level != NO_SPECULAR_LEVEL
    row.prop(settings, "compression", slider=True)
    row = column.row(heading="Auto")
    row.prop(settings, "use_tolerance", text="")
    row = row.row()
    row.active = settings.use_tolerance
    row.prop(settings, "tolerance", text="")


def _draw_result(layout: bpy.types.UILayout, settings: Any, anisotropic: bool) -> None:
    layout.label(text=f"{settings.name_of_data} {settings.fitted_levels}", icon="CHECKMARK")
    rows = [("Coefficients", f"{settings.coefficients:,}"),
            ("Storage", f"{settings.bytes:,} bytes"),
            ("RMSE", f"{settings.rmse:.3g} / sr"),
            ("MRE", f"{settings.mre:.2%} of the peak" if not math.isnan(settings.mre) else "all values are 0"),
            ("Fitted in", f"{settings.seconds:.2f} s")]
    if anisotropic:
        rows.append(("Direction", "Tangent, Rotation"))
    column = layout.column(align=True)
    for name, value in rows:
        split = column.split(factor=0.4)
        split.alignment = "RIGHT"
        split.label(text=name)
        split.label(text=value)
    for line in wrapped(settings.changes):
        layout.label(text=line)
