"""Looking for settings that change how measured materials render, and mending them."""

import bpy

from ..materials import checks


class MEASUREDBRDF_OT_check_scene(bpy.types.Operator):
    """Report what in this scene makes measured materials look other than they were measured"""

    bl_idname = "measured_brdf.check_scene"
    bl_label = "Check Scene"

    def execute(self, context):
        findings = checks.check(context.scene)
        for finding in findings:
            advice = f". Fix: {finding.change}" if finding.change else ""
            self.report({"WARNING"}, finding.message + advice)
        if not findings:
            self.report({"INFO"}, "Nothing in this scene changes what was measured")
        return {"FINISHED"}


class MEASUREDBRDF_OT_fix_setting(bpy.types.Operator):
    """Change a setting that makes measured materials look other than they were measured"""

    bl_idname = "measured_brdf.fix_setting"
    bl_label = "Fix"
    bl_options = {"REGISTER", "UNDO"}

    key: bpy.props.StringProperty(name="Setting", description="Which finding to fix; empty for all of them")

    @classmethod
    def description(cls, context, properties):
        return next((finding.change for finding in checks.check(context.scene) if finding.key == properties.key),
                    "Change all settings that make measured materials look other than they were measured")

    def execute(self, context):
        fixes = [finding for finding in checks.check(context.scene)
                 if finding.fix is not None and self.key in ("", finding.key)]
        if not fixes:
            self.report({"WARNING"}, "There is nothing to fix")
            return {"CANCELLED"}
        for finding in fixes:
            finding.fix()
            self.report({"INFO"}, finding.change)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_check_scene, MEASUREDBRDF_OT_fix_setting)
