"""Makes a linked material local, so that it can be changed."""

import bpy

from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material, can_change
from ..core.storage import paths


class MEASUREDBRDF_OT_make_local(bpy.types.Operator):
    """Make this material part of this file, so that it can be changed. Its file stays as it is"""

    bl_idname = "measured_brdf.make_local"
    bl_label = "Make Local"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and not can_change(target)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        target = not_none(active_material(context))
        path = paths.absolute(target)
        target.make_local(clear_liboverride=True).measured_brdf.filepath = path
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_make_local,)
