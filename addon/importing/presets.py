"""Sets the fit settings of a material from a preset."""

import bpy
from bpy.props import EnumProperty

from ...fitter.presets import PRESET_DESCRIPTIONS
from ..core.active_material import active_material, is_editable
from ..core.annotations import OperatorResult, present
from ..core.properties import PRESET_ITEMS, use_preset


class MEASUREDBRDF_OT_use_preset(bpy.types.Operator):
    """Use the method and the levels of a preset. Fit applies them"""

    bl_idname = "measured_brdf.use_preset"
    bl_label = "Use Preset"
    bl_options = {"UNDO", "INTERNAL"}

    preset: EnumProperty(items=PRESET_ITEMS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_use_preset") -> str:
        return PRESET_DESCRIPTIONS[properties.preset]

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        use_preset(present(active_material(context)).measured_brdf, self.preset)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_use_preset,)
