"""Reports and fixes settings of the scene that change how measured materials look, and what an export loses of them."""

import bpy
from bpy.props import StringProperty

from ..core import checks
from ..core.annotations import OperatorResult, not_none
from ..core.shading.export_follow import lost_in
from ..work.modal import errors_reported
from .layout import draw_wrapped

_EXPORTERS = ("EXPORT_SCENE_OT_gltf", "WM_OT_usd_export", "WM_OT_obj_export", "EXPORT_SCENE_OT_fbx")


class MEASUREDBRDF_OT_check_scene(bpy.types.Operator):
    """Report the settings of this scene that change how measured materials look"""

    bl_idname = "measured_brdf.check_scene"
    bl_label = "Check Scene"

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        findings = checks.check(not_none(context.scene))
        for finding in findings:
            advice = f". Fix: {finding.change}" if finding.change else ""
            self.report({"WARNING"}, finding.message + advice)
        if not findings:
            self.report({"INFO"}, "No setting of this scene changes how measured materials look")
        return {"FINISHED"}


class MEASUREDBRDF_OT_fix_setting(bpy.types.Operator):
    """Change a setting so that measured materials look as measured"""

    bl_idname = "measured_brdf.fix_setting"
    bl_label = "Fix"
    bl_options = {"REGISTER", "UNDO"}

    key: StringProperty(name="Setting", description="The finding to fix. Empty: all of them")

    @classmethod
    def description(cls, context: bpy.types.Context, properties: "MEASUREDBRDF_OT_fix_setting") -> str:
        return next((finding.change for finding in checks.check(not_none(context.scene))
                     if finding.key == properties.key),
                    "Change all settings so that measured materials look as measured")

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        fixed = 0
        for finding in checks.check(not_none(context.scene)):
            if finding.fix is not None and self.key in ("", finding.key):
                with errors_reported(self):
                    finding.fix()
                    self.report({"INFO"}, finding.change)
                fixed += 1
        if not fixed:
            self.report({"WARNING"}, "There is nothing to fix")
            return {"CANCELLED"}
        return {"FINISHED"}


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


classes = (MEASUREDBRDF_OT_check_scene, MEASUREDBRDF_OT_fix_setting, MEASUREDBRDF_OT_check_export,
           MEASUREDBRDF_PT_export)
