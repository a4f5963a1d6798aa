"""Whole folders of measurements: imports them as materials, or converts them to an asset library."""

from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from .. import preferences
from ..annotations import OperatorMixIn, OperatorResult, present
from ..jobs import process, tasks
from ..jobs.blender_process import Command
from ..jobs.modal import InBackground, Steps, errors_reported
from ..library import batch
from ..library.discovery import GLOB, files_in, sources_in
from ..materials.properties import NO_SPECULAR_LEVEL, FitChoices, fit_arguments
from ..materials.reading import load_arguments
from .assets import ReplacesFile
from .import_data import MakesMaterials, Outcomes, begin_with_preference


class _FromFolder(FitChoices, OperatorMixIn):
    """A mix-in for operators that ask for a folder. It precedes `InBackground` among the bases."""

    directory: StringProperty(name="Folder", subtype="DIR_PATH", options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        begin_with_preference(self, context)
        if self.directory:
            return self.begin(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        # the file browser calls this; start anew as a modal operator, so that the window stays responsive
        if self.options.is_invoke and not self.options.is_repeat and not bpy.app.background:
            again = getattr(bpy.ops.measured_brdf, type(self).__name__.partition("_OT_")[2])
            with errors_reported(self):
                again("INVOKE_DEFAULT", **present(self.as_keywords(ignore=("filepath",))))
            return {"CANCELLED"}
        return self.run(context)

    def begin(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Continue with the chosen folder: what `invoke` returns."""
        return self.start(context)

    def checked_folder(self) -> str:
        """The path of the folder; an error if it has no files that may hold measurements."""
        folder = bpy.path.abspath(self.directory)
        if not Path(folder).is_dir():
            raise ValueError(f"{folder}: not a folder")
        if not files_in([folder]):
            raise ValueError(f"{self.directory}: no files of measurements ({GLOB}); choose a folder that has some")
        return folder


class MEASUREDBRDF_OT_import_folder(_FromFolder, MakesMaterials, bpy.types.Operator):
    """Make a material of every measurement in a folder. A CURET file gives one for each sample"""

    bl_idname = "measured_brdf.import_folder"
    bl_label = "Import Folder of Measured BRDFs"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        self.remember_target(context)
        return super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        self.remember_target(context)
        sources, self._failures = sources_in([self.checked_folder()])
        return process.Calculation(partial(tasks.outcomes, sources, fit_arguments(self), how=load_arguments(self)))

    def prepare(self, outcomes: Outcomes) -> Steps:
        return super().prepare([*self._failures, *outcomes])


class MEASUREDBRDF_OT_convert_folder(_FromFolder, ReplacesFile, InBackground, bpy.types.Operator):
    """Make an asset library of all measurements in a folder: a .blend of materials with thumbnails. \
The open file does not change"""

    bl_idname = "measured_brdf.convert_folder"
    bl_label = "Convert Folder to Asset Library"
    bl_options = {"REGISTER"}

    library: StringProperty(name="Library", subtype="FILE_PATH",
                            description="The .blend to write. Empty: a .blend with the name of the folder, in the "
                                        "asset library of the preferences, or in the folder itself")

    def begin(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        return self.confirm(event, self._path(context)) or self.start(context)

    def work(self, context: bpy.types.Context) -> Command:
        folder, path = self.checked_folder(), self._path(context)
        self.check_replaceable(path)
        level = "none" if self.specular_level == NO_SPECULAR_LEVEL else self.specular_level
        options: list[object] = ["--preset", self.preset, "--diffuse-level", self.diffuse_level,
                                 "--specular-level", level, "--compression", round(self.compression, 4)]
        if self.use_tolerance:
            options += ["--tolerance", round(self.tolerance, 7)]
        for name, value in load_arguments(self).items():
            options += [] if value is None else [f"--{name}", value]
        return Command("convert", folder, "-o", path, *options, *self.force_option())

    def apply(self, _context: bpy.types.Context, result: dict[str, Any]) -> None:
        rows, path = result["rows"], result["path"]
        failed = [(name, status) for name, status, *_ in rows if status.startswith("failed")]
        for name, status in failed:
            self.report({"WARNING"}, f"{name} {status}")
        self.report({"INFO"}, f"{path}: {sum(status in batch.DONE for _, status, *_ in rows)} materials; {len(failed)} "
                    "files failed")

    def _path(self, context: bpy.types.Context) -> Path:
        """The library to write."""
        folder = Path(bpy.path.abspath(self.directory))
        home = Path(bpy.path.abspath(preferences.get(context).asset_library or str(folder)))
        return Path(bpy.path.abspath(self.library)) if self.library else home / f"{folder.name}.blend"


classes = (MEASUREDBRDF_OT_import_folder, MEASUREDBRDF_OT_convert_folder)


def _menu_items(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(MEASUREDBRDF_OT_import_folder.bl_idname, text="Measured BRDFs (folder)")
    menu.layout.operator(MEASUREDBRDF_OT_convert_folder.bl_idname, text="Measured BRDFs (folder to asset library)")


def register() -> None:
    bpy.types.TOPBAR_MT_file_import.append(_menu_items)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_menu_items)
