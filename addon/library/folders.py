"""Converts a folder of measurements to an asset library."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from ..core import preferences
from ..core.annotations import OperatorResult, not_none
from ..core.storage.properties import NO_SPECULAR_LEVEL
from ..core.storage.reading import load_arguments
from ..work.blender_process import Command
from ..work.command import DONE, Row
from ..work.making import FromFolder
from ..work.modal import InBackground
from .operators import ReplacesFile


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


classes = (MEASUREDBRDF_OT_convert_folder,)
