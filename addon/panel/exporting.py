"""What an export loses of measured materials: in the dialogs of the exporters, and for scripts."""

import bpy

from ..core.annotations import OperatorResult, not_none
from ..core.shading.export_follow import lost_in
from .layout import draw_wrapped

_EXPORTERS = ("EXPORT_SCENE_OT_gltf", "WM_OT_usd_export", "WM_OT_obj_export", "EXPORT_SCENE_OT_fbx")


class MEASUREDBRDF_PT_export(bpy.types.Panel):
    """What other programs do not get of the measured materials of this file"""

    bl_label = "Measured BRDFs"
    bl_space_type = "FILE_BROWSER"
    bl_region_type = "TOOL_PROPS"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        operator = getattr(context.space_data, "active_operator", None)
        return operator is not None and operator.bl_idname in _EXPORTERS and bool(_losses())

    def draw(self, _context: bpy.types.Context) -> None:
        for line in _losses():
            draw_wrapped(not_none(self.layout), line, "INFO")


class MEASUREDBRDF_OT_check_export(bpy.types.Operator):
    """Report what other programs do not get of the measured materials of this file. For scripts: of the exporters, \
glTF's alone reports it"""

    bl_idname = "measured_brdf.check_export"
    bl_label = "Check Export"

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        losses = _losses()
        for line in losses:
            self.report({"WARNING"}, line)
        if not losses:
            self.report({"INFO"}, "Other programs get all of the measured materials that a Principled BSDF can show")
        return {"FINISHED"}


def _losses() -> list[str]:
    return [line for item in bpy.data.materials if item.users for line in lost_in(item)]


classes = (MEASUREDBRDF_OT_check_export, MEASUREDBRDF_PT_export)
