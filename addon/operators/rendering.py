"""How measured materials are rendered: exactly, or by closure nodes."""

import bpy
from bpy.props import EnumProperty

from ..annotations import OperatorResult, present
from ..materials import material as materials
from ..materials import osl_support
from ..materials.properties import RENDERING_ITEMS
from .active_material import active_material, is_editable


class MEASUREDBRDF_OT_enable_osl(bpy.types.Operator):
    """Render this scene with Cycles and Open Shading Language, which renders measured materials exactly"""

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
    """Choose how this material is rendered"""

    bl_idname = "measured_brdf.use_method"
    bl_label = "Use Method"
    bl_options = {"UNDO", "INTERNAL"}

    method: EnumProperty(items=RENDERING_ITEMS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and materials.is_shown(target) and is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_use_method") -> str:
        return next(text for key, _, text, *_ in RENDERING_ITEMS if key == properties.method)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        materials.use_rendering(present(active_material(context)), self.method)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_enable_osl, MEASUREDBRDF_OT_use_method)
