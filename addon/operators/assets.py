"""Keeping a measured material for other files."""

import tempfile
from pathlib import Path

import bpy
from bpy.props import BoolProperty, StringProperty

from ...fitter import DatasetError
from .. import preferences
from ..jobs import tasks
from ..jobs.blender_process import Command
from ..jobs.modal import InBackground
from ..library import assets, library_file
from ..materials import material as materials
from ..materials.properties import fit_arguments
from .fit import active_material


class ReplacesFile:
    """A mix-in for operators that write a library: only `force`, or a user who says so, replaces another file."""

    force: BoolProperty(name="Replace", options={"SKIP_SAVE"},
                        description="Where a file of this name is there that is not a library of Measured BRDF, put it "
                                    "aside (NAME.blend.kept1) and go on")

    def confirm(self, event, path):
        """Ask the user where a file would be replaced: what `invoke` returns then, else None."""
        reason = library_file.refusal(path)
        if not reason or self.force or bpy.app.background:
            return None
        self.force = True               # with which `execute` is called once the user has agreed
        message = f"{reason}. It will be kept as {library_file.kept_name(path)}"
        return bpy.context.window_manager.invoke_confirm(self, event, title="Replace this file?", message=message,
                                                         confirm_text="Replace", icon="WARNING")

    def refuse(self, path):
        """Raise the reason why a file may not be replaced, if there is one."""
        reason = library_file.refusal(path)
        if reason and not self.force:
            raise library_file.LibraryError(f"{reason}. Choose another name")

    def force_option(self):
        """For the command line."""
        return ["--force"] if self.force else []


class MEASUREDBRDF_OT_save_asset(ReplacesFile, InBackground, bpy.types.Operator):
    """Keep this material for other files: mark it as an asset, with a thumbnail, a catalogue, a description and tags, \
and write it into the asset library of the preferences, if there is one"""

    bl_idname = "measured_brdf.save_asset"
    bl_label = "Save to Asset Library"
    bl_options = {"REGISTER", "UNDO"}

    needs_osl = False
    directory: StringProperty(name="Library", subtype="DIR_PATH", options={"SKIP_SAVE"},
                              description="Folder of the asset library; empty for that of the preferences, or for the "
                                          "open file where there is none")

    @classmethod
    def poll(cls, context):
        target = active_material(context)
        if (target is None or not target.is_editable or target.override_library is not None
                or not materials.is_measured(target)):
            cls.poll_message_set("Fit a material of this file first")
            return False
        return True

    def invoke(self, context, event):
        path = self._path(context)
        if path is None:
            return self.execute(context)
        return self.confirm(event, path) or self.start(context)

    def execute(self, context):
        if self.force and self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            # the user has agreed to replace a file; the window must not freeze
            bpy.ops.measured_brdf.save_asset("INVOKE_DEFAULT", directory=self.directory, force=True)
            return {"CANCELLED"}
        if self._path(context) is not None:
            return self.run(context)
        target = active_material(context)
        try:
            picture = _thumbnail(target)
            with assets.unmarked_on_error(target):
                assets.renew(target, assets.remember(target), picture)
                if bpy.data.filepath:
                    assets.write_catalogue(Path(bpy.data.filepath).parent)
        except Exception as error:
            return self._failed(error)
        self.report({"INFO"}, f"{target.name} is an asset of this file; the preferences may name a library")
        return {"FINISHED"}

    def work(self, context):
        """Write a copy into a folder for temporary files, from which another Blender takes it into the library."""
        path, target = self._path(context), active_material(context)
        self.refuse(path)
        self._folder = tempfile.TemporaryDirectory(prefix="measured_brdf_")
        picture, source = _thumbnail(target), Path(self._folder.name, "material.blend")
        copy, name = target.copy(), target.name
        try:
            target.name, copy.name = f"{name} (kept)", name
            assets.renew(copy, assets.remember(copy), picture)
            bpy.data.libraries.write(str(source), {copy}, fake_user=True)
        finally:
            bpy.data.materials.remove(copy)
            target.name = name
        return Command("save", source, path, *self.force_option())

    def apply(self, context, result):
        path = Path(result["path"])
        self._folder.cleanup()
        _know(context, path.parent)
        self.report({"INFO"}, f"{path} written")

    def _path(self, context):
        """The library's .blend for the active material, or None where no library is named."""
        folder = self.directory or preferences.get(context).asset_library
        name = assets.file_name(active_material(context).name)
        return Path(bpy.path.abspath(folder)).resolve() / f"{name}.blend" if folder else None


def _thumbnail(target):
    """The lit sphere where the measurements are at hand, else None: Blender renders one."""
    settings = target.measured_brdf
    try:
        data = tasks.read(bpy.path.abspath(settings.filepath), settings.sample)
    except DatasetError:
        return None
    return assets.thumbnail(tasks.fitted(data.samples, data.digest, fit_arguments(settings)).fit)


def _know(context, folder):
    """Let Blender's asset browser list the folder."""
    libraries = context.preferences.filepaths.asset_libraries
    if not any(Path(bpy.path.abspath(library_file.path)).resolve() == folder.resolve() for library_file in libraries):
        libraries.new(name="Measured BRDF", directory=str(folder))


classes = (MEASUREDBRDF_OT_save_asset,)
