"""The panels in the material tab. Drawing reads stored properties and finished answers only: no files, no fitting."""

import math
import textwrap

import bpy

from ...fitter import PRESETS
from .. import manual, versions
from ..jobs import modal, queries
from ..materials import checks, node_group, osl_support
from ..materials import material as materials
from ..materials.properties import NO_SPECULAR_LEVEL, fit_arguments, is_preset
from ..operators import assets, fit, import_data, osl, samples
from ..operators import checks as fix_settings


class _MaterialPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.material is not None and bool(context.material.measured_brdf.filepath)


class MEASUREDBRDF_PT_material(_MaterialPanel, bpy.types.Panel):
    """A material from measured reflectance"""

    bl_label = "Measured BRDF"

    @classmethod
    def poll(cls, context):
        return context.object is not None and hasattr(context.object.data, "materials")

    def draw_header_preset(self, _context):
        manual.draw_link(self.layout)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        _draw_osl(layout, context.scene)
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
        data = queries.data(context.material)
        _draw_version(layout, context.material)
        _draw_state(layout, settings, data, fitted)
        _draw_choices(layout, settings)
        _draw_cost(layout, settings, data.result)
        row = layout.row(align=True)
        row.scale_y = 1.3
        row.enabled = modal.running is None
        row.operator(fit.MEASUREDBRDF_OT_fit.bl_idname, text="Refit" if fitted else "Fit", icon="SURFACE_DATA")
        if fitted:
            _draw_result(layout.box(), settings)
            layout.operator(assets.MEASUREDBRDF_OT_save_asset.bl_idname, icon="ASSET_MANAGER")


class MEASUREDBRDF_PT_pictures(_MaterialPanel, bpy.types.Panel):
    """What these choices look like, before they are fitted into the material"""

    bl_label = "Look"
    bl_parent_id = "MEASUREDBRDF_PT_material"

    def draw(self, context):
        layout = self.layout
        settings, data = context.material.measured_brdf, queries.data(context.material).result
        if data is None:
            return
        arguments = fit_arguments(settings)
        pictures = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        _draw_picture(pictures, "Lit sphere", *queries.lit_sphere(data, arguments))
        polar = queries.polar_plot(data, arguments, settings.shown_theta)
        job = _draw_picture(pictures, "Plane of incidence", *polar)
        _draw_picture(pictures, "RMSE by level", *queries.errors_by_level(data, arguments))
        column = pictures.column()
        column.label(text="Incidence")
        column.prop(settings, "shown_theta", text="")
        if job.result is not None and not math.isnan(job.result[1]):
            column.label(text=f"Samples at {math.degrees(job.result[1]):.1f}°")
        column.label(text="Radius: cube root")


class MEASUREDBRDF_PT_compare(_MaterialPanel, bpy.types.Panel):
    """What each preset costs for these measurements; worked out while this is open"""

    bl_label = "Compare Presets"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout = self.layout
        data = queries.data(context.material).result
        if data is None:
            return
        table = layout.column(align=True)
        _draw_row(table, "Preset", "Coefficients", "KB", "RMSE", "Held out")
        for name, arguments in PRESETS.items():
            found, held = queries.cost(data, arguments)
            _draw_row(table, name, *_numbers(found, held))
        layout.label(text="RMSE at the samples, and at samples left out (1/sr)")


class MEASUREDBRDF_PT_data(_MaterialPanel, bpy.types.Panel):
    """What the file holds"""

    bl_label = "Measurements"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        data = queries.data(context.material).result
        if data is None:
            return
        description = data.description
        self.layout.label(text=description.name)
        column = self.layout.column(align=True)
        for label, text, worrying in description.rows():
            split = column.split(factor=0.3)
            split.alert = worrying
            split.label(text=label)
            split.label(text=text, icon="ERROR" if worrying else "NONE")


class MEASUREDBRDF_PT_rendering(_MaterialPanel, bpy.types.Panel):
    """Exact or Fast, and settings of the scene that change how measured materials look"""

    bl_label = "Rendering"
    bl_parent_id = "MEASUREDBRDF_PT_material"

    @classmethod
    def poll(cls, context):
        return context.material is not None and fit.exact_input(context.material) is not None

    def draw(self, context):
        layout = self.layout
        exact = fit.exact_input(context.material).default_value
        row = layout.row(align=True)
        for key, label, _ in fit.METHODS:
            row.operator(fit.MEASUREDBRDF_OT_use_method.bl_idname, text=label,
                         depress=exact == (key == "EXACT")).method = key
        misplaced = materials.group_node(context.material).node_tree.get(node_group.FAST_ERROR, 0)
        layout.label(text=f"Fast puts {misplaced:.1%} of the light into other directions")
        findings = checks.check(context.scene)
        if not findings:
            layout.label(text="Nothing in this scene changes what was measured", icon="CHECKMARK")
        for finding in findings:
            column = layout.box().column(align=True)
            _draw_wrapped(column, finding.message)
            if finding.fix is not None:
                fix = fix_settings.MEASUREDBRDF_OT_fix_setting.bl_idname
                column.operator(fix, text=finding.change).key = finding.key


def _numbers(found, held):
    """Coefficients, kilobytes, error and held-out error as text, as far as they are known."""
    if found.error is not None:
        return "-", "-", "-", "-"
    if found.result is None:
        return "...", "...", "...", "..."
    made, errors, _ = found.result
    left_out = f"{held.fraction:.0%}" if held.finished is None else "-" if held.error else f"{held.result:.3g}"
    return f"{made.coefficient_count:,}", f"{made.nbytes / 1000:,.0f}", f"{errors.rmse:.3g}", left_out


def _draw_osl(layout, scene):
    reason = osl_support.missing()
    if reason:
        _draw_warning(layout, reason)
    elif not osl_support.is_enabled(scene):
        column = layout.box().column()
        column.label(text="Measured materials need Cycles with OSL", icon="INFO")
        column.operator(osl.MEASUREDBRDF_OT_enable_osl.bl_idname)


def _draw_progress(layout, job):
    row = layout.row(align=True)
    row.progress(factor=job.fraction, text=job.doing)
    row.operator(modal.MEASUREDBRDF_OT_cancel.bl_idname, text="", icon="X")


def _draw_version(layout, material):
    """Say where an older version made the material."""
    if versions.made_by(material) != versions.CURRENT and materials.is_outdated(material):
        column = layout.box().column()
        _draw_wrapped(column, f"Made by version {versions.made_by(material)}; this is {versions.CURRENT}. It renders "
                      "as it did; an update brings what has been improved, for all materials of this file", "INFO")
        column.operator(fit.MEASUREDBRDF_OT_update_materials.bl_idname, icon="FILE_REFRESH")


def _draw_state(layout, settings, data, fitted):
    """Say where the file is not read yet, missing, wrong, or not that of the fit."""
    if data.finished is None:
        layout.label(text="Reading the measurements", icon="TIME")
    elif data.error is not None:
        _draw_warning(layout, str(data.error))
        layout.operator(fit.MEASUREDBRDF_OT_find_file.bl_idname, icon="FILE_FOLDER")
    elif fitted and data.result is not None and data.result.digest != settings.digest:
        _draw_warning(layout, "The measurements have changed since the fit: Refit takes the new ones")


def _draw_choices(layout, settings):
    row = layout.row(align=True)
    for name in PRESETS:
        row.operator(fit.MEASUREDBRDF_OT_use_preset.bl_idname, text=name,
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


def _draw_cost(layout, settings, data):
    """What the present choices cost, before they are fitted."""
    column = layout.column(align=True)
    if data is None:
        return
    found, held = queries.cost(data, fit_arguments(settings))
    if found.error is not None:
        _draw_warning(layout, str(found.error))
        return
    _draw_row(column, "Coefficients", "KB", "RMSE", "Held out")
    _draw_row(column, *_numbers(found, held))


def _draw_row(layout, *texts):
    row = layout.row()
    for text in texts:
        row.label(text=text)


def _draw_picture(layout, title, icon, job):
    column = layout.column()
    column.label(text=title)
    if icon:
        column.template_icon(icon_value=icon, scale=9)
    if job.finished is None:
        column.progress(factor=job.fraction, text=job.doing)
    elif job.error is not None:
        column.label(text=str(job.error), icon="ERROR")
    return job


def _draw_result(layout, settings):
    layout.label(text=f"{settings.name_of_data} {settings.fitted_levels}", icon="CHECKMARK")
    rows = (("Coefficients", f"{settings.coefficients:,}"),
            ("Storage", f"{settings.bytes:,} bytes"),
            ("RMSE", f"{settings.rmse:.3g} / sr"),
            ("MRE", f"{settings.mre:.2%} of the peak" if not math.isnan(settings.mre) else "nothing but zeros"),
            ("Fitted in", f"{settings.seconds:.2f} s"))
    column = layout.column(align=True)
    for name, value in rows:
        split = column.split(factor=0.4)
        split.alignment = "RIGHT"
        split.label(text=name)
        split.label(text=value)
    for line in textwrap.wrap(settings.changes, 52) if settings.changes else ():
        layout.label(text=line)


def _draw_warning(layout, text):
    column = layout.box().column(align=True)
    column.alert = True
    _draw_wrapped(column, text)


def _draw_wrapped(column, text, icon="ERROR"):
    for number, line in enumerate(textwrap.wrap(text, 52)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


classes = (MEASUREDBRDF_PT_material, MEASUREDBRDF_PT_pictures, MEASUREDBRDF_PT_compare, MEASUREDBRDF_PT_data,
           MEASUREDBRDF_PT_rendering)
register, unregister = bpy.utils.register_classes_factory(classes)
