"""The panel in the material tab. Drawing reads stored properties only: no files, no fitting."""

import math

import bpy

from . import material as materials
from . import operators, osl_support
from .properties import NO_SPECULAR_LEVEL


class MEASUREDBRDF_PT_material(bpy.types.Panel):
    """A material from measured reflectance"""

    bl_label = "Measured BRDF"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.object is not None and hasattr(context.object.data, "materials")

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        _draw_osl(layout, context.scene)
        if context.material is None:
            layout.operator(operators.MEASUREDBRDF_OT_import_data.bl_idname, icon="IMPORT")
            return
        settings = context.material.measured_brdf
        column = layout.column()
        column.prop(settings, "filepath")
        column.prop(settings, "sample")
        column = layout.column(align=True)
        column.prop(settings, "diffuse_level")
        column.prop(settings, "specular_level")
        row = column.row()
        row.active = settings.specular_level != NO_SPECULAR_LEVEL
        row.prop(settings, "compression", slider=True)
        row = layout.row()
        row.enabled = bool(settings.filepath)
        row.operator(operators.MEASUREDBRDF_OT_fit.bl_idname, icon="SURFACE_DATA")
        if settings.coefficients and materials.group_node(context.material) is not None:
            _draw_result(layout.box(), settings)


def _draw_osl(layout, scene):
    reason = osl_support.missing()
    if reason:
        column = layout.box().column(align=True)
        column.alert = True
        for number, line in enumerate(_wrapped(reason)):
            column.label(text=line, icon="ERROR" if number == 0 else "BLANK1")
    elif not osl_support.is_enabled(scene):
        column = layout.box().column()
        column.label(text="Measured materials need Cycles with OSL", icon="INFO")
        column.operator(operators.MEASUREDBRDF_OT_enable_osl.bl_idname)


def _draw_result(layout, settings):
    layout.label(text=settings.name_of_data, icon="CHECKMARK")
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


def _wrapped(text, width=52):
    """Lines of at most `width` characters."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


def register():
    bpy.utils.register_class(MEASUREDBRDF_PT_material)


def unregister():
    bpy.utils.unregister_class(MEASUREDBRDF_PT_material)
