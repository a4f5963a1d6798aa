"""Saves a measured material as an asset, and converts a folder of measurements to an asset library."""

from pathlib import Path
from typing import Any, cast

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...fitter.arrays import SingleArray
from ...fitter.storage.files import real_path
from ..core import preferences
from ..core.annotations import OperatorMixIn, OperatorResult, not_none
from ..core.blender.active_material import active_material
from ..core.libraries import assets, library_file
from ..core.shading import material as materials
from ..core.storage import paths
from ..core.storage.outcomes import Shown
from ..core.storage.properties import NO_SPECULAR_LEVEL
from ..core.storage.reading import load_arguments
from ..work import process, queries, tasks
from ..work.blender_process import Command
from ..work.command import DONE, Row
from ..work.making import FromFolder
from ..work.modal import InBackground, begin_another

_REAL_ROOT = real_path(Path(__file__).parents[2])
_THIS_FILE = "LOCAL"        # in the place of the path of a library
_items: list[tuple[str, str, str]] = []     # Blender keeps no reference to the strings that an items function returns


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
        reason = library_file.refusal(path)
        if reason and not self.force:
            raise library_file.LibraryError(f"{reason}. Choose another name")

    def force_option(self) -> list[str]:
        return ["--force"] if self.force else []


def _libraries(_operator: object, context: bpy.types.Context | None) -> list[tuple[str, str, str]]:
    """The library of the extension's preferences, those that Blender has registered, and the open file, as choices.

    Libraries inside of extensions are left out: an update replaces them.
    """
    if context is None:
        return []
    own, extensions = preferences.get(context).asset_library, real_path(bpy.utils.user_resource("EXTENSIONS"))
    libraries = [(own, "Measured BRDF")] if own else []
    libraries += [(each.path, each.name) for each in context.preferences.filepaths.asset_libraries if each.path
                  and not {extensions, _REAL_ROOT} & {*real_path(bpy.path.abspath(each.path)).parents}]
    _items[:] = [(path, name, f"Save into {path}") for path, name in dict(libraries).items()]
    _items.append((_THIS_FILE, "Current File", "Make the material an asset of the open file"))
    return _items


class MEASUREDBRDF_OT_save_asset(ReplacesFile, InBackground, bpy.types.Operator):
    """Make this material an asset with a thumbnail, a description and tags, and save it in an asset library, for use \
in other files"""

    bl_idname = "measured_brdf.save_asset"
    bl_label = "Save to Asset Library"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"},
                              description="Folder of the asset library. Empty: the one in the preferences, or the open "
                                          "file if they name none")
    library: EnumProperty(name="Asset Library", items=_libraries, options={"SKIP_SAVE"},
                          description="Asset library of Blender's preferences to save into")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        if (target is None or not target.is_editable or target.override_library is not None
                or not (materials.is_measured(target) or materials.mix_node(target))):
            cls.poll_message_set("There is no active material with a fit, or it belongs to another file")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if not self.directory and not bpy.app.background:
            return context.window_manager.invoke_props_dialog(self, confirm_text="Save")
        path = self._path(context)
        if path is None:
            return self.execute(context)
        return self.confirm(event, path) or self.start(context)

    def draw(self, _context: bpy.types.Context) -> None:
        not_none(self.layout).prop(self, "library", text="")

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            directory = self.directory or self.library
            if directory == _THIS_FILE:
                return self._mark_here(context)
            # the user has answered; start anew as a modal operator, so that the window stays responsive
            return begin_another(self, "save_asset", directory=directory, force=self.force)
        return self._mark_here(context) if self._path(context) is None else self.run(context)

    def _mark_here(self, context: bpy.types.Context) -> OperatorResult:
        target = not_none(active_material(context))
        try:
            picture = _thumbnail(target)
            with assets.unmarked_on_error(target):
                assets.renew(target, assets.remember(target), picture)
                if bpy.data.filepath:
                    assets.write_catalogue(Path(bpy.data.filepath).parent)
        except Exception as error:
            return self._report_failure(error)
        self.report({"INFO"}, f"{target.name} is an asset of this file")
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> Command:
        """Write a copy into a temporary folder, from which another Blender appends it to the library."""
        path, target = not_none(self._path(context)), not_none(active_material(context))
        self.check_replaceable(path)
        self._folder = process.temporary()
        picture, source = _thumbnail(target), Path(self._folder.name, "material.blend")
        copy, name = target.copy(), target.name
        try:
            target.name, copy.name = f"{name} (kept)", name
            copy.measured_brdf.filepath = paths.absolute(target)
            assets.renew(copy, assets.remember(copy), picture)
            bpy.data.libraries.write(str(source), {copy}, path_remap="ABSOLUTE", fake_user=True)
        finally:
            bpy.data.materials.remove(copy)
            target.name = name
        return Command("save", source, path, *self.force_option())

    def apply(self, context: bpy.types.Context, result: dict[str, Any]) -> None:
        path = Path(result["path"])
        self._folder.cleanup()
        libraries = context.preferences.filepaths.asset_libraries
        if not any(real_path(bpy.path.abspath(known.path)) == real_path(path.parent) for known in libraries):
            libraries.new(name="Measured BRDF", directory=str(path.parent))
        self.report({"INFO"}, f"{path} written")

    def _path(self, context: bpy.types.Context) -> Path | None:
        """The .blend in the library for the active material; None if no library is named."""
        folder = self.directory or preferences.get(context).asset_library
        name = assets.file_name(not_none(active_material(context)).name)
        return real_path(bpy.path.abspath(folder)) / f"{name}.blend" if folder else None


def _thumbnail(target: bpy.types.Material) -> SingleArray | None:
    """The lit sphere of the fit in a material's shader; None if that is damaged, so that Blender renders a preview."""
    try:
        return tasks.lit_sphere(cast(Shown, queries.shown_fits(target)), None)
    except ValueError:
        return None


class MEASUREDBRDF_OT_convert_folder(FromFolder, ReplacesFile, InBackground, bpy.types.Operator):
    """Make an asset library of all measurements in a folder: a .blend of materials with thumbnails. \
The open file does not change"""

    bl_idname = "measured_brdf.convert_folder"
    bl_label = "Convert Folder to Asset Library"
    bl_options = {"REGISTER"}

    library: StringProperty(name="Library", subtype="FILE_PATH",
                            description="The .blend to write. Empty: a .blend with the name of the folder, in the "
                                        "asset library of the preferences, or in the folder itself")

    def draw(self, context: bpy.types.Context) -> None:
        FromFolder.draw(self, context)
        not_none(self.layout).prop(self, "library")

    def begin(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        return self.confirm(event, self._path(context)) or self.start(context)

    def work(self, context: bpy.types.Context) -> Command:
        folder, path = self.checked_folder(), self._path(context)
        self.check_replaceable(path)
        level = "none" if self.specular_level == NO_SPECULAR_LEVEL else self.specular_level
        options: list[object] = ["--preset", self.preset, "--rendering", self.rendering,
                                 "--diffuse-level", self.diffuse_level, "--specular-level", level,
                                 "--compression", round(self.compression, 4)]
        if self.use_tolerance:
            options += ["--tolerance", round(self.tolerance, 7)]
        for name, value in load_arguments(self).items():
            options += [] if value is None else [f"--{name.replace('_', '-')}", value]
        return Command("convert", folder, "-o", path, *options, *self.force_option())

    def apply(self, _context: bpy.types.Context, result: dict[str, Any]) -> None:
        rows, path = [Row(*row) for row in result["rows"]], result["path"]
        failed = [row for row in rows if row.status.startswith("failed")]
        for row in failed:
            self.report({"WARNING"}, f"{row.name} {row.status}")
        for row in rows:
            if row.doubts:
                self.report({"WARNING"}, f"{row.name}: {'. '.join(row.doubts)}")
        self.report({"INFO"}, f"{path}: {sum(row.status in DONE for row in rows)} materials; {len(failed)} files "
                    "failed")

    def _path(self, context: bpy.types.Context) -> Path:
        """The library to write."""
        folder = Path(bpy.path.abspath(self.directory))
        home = Path(bpy.path.abspath(preferences.get(context).asset_library or str(folder)))
        return Path(bpy.path.abspath(self.library)) if self.library else home / f"{folder.name}.blend"


classes = (MEASUREDBRDF_OT_save_asset, MEASUREDBRDF_OT_convert_folder)
