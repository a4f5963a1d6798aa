"""What a user can do."""

import bpy
from bpy_extras.io_utils import ImportHelper

from ..fitter import DatasetError
from . import material, node_group, osl_support
from .properties import FitChoices

_EXPECTED = (DatasetError, node_group.CompileError, ValueError)


class MEASUREDBRDF_OT_import_data(FitChoices, bpy.types.Operator, ImportHelper):
    """Make a material from a file of measured reflectance and assign it to the active object"""

    bl_idname = "measured_brdf.import_data"
    bl_label = "Import Measured BRDF"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: bpy.props.StringProperty(default="*.dat;*.astm;*.brdf;*.mat", options={"HIDDEN"})

    def execute(self, context):
        try:
            made = material.import_material(self, context)
        except _EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not _assign(context.object, made):
            self.report({"WARNING"}, f"{made.name} is not assigned: no active object can take a material")
        self.report({"INFO"}, f"{made.name}: {made.measured_brdf.coefficients:,} coefficients, "
                              f"RMSE {made.measured_brdf.rmse:.3g}")
        return {"FINISHED"}


def _assign(target, material):
    """Put a material into the active slot of an object: whether it could be done."""
    if target is None or not hasattr(target.data, "materials") or not target.is_editable:
        return False
    slot = target.material_slots[target.active_material_index] if target.material_slots else None
    if not target.data.is_editable and (slot is None or slot.link == "DATA"):
        return False
    if slot is None:
        target.data.materials.append(material)
    else:
        slot.material = material
    return True


class MEASUREDBRDF_OT_fit(bpy.types.Operator):
    """Read this material's file and fit it with these levels and this compression"""

    bl_idname = "measured_brdf.fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        target = _active_material(context)
        if target is None or not target.is_editable:
            cls.poll_message_set("There is no active material, or it is linked from another file")
            return False
        return True

    def execute(self, context):
        try:
            material.refit(_active_material(context), context)
        except _EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def _active_material(context):
    """The material that the properties editor shows, else that of the active object, else None."""
    shown = getattr(context, "material", None)
    return shown if shown is not None or context.object is None else context.object.active_material


class MEASUREDBRDF_OT_enable_osl(bpy.types.Operator):
    """Render this scene with Cycles and Open Shading Language, which measured materials need"""

    bl_idname = "measured_brdf.enable_osl"
    bl_label = "Enable OSL"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        reason = osl_support.missing()
        if reason:
            self.report({"ERROR"}, reason)
            return {"CANCELLED"}
        osl_support.enable(context.scene)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_import_data, MEASUREDBRDF_OT_fit, MEASUREDBRDF_OT_enable_osl)


def _menu_item(menu, context):
    menu.layout.operator(MEASUREDBRDF_OT_import_data.bl_idname, text="Measured BRDF (CURET, Cornell, .brdf)")


def register():
    for cls in classes:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_menu_item)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_menu_item)
    for cls in reversed(classes):
        bpy.utils.unregister_class(cls)
