"""Saves a measured material as an asset, for use in other files."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty

from ...fitter.arrays import SingleArray
from ...fitter.files import real
from ..core import assets, library_file, preferences
from ..core import material as materials
from ..core.active_material import active_material
from ..core.annotations import OperatorMixIn, OperatorResult, present
from ..work import process, queries, tasks
from ..work.blender_process import Command
from ..work.modal import InBackground, errors_reported


class ReplacesFile(OperatorMixIn):
    """A mix-in for operators that write a library. Other files are replaced only with `force`, and then kept."""

    force: BoolProperty(name="Replace", options={"SKIP_SAVE"},
                        description="If a file of this name exists and is not a library of Measured BRDF, rename it to "
                                    "NAME.blend.kept1 and write the library")

    def confirm(self, event: bpy.types.Event, path: Path) -> OperatorResult | None:
        """If a file would be replaced, ask the user: what `invoke` returns then, else None."""
        reason = library_file.refusal(path)
        if not reason or self.force or bpy.app.background:
            return None
        self.force = True               # `execute` is called with it if the user agrees
        message = f"{reason}. It will be kept as {library_file.kept_name(path)}"
        return bpy.context.window_manager.invoke_confirm(self, event, title="Replace this file?", message=message,
                                                         confirm_text="Replace", icon="WARNING")

    def check_replaceable(self, path: Path) -> None:
        """Raise an error if a file would be replaced without `force`."""
        reason = library_file.refusal(path)
        if reason and not self.force:
            raise library_file.LibraryError(f"{reason}. Choose another name")

    def force_option(self) -> list[str]:
        """`force` as arguments of the command line."""
        return ["--force"] if self.force else []


class MEASUREDBRDF_OT_save_asset(ReplacesFile, InBackground, bpy.types.Operator):
    """Make this material an asset with a thumbnail, a description and tags, and save it in the asset library that the \
preferences name, for use in other files"""

    bl_idname = "measured_brdf.save_asset"
    bl_label = "Save to Asset Library"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Library", subtype="DIR_PATH", options={"SKIP_SAVE"},
                              description="Folder of the asset library. Empty: the one in the preferences, or the open "
                                          "file if they name none")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        if (target is None or not target.is_editable or target.override_library is not None
                or not materials.is_measured(target)):
            cls.poll_message_set("There is no active material with a fit, or it belongs to another file")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        path = self._path(context)
        if path is None:
            return self.execute(context)
        return self.confirm(event, path) or self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.force and self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            # the user has agreed to replace a file; start anew as a modal operator, so that the window stays responsive
            with errors_reported(self):
                bpy.ops.measured_brdf.save_asset("INVOKE_DEFAULT", directory=self.directory, force=True)
            return {"CANCELLED"}
        if self._path(context) is not None:
            return self.run(context)
        target = present(active_material(context))
        try:
            picture = _thumbnail(target)
            with assets.unmarked_on_error(target):
                assets.renew(target, assets.remember(target), picture)
                if bpy.data.filepath:
                    assets.write_catalogue(Path(bpy.data.filepath).parent)
        except Exception as error:
            return self._failed(error)
        self.report({"INFO"}, f"{target.name} is an asset of this file; the preferences name no asset library")
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> Command:
        """Write a copy into a temporary folder, from which another Blender appends it to the library."""
        path, target = present(self._path(context)), present(active_material(context))
        self.check_replaceable(path)
        self._folder = process.temporary()
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

    def apply(self, context: bpy.types.Context, result: dict[str, Any]) -> None:
        path = Path(result["path"])
        self._folder.cleanup()
        _add_library(context, path.parent)
        self.report({"INFO"}, f"{path} written")

    def _path(self, context: bpy.types.Context) -> Path | None:
        """The .blend in the library for the active material; None if no library is named."""
        folder = self.directory or preferences.get(context).asset_library
        name = assets.file_name(present(active_material(context)).name)
        return real(bpy.path.abspath(folder)) / f"{name}.blend" if folder else None


def _thumbnail(target: bpy.types.Material) -> SingleArray | None:
    """The lit sphere of the fit in a material's shader; None if that is damaged, so that Blender renders a preview."""
    try:
        return tasks.kept_sphere(present(queries.kept(target)))
    except ValueError:
        return None


def _add_library(context: bpy.types.Context, folder: Path) -> None:
    """Add the folder to the asset libraries of Blender's preferences."""
    libraries = context.preferences.filepaths.asset_libraries
    if not any(real(bpy.path.abspath(known.path)) == real(folder) for known in libraries):
        libraries.new(name="Measured BRDF", directory=str(folder))


classes = (MEASUREDBRDF_OT_save_asset,)
