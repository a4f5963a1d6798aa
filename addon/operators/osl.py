"""Rendering with OSL, which measured materials need."""

import bpy

from ..materials import osl_support


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


classes = (MEASUREDBRDF_OT_enable_osl,)
