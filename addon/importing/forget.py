"""Removes from the open file the folders of what it was made from."""

import bpy

from ..core.annotations import OperatorResult
from ..core.storage import paths

_LONG_PATH = "x" * 1023     # as long as the path of an image can be


class MEASUREDBRDF_OT_forget_paths(bpy.types.Operator):
    """Remove the folders of all measurements and photographs from this file, which may tell your name. The files' own \
names stay, by which Find Missing Measurements finds them again, and so do the fits"""

    bl_idname = "measured_brdf.forget_paths"
    bl_label = "Forget Paths"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        known = [(owner, name, getattr(owner, name)) for owner, name in paths.stored_paths()]
        changed = [(owner, name, forgotten) for owner, name, path in known if (forgotten := paths.forget(path)) != path]
        for owner, name, forgotten in changed:
            setattr(owner, name, _LONG_PATH)    # else Blender saves the end of what was longer behind what is shorter
            setattr(owner, name, forgotten)
        count = len(changed)
        self.report({"INFO"}, f"The folders of {count} file{'s' * (count != 1)} are forgotten. Save this file")
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_forget_paths,)
