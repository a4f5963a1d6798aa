"""Reports and fixes settings of the scene that change how measured materials look."""

import bpy
from bpy.props import StringProperty

from ..core import checks
from ..core.annotations import OperatorResult, not_none
from ..work.modal import errors_reported


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


classes = (MEASUREDBRDF_OT_check_scene, MEASUREDBRDF_OT_fix_setting)
