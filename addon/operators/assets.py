"""Keeping a measured material for other files."""

from pathlib import Path

import bpy
from bpy.props import StringProperty

from ...fitter import DatasetError
from .. import assets, preferences, work
from .. import material as materials
from ..properties import fit_arguments
from .fit import active_material


class MEASUREDBRDF_OT_save_asset(bpy.types.Operator):
    """Keep this material for other files: mark it as an asset, with a thumbnail, a catalogue, a description and tags, \
and write it into the asset library of the preferences, if there is one"""

    bl_idname = "measured_brdf.save_asset"
    bl_label = "Save to Asset Library"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Library", subtype="DIR_PATH", options={"SKIP_SAVE"},
                              description="Folder of the asset library; empty for that of the preferences, or for the "
                                          "open file where there is none")

    @classmethod
    def poll(cls, context):
        target = active_material(context)
        if target is None or not target.is_editable or not materials.is_measured(target):
            cls.poll_message_set("Fit a material of this file first")
            return False
        return True

    def execute(self, context):
        target = active_material(context)
        library = self.directory or preferences.get(context).asset_library
        was_asset = target.asset_data is not None
        assets.mark(target, _thumbnail(target))
        if not library:
            self.report({"INFO"}, f"{target.name} is an asset of this file; the preferences may name a library")
            if bpy.data.filepath:
                assets.write_catalogue(Path(bpy.data.filepath).parent)
            return {"FINISHED"}
        path = Path(bpy.path.abspath(library)) / f"{assets.file_name(target.name)}.blend"
        try:
            assets.write([target], path)
        except OSError as error:
            self.report({"ERROR"}, f"{path}: {error.strerror or error}; choose another asset library")
            return {"CANCELLED"}
        finally:
            if not was_asset:
                target.asset_clear()        # the library has it; this file need not offer it a second time
        _know(context, path.parent)
        self.report({"INFO"}, f"{path} written")
        return {"FINISHED"}


def _thumbnail(target):
    """The lit sphere where the measurements are at hand, else None: Blender renders one."""
    settings = target.measured_brdf
    try:
        data = work.read(bpy.path.abspath(settings.filepath), settings.sample)
    except DatasetError:
        return None
    return assets.thumbnail(work.fitted(data.samples, data.digest, fit_arguments(settings)).fit)


def _know(context, folder):
    """Let Blender's asset browser list the folder."""
    libraries = context.preferences.filepaths.asset_libraries
    if not any(Path(bpy.path.abspath(library.path)).resolve() == folder.resolve() for library in libraries):
        libraries.new(name="Measured BRDF", directory=str(folder))


classes = (MEASUREDBRDF_OT_save_asset,)
