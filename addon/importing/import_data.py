"""Imports files of measurements as materials: with File > Import, and by drag and drop."""

import textwrap
from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import CollectionProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...fitter import DatasetError, SampleUnknownError, UnitsUnknownError
from ...fitter.formats import EXTENSIONS, choices_of, list_samples
from ..core import preferences
from ..core.annotations import OperatorResult, present
from ..core.properties import CHOICES, LEVELS, FitChoices, draw_presets, draw_rendering, fit_arguments
from ..core.reading import draw_reading, load_arguments
from ..work import process, tasks
from ..work.discovery import GLOB
from ..work.making import HasTarget, MakesMaterials, begin_with_preference
from ..work.modal import errors_reported

_DIALOG, _CHARACTER = 480, 7       # pixels: the width of a dialog, and of a character on average
_EDITORS = {"VIEW_3D", "PROPERTIES", "OUTLINER", "NODE_EDITOR", "FILE_BROWSER"}


class MEASUREDBRDF_OT_import_data(FitChoices, MakesMaterials, bpy.types.Operator):
    """Make materials of files of measured reflectance, and assign the first to the object that they are dropped on, \
or else to all selected ones"""

    bl_idname = "measured_brdf.import_data"
    bl_label = "Import Measured BRDF"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if not self.filepath and not self.files:
            with errors_reported(self):
                bpy.ops.measured_brdf.browse("INVOKE_DEFAULT")
            return {"CANCELLED"}            # the other operator continues; this one makes no undo step
        begin_with_preference(self, context)
        self.remember_target(context, event)
        paths = self._paths()
        try:
            if len(paths) == 1 and not self.sample and len(list_samples(paths[0])) > 1:
                return self._ask_for_sample()
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self.start(context)

    def draw(self, _context: bpy.types.Context) -> None:
        layout = present(self.layout)
        layout.prop(self, "filepath")
        _draw_choices(layout, self)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.options.is_repeat_last:     # and another object may be active now
            self.target = 0
        return self.run(context)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        self.remember_target(context)
        return process.Calculation(
            partial(tasks.outcomes, [(path, self.sample) for path in self._paths()], fit_arguments(self),
                    how=load_arguments(self)))

    def _failed(self, error: Exception) -> OperatorResult:
        # another operator asks, and starts anew
        if self.options.is_invoke and not bpy.app.background:
            if isinstance(error, UnitsUnknownError):
                with errors_reported(self):
                    bpy.ops.measured_brdf.say_units("INVOKE_DEFAULT", complaint=str(error), **_given(self))
                return {"CANCELLED"}
            if isinstance(error, SampleUnknownError):
                return self._ask_for_sample()
        return MakesMaterials._failed(self, error)

    def _ask_for_sample(self) -> OperatorResult:
        with errors_reported(self):
            bpy.ops.measured_brdf.choose_sample("INVOKE_DEFAULT", **given(self) | {"filepath": self._paths()[0]})
        return {"CANCELLED"}

    def _paths(self) -> list[str]:
        return [str(Path(self.directory) / item.name) for item in self.files if item.name] or [
            bpy.path.abspath(self.filepath)]


class MEASUREDBRDF_OT_browse(FitChoices, HasTarget, bpy.types.Operator, ImportHelper):
    """Choose files of measured reflectance and make materials of them"""

    bl_idname = "measured_brdf.browse"
    bl_label = "Import BRDF"                # on the button of the file browser, which has little room

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        begin_with_preference(self, context)
        self.remember_target(context)
        folder = preferences.get(context).data_folder
        if folder and not self.filepath:
            self.filepath = str(Path(bpy.path.abspath(folder)) / "")
        return super().invoke(context, event)

    def draw(self, _context: bpy.types.Context) -> None:
        _draw_choices(present(self.layout), self)

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        with errors_reported(self):
            bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **_given(self))
        return {"FINISHED"}


class MEASUREDBRDF_OT_say_units(FitChoices, HasTarget, bpy.types.Operator):
    """Choose what the numbers of a file are that does not say it, and import it"""

    bl_idname = "measured_brdf.say_units"
    bl_label = "What Are These Numbers?"
    bl_options = {"INTERNAL"}

    complaint: StringProperty(options={"HIDDEN", "SKIP_SAVE"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG, confirm_text="Import")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = present(self.layout)
        for number, line in enumerate(textwrap.wrap(self.complaint, _DIALOG // _CHARACTER)):
            layout.label(text=line, icon="QUESTION" if number == 0 else "BLANK1")
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("angles", "quantity"):
            layout.prop(self, name)

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        with errors_reported(self):
            bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **_given(self))
        return {"FINISHED"}


class MEASUREDBRDF_FH_measurements(bpy.types.FileHandler):
    """Imports files of measured reflectance that are dropped onto the window."""

    bl_idname = "MEASUREDBRDF_FH_measurements"
    bl_label = "Measured BRDF"
    bl_import_operator = MEASUREDBRDF_OT_import_data.bl_idname
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type in _EDITORS


def _draw_choices(layout: bpy.types.UILayout, operator: Any) -> None:
    """Draw the choices for an import."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    path = next((item.name for item in operator.files if item.name), operator.filepath)
    draw_presets(layout, operator)
    if "sample" in choices_of(path):
        layout.prop(operator, "sample")
    draw_rendering(layout, operator)
    header, body = layout.panel("MEASUREDBRDF_levels", default_closed=True)
    header.label(text="Fit Settings")
    if body is not None:
        for name in (*LEVELS, "use_tolerance", "tolerance"):
            row = body.row()
            row.active = name == "use_tolerance" or operator.use_tolerance == (name == "tolerance")
            row.prop(operator, name)
    draw_reading(layout, operator, path)


def given(operator: Any) -> dict[str, Any]:
    """The choices and the target of an operator, for another that goes on with them."""
    return {name: getattr(operator, name) for name in (*CHOICES, "target", "slot", "others")}


def _given(operator: Any) -> dict[str, Any]:
    """As `given`, and the files."""
    files = [{"name": item.name} for item in operator.files]
    return {"directory": operator.directory, "files": files, **given(operator)}


classes = (MEASUREDBRDF_OT_import_data, MEASUREDBRDF_OT_browse, MEASUREDBRDF_OT_say_units, MEASUREDBRDF_FH_measurements)
