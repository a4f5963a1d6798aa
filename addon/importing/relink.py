"""Finds files of measurements that have moved: that of one material, or those of all."""

from functools import partial
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...fitter.formats import is_there
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material, can_change, is_editable
from ..core.blender.transaction import by_session_uid
from ..core.storage.paths import absolute
from ..core.storage.reading import load_arguments
from ..work import process, tasks
from ..work.discovery import GLOB
from ..work.modal import AsksForPath, errors_reported
from .fit import FitsWithPreset


class MEASUREDBRDF_OT_find_file(FitsWithPreset, bpy.types.Operator, ImportHelper):
    """Choose the file of measurements that this material was made from. Its fit stays as it is, unless Refit is on"""

    bl_idname = "measured_brdf.find_file"
    bl_label = "Relink"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    refit: BoolProperty(name="Refit", options={"SKIP_SAVE"}, description="Fit the material to the file, too")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_editable(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_find_file") -> str:
        return f"Choose the file of measurements that this material was made from{', and fit it' * properties.refit}"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        missing = Path(absolute(not_none(active_material(context))))
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
                   and not is_there(absolute(item))]
        if not missing:
            raise ValueError("No measurements of this file's materials are missing")
        self._missing = [item.session_uid for item in missing]
        wanted = [(absolute(item), settings.sample, load_arguments(settings), settings.digest)
                  for item in missing if (settings := item.measured_brdf)]
        return process.Calculation(partial(tasks.found_again, wanted, bpy.path.abspath(self.directory)))

    def apply(self, _context: bpy.types.Context, paths: list[str]) -> None:
        for uid, path in zip(self._missing, paths, strict=True):
            target = by_session_uid(bpy.data.materials, uid)
            if target is None or not target.is_editable:
                continue
            if path:
                target.measured_brdf.filepath = path
            else:
                self.report({"WARNING"}, f"{target.name}: {Path(absolute(target)).name} is not in {self.directory}")
        self.report({"INFO"}, f"{sum(map(bool, paths))} of {len(paths)} materials relinked")

classes = (MEASUREDBRDF_OT_find_file, MEASUREDBRDF_OT_find_missing)
