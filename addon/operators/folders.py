"""A folder of measurements at a time: into materials of the open file, and into an asset library."""

from functools import partial
from pathlib import Path

import bpy
from bpy.props import StringProperty

from .. import batch, preferences, work
from ..properties import FitChoices, complete, fit_arguments
from ..sources import GLOB, sources_in
from .import_data import begin_with_preference, make_materials
from .in_background import InBackground


class _FromFolder(FitChoices, InBackground):
    """A mix-in for operators that ask for a folder."""

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def invoke(self, context, _event):
        begin_with_preference(self, context)
        if self.directory:
            return self.start(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        # called by the file browser, whose window must not freeze
        if self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            again = getattr(bpy.ops.measured_brdf, type(self).__name__.partition("_OT_")[2])
            again("INVOKE_DEFAULT", **self.as_keywords(ignore=("filepath",)))
            return {"CANCELLED"}
        complete(self)
        return self.run(context)

    def found(self):
        """The sources in the folder, and the files that cannot be read, as `sources_in` has them."""
        sources, failures = sources_in([bpy.path.abspath(self.directory)])
        if not sources and not failures:
            raise ValueError(f"{self.directory}: no files of measurements ({GLOB}); choose a folder that has some")
        return sources, failures


class MEASUREDBRDF_OT_import_folder(_FromFolder, bpy.types.Operator):
    """Make a material from every file of measured reflectance in a folder, and from every sample of a CURET file"""

    bl_idname = "measured_brdf.import_folder"
    bl_label = "Import Folder of Measured BRDFs"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, _context):
        sources, self._failures = self.found()
        return partial(work.outcomes, sources, fit_arguments(self))

    def apply(self, context, outcomes):
        yield from make_materials(self, context, self._failures + outcomes)


class MEASUREDBRDF_OT_convert_folder(_FromFolder, bpy.types.Operator):
    """Make an asset library from all measurements in a folder: a .blend of materials with thumbnails. \
The open file stays as it is"""

    bl_idname = "measured_brdf.convert_folder"
    bl_label = "Convert Folder to Asset Library"
    bl_options = {"REGISTER"}

    library: StringProperty(name="Library", subtype="FILE_PATH",
                            description="The .blend to write; empty for one with the folder's name, in the asset "
                                        "library of the preferences, or else in the folder")

    def work(self, _context):
        self._sources, self._failures = self.found()
        return None                     # the batch has processes of its own

    def apply(self, context, _result):
        folder = Path(bpy.path.abspath(self.directory))
        home = Path(bpy.path.abspath(preferences.get(context).asset_library or str(folder)))
        path = Path(bpy.path.abspath(self.library)) if self.library else home / f"{folder.name}.blend"
        rows = yield from batch.convert(context, self._sources, self._failures, self, path)
        failed = [row for row in rows if row.status.startswith("failed")]
        for row in failed:
            self.report({"WARNING"}, f"{row.name} {row.status}")
        self.report({"INFO"}, f"{path}: {len(rows) - len(failed)} materials; {len(failed)} files failed")


classes = (MEASUREDBRDF_OT_import_folder, MEASUREDBRDF_OT_convert_folder)


def _menu_items(menu, _context):
    menu.layout.operator(MEASUREDBRDF_OT_import_folder.bl_idname, text="Measured BRDFs (folder)")
    menu.layout.operator(MEASUREDBRDF_OT_convert_folder.bl_idname, text="Measured BRDFs (folder to asset library)")


def register():
    bpy.types.TOPBAR_MT_file_import.append(_menu_items)


def unregister():
    bpy.types.TOPBAR_MT_file_import.remove(_menu_items)
