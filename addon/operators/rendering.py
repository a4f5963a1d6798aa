"""How Cycles renders measured materials: with OSL, exactly or fast."""

import bpy
from bpy.props import EnumProperty

from ..annotations import OperatorResult, present
from ..materials import osl_support
from ..materials.material import exact_input
from .active_material import active_material, is_editable

METHODS = (("EXACT", "Exact", "The measured reflectance under every light; slightly noisier and slower"),
           ("FAST", "Fast", "An approximation by Cycles' own closures. Reflections of lamps and the total reflected "
                            "light are as measured, reflections of everything else differ"))


class MEASUREDBRDF_OT_enable_osl(bpy.types.Operator):
    """Render this scene with Cycles and Open Shading Language, which measured materials need"""

    bl_idname = "measured_brdf.enable_osl"
    bl_label = "Enable OSL"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        reason = osl_support.missing()
        if reason:
            self.report({"ERROR"}, reason)
            return {"CANCELLED"}
        osl_support.enable(present(context.scene))
        return {"FINISHED"}


class MEASUREDBRDF_OT_use_method(bpy.types.Operator):
    """Choose how Cycles renders this material"""

    bl_idname = "measured_brdf.use_method"
    bl_label = "Use Method"
    bl_options = {"UNDO", "INTERNAL"}

    method: EnumProperty(items=METHODS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and exact_input(target) is not None and is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_use_method") -> str:
        return next(text for key, _, text in METHODS if key == properties.method)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        present(exact_input(present(active_material(context)))).default_value = self.method == "EXACT"
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_enable_osl, MEASUREDBRDF_OT_use_method)
