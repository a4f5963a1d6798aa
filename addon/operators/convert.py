"""A folder of measurements into an asset library."""

from pathlib import Path

import bpy
from bpy.props import StringProperty

from .. import batch, preferences
from ..properties import FitChoices, complete
from .import_data import begin_with_preference, sources_in
from .in_background import InBackground


class MEASUREDBRDF_OT_convert_folder(FitChoices, InBackground, bpy.types.Operator):
    """Make an asset library from all measurements in a folder: a .blend of materials with thumbnails. \
The open file stays as it is"""

    bl_idname = "measured_brdf.convert_folder"
    bl_label = "Convert Folder to Asset Library"
    bl_options = {"REGISTER"}

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})
    library: StringProperty(name="Library", subtype="FILE_PATH",
                            description="The .blend to write; empty for one with the folder's name, in the asset "
                                        "library of the preferences, or else in the folder")

    def invoke(self, context, _event):
        begin_with_preference(self, context)
        if self.directory:
            return self.start(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        # called by the file browser, whose window must not freeze
        if self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            bpy.ops.measured_brdf.convert_folder("INVOKE_DEFAULT", **self.as_keywords(ignore=("filepath",)))
            return {"CANCELLED"}
        complete(self)
        return self.run(context)

    def work(self, _context):
        return None                     # the batch has processes of its own

    def apply(self, context, _result):
        folder = Path(bpy.path.abspath(self.directory))
        sources, failures = sources_in([folder])
        home = Path(bpy.path.abspath(preferences.get(context).asset_library or str(folder)))
        path = Path(bpy.path.abspath(self.library)) if self.library else home / f"{folder.name}.blend"
        rows = yield from batch.convert(context, sources, failures, self, path)
        failed = [row for row in rows if row.status.startswith("failed")]
        for row in failed:
            self.report({"WARNING"}, f"{row.name} {row.status}")
        self.report({"INFO"}, f"{path}: {len(rows) - len(failed)} materials; {len(failed)} files failed")


classes = (MEASUREDBRDF_OT_convert_folder,)
