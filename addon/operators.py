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
        target = context.object
        if target is not None and hasattr(target.data, "materials"):
            if target.material_slots:
                target.material_slots[target.active_material_index].material = made
            else:
                target.data.materials.append(made)
        self.report({"INFO"}, f"{made.name}: {made.measured_brdf.coefficients:,} coefficients, "
                              f"RMSE {made.measured_brdf.rmse:.3g}")
        return {"FINISHED"}


class MEASUREDBRDF_OT_fit(bpy.types.Operator):
    """Read this material's file and fit it with these levels and this compression"""

    bl_idname = "measured_brdf.fit"
    bl_label = "Fit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if getattr(context, "material", None) is None and (context.object is None
                                                           or context.object.active_material is None):
            cls.poll_message_set("There is no active material")
            return False
        return True

    def execute(self, context):
        target = getattr(context, "material", None) or context.object.active_material
        try:
            material.refit(target, context)
        except _EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


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
