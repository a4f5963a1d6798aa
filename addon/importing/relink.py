"""Finds files of measurements that have moved, that of one material or those of all; and has a file forget where they
are."""

from functools import partial
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...fitter.formats import is_there
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material, can_change
from ..core.blender.transaction import find_by_session_uid
from ..core.storage import paths
from ..core.storage.reading import load_arguments
from ..work import process, tasks
from ..work.discovery import GLOB
from ..work.modal import AsksForPath, errors_reported
from .fit import FitsWithPreset

_LONG_PATH = "x" * 1023     # as long as the path of an image can be


class MEASUREDBRDF_OT_find_file(FitsWithPreset, bpy.types.Operator, ImportHelper):
    """Choose the file of measurements that this material was made from. Its fit stays as it is, unless Refit is on"""

    bl_idname = "measured_brdf.find_file"
    bl_label = "Relink"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    refit: BoolProperty(name="Refit", options={"SKIP_SAVE"}, description="Fit the material to the file, too")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_find_file") -> str:
        return f"Choose the file of measurements that this material was made from{', and fit it' * properties.refit}"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        missing = Path(paths.absolute(not_none(active_material(context))))
        self.filepath = str(missing if missing.parent.is_dir() else Path(bpy.path.abspath("//"), missing.name))
        ImportHelper.invoke(self, context, event)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.refit:
            with errors_reported(self):
                bpy.ops.measured_brdf.fit("INVOKE_DEFAULT", filepath=self.filepath, preset=self.preset)
            return {"FINISHED"} if bpy.app.background else {"CANCELLED"}        # the fit makes the undo step
        target = not_none(active_material(context))
        target.measured_brdf.filepath = self.filepath
        self.report({"INFO"}, f"{target.name}: relinked to {self.filepath}")
        return {"FINISHED"}


class MEASUREDBRDF_OT_find_missing(AsksForPath, bpy.types.Operator):
    """Search a folder, and those in it, for the missing files of all measured materials of this file, by their names. \
Fits stay as they are"""

    bl_idname = "measured_brdf.find_missing"
    bl_label = "Find Missing Measurements"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def work(self, _context: bpy.types.Context) -> process.Calculation:
        missing = [item for item in bpy.data.materials if item.measured_brdf.filepath and can_change(item)
                   and not is_there(paths.absolute(item))]
        if not missing:
            raise ValueError("No measurements of this file's materials are missing")
        self._missing = [item.session_uid for item in missing]
        wanted = [(paths.absolute(item), settings.sample, load_arguments(settings), settings.digest)
                  for item in missing if (settings := item.measured_brdf)]
        return process.Calculation(partial(tasks.found_again, wanted, bpy.path.abspath(self.directory)))

    def apply(self, _context: bpy.types.Context, found: list[str]) -> None:
        for uid, path in zip(self._missing, found, strict=True):
            target = find_by_session_uid(bpy.data.materials, uid)
            if target is None or not target.is_editable:
                continue
            if path:
                target.measured_brdf.filepath = path
            else:
                name = Path(paths.absolute(target)).name
                self.report({"WARNING"}, f"{target.name}: {name} is not in {self.directory}")
        self.report({"INFO"}, f"{sum(map(bool, found))} of {len(found)} materials relinked")


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


classes = (MEASUREDBRDF_OT_find_file, MEASUREDBRDF_OT_find_missing, MEASUREDBRDF_OT_forget_paths)
