"""The main panel: what the material looks like and what it is worth, and how to begin. The sidebar shows the same."""

from typing import Any

import bpy

from ...fitter import PRESETS, SampleUnknownError, published
from .. import manual, versions
from ..annotations import present
from ..jobs import modal, queries, tasks
from ..jobs.job import Job
from ..materials import material as materials
from ..materials import rendered
from ..materials.adjustments import edit_arguments
from ..materials.properties import is_as_fitted, is_preset, name_of_fit, worth
from ..materials.reading import draw_reading, other_colours, scene_colours
from ..operators import assets, fit, import_data, local, presets, samples, update
from ..operators.active_material import active_material, can_change
from ..operators.rendering import MEASUREDBRDF_OT_enable_osl
from . import inspect
from .comparison import draw_cost, picture_scale
from .layout import MaterialPanel, choices, draw_warning, draw_wrapped, has_data
from .mix import draw_mix

_HELP = 24                  # pixels at a scale of 1: of the button that opens the manual


class _Main:
    """What the panels in the material tab and the one in the sidebar share."""

    bl_label = "Measured BRDF"

    def draw(self, context: bpy.types.Context) -> None:
        draw(present(self.layout), context)


class MEASUREDBRDF_PT_material(_Main, MaterialPanel, bpy.types.Panel):
    """A material of measured reflectance"""

    bl_options = {"HIDE_HEADER"}            # panels without a header come first, below the list of materials

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_data(context)


class MEASUREDBRDF_PT_begin(_Main, MaterialPanel, bpy.types.Panel):
    """How to begin, where there is no measured material yet"""

    bl_options = {"HIDE_HEADER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _can_have_material(context) and not has_data(context)


class MEASUREDBRDF_PT_sidebar(_Main, bpy.types.Panel):
    """The measured material of the active object"""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Measured BRDF"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _can_have_material(context)


def _can_have_material(context: bpy.types.Context) -> bool:
    return context.object is not None and hasattr(context.object.data, "materials")


def draw(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    """Draw what the material looks like, how well it was fitted, how it is rendered, and what it is made from."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    if modal.running is not None:
        _draw_progress(layout, modal.running)
    material = active_material(context)
    if material is None:
        _draw_import(layout)
        return
    settings, fitted = material.measured_brdf, materials.is_measured(material)
    if materials.mix_node(material) is not None and not fitted:
        draw_mix(layout, material)
        if getattr(context, "material", None) is None:      # in the sidebar; in the tab, the panel Rendering follows
            _draw_rendering(layout, material, present(context.scene))
        return
    if fitted:
        _draw_look(layout, context, material)
    if materials.is_shown(material):
        _draw_rendering(layout, material, present(context.scene))
        _draw_version(layout, material)
    can_be_changed = can_change(material)
    if not can_be_changed:
        draw_wrapped(layout, "This material belongs to another file. Make it local to change it", "INFO")
        layout.operator(local.MEASUREDBRDF_OT_make_local.bl_idname, icon="LIBRARY_DATA_DIRECT")
    body = layout.column()
    body.enabled = can_be_changed
    if not settings.filepath:
        _draw_import(body)
    if settings.filepath or not materials.is_shown(material):
        body.prop(settings, "filepath")
    if settings.filepath:
        data = queries.data(material)
        _draw_source(body, settings)
        _draw_data_state(body, settings, data, fitted)
        _draw_start(body, settings, data, fitted)
    if fitted:
        layout.operator(assets.MEASUREDBRDF_OT_save_asset.bl_idname, icon="ASSET_MANAGER")


def _draw_import(layout: bpy.types.UILayout) -> None:
    row = layout.row(align=True)
    row.operator(import_data.MEASUREDBRDF_OT_import_data.bl_idname, text="Import File...", icon="IMPORT")
    row.operator("wm.url_open", text="", icon="HELP").url = manual.url()


def _draw_progress(layout: bpy.types.UILayout, job: Job[Any]) -> None:
    row = layout.row(align=True)
    row.progress(factor=job.fraction, text=job.doing)
    row.operator(modal.MEASUREDBRDF_OT_cancel.bl_idname, text="", icon="X")


def _draw_look(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material) -> None:
    settings = material.measured_brdf
    icon, job = queries.material_sphere(material)
    if icon:
        layout.template_icon(icon_value=icon, scale=picture_scale(context, 1))
    elif job.finished is None:
        layout.progress(factor=job.fraction, text=job.doing)
    if job.error is not None:
        draw_warning(layout, str(job.error))
    column = layout.column(align=True)
    row = column.row()
    adjusted = ", adjusted" if edit_arguments(settings) else ""
    draw_wrapped(row, f"{settings.name_of_data}: {name_of_fit(settings)}{adjusted}", "MATERIAL",
                 _HELP)
    row.operator("wm.url_open", text="", icon="HELP", emboss=False).url = manual.url()
    text, is_well = worth(settings)
    if text:
        draw_wrapped(column, text, "CHECKMARK" if is_well else "INFO")
    inspect.draw(layout)


def _draw_rendering(layout: bpy.types.UILayout, material: bpy.types.Material, scene: bpy.types.Scene) -> None:
    """Say what is shown where the fit itself is not, and offer to change that."""
    found = rendered.in_scene(material, scene)
    if not found.why and found.how not in (rendered.BLACK, rendered.FORMER, rendered.PARTLY, rendered.OTHER):
        return
    column = layout.box().column(align=True)
    draw_wrapped(column, rendered.brief(found, materials.rendering_of(material)), "INFO")
    if found.can_enable:
        column.operator(MEASUREDBRDF_OT_enable_osl.bl_idname)


def _draw_version(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Offer an update if an older version made the material."""
    if versions.made_by(material) != versions.CURRENT and materials.is_outdated(material):
        column = layout.box().column()
        draw_wrapped(column, f"Made by version {versions.made_by(material)}; this is {versions.CURRENT}. It renders as "
                     "before. An update brings the improvements to all materials of this file", "INFO")
        column.operator(update.MEASUREDBRDF_OT_update_materials.bl_idname, icon="FILE_REFRESH")


def _draw_source(layout: bpy.types.UILayout, settings: Any) -> None:
    """Draw which sample of a file it is, and how the file is read."""
    if published.name_in(settings.filepath) is not None:
        return
    row = layout.row(align=True)
    row.prop(settings, "sample")
    row.operator_context = "INVOKE_DEFAULT"
    row.operator(samples.MEASUREDBRDF_OT_choose_sample.bl_idname, text="", icon="VIEWZOOM").for_material = True
    draw_reading(layout, settings)


def _draw_data_state(layout: bpy.types.UILayout, settings: Any, data: Job[tasks.Data], fitted: bool) -> None:
    """Say if the file is being read, cannot be read, or has changed since the fit."""
    if data.finished is None:
        layout.label(text="Reading the measurements", icon="TIME")
    elif isinstance(data.error, SampleUnknownError):
        draw_warning(layout, str(data.error))
        row = layout.row()
        row.operator_context = "INVOKE_DEFAULT"
        chosen = row.operator(samples.MEASUREDBRDF_OT_choose_sample.bl_idname, icon="VIEWZOOM")
        chosen.for_material, chosen.refit = True, fit.AS_CHOSEN if fitted else ""
    elif data.error is not None:
        draw_warning(layout, str(data.error))
        layout.operator(fit.MEASUREDBRDF_OT_find_file.bl_idname, icon="FILE_FOLDER")
    elif fitted and (space := other_colours(settings, here := scene_colours())):
        draw_warning(layout, f"Fitted for colours in {space}; those of this file are in {here}. Refit it")
    elif fitted and data.result is not None and data.result.digest != settings.digest:
        draw_warning(layout, "The measurements have changed since the fit. Refit to use them")


def _draw_start(layout: bpy.types.UILayout, settings: Any, data: Job[tasks.Data], fitted: bool) -> None:
    """Draw the presets, and the button that fits; what a fit costs, if the material does not have it."""
    buttons = choices(layout, PRESETS)
    for name in PRESETS:
        buttons.operator(presets.MEASUREDBRDF_OT_use_preset.bl_idname, text=name,
                         depress=is_preset(settings, name)).preset = name
    row = layout.row(align=True)
    row.scale_y = 1.3
    row.enabled = modal.running is None
    row.operator(fit.MEASUREDBRDF_OT_fit.bl_idname, text="Refit" if fitted else "Fit", icon="SURFACE_DATA")
    if fitted and not is_as_fitted(settings):
        draw_wrapped(layout, "The settings have changed since the fit. Refit to use them", "INFO")
    if not fitted or not is_as_fitted(settings):
        draw_cost(layout, settings, data.result)
