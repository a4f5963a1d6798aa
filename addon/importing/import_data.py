"""Imports files and folders of measurements as materials: with File > Import, and files by drag and drop."""

import os
import textwrap
from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, StringProperty

from ...fitter import ColumnsUnknownError, DatasetError, ImplausibleError, SampleUnknownError, UnitsUnknownError
from ...fitter.formats import EXTENSIONS, list_samples, open_choices
from ..core import preferences
from ..core.annotations import OperatorResult, not_none
from ..core.storage.properties import CHOICES, FitChoices, fit_arguments
from ..core.storage.reading import load_arguments
from ..panel.layout import name_beside_value
from ..work import making, process, tasks
from ..work.discovery import GLOB, sources_in
from ..work.making import MakesMaterials
from ..work.modal import AsksForPath, Steps, begin_another

IMPORT_DIALOG, _DIALOG_CHARACTER = 480, 7  # pixels: the width of a dialog, and of a character on average
_EDITORS = {"VIEW_3D", "PROPERTIES", "OUTLINER", "NODE_EDITOR", "FILE_BROWSER"}


class MEASUREDBRDF_OT_import_data(FitChoices, AsksForPath, MakesMaterials, bpy.types.Operator):
    """Make materials of files of measured reflectance, and assign the first to the object that they are dropped on, \
or else to all selected ones"""

    bl_idname = "measured_brdf.import_data"
    bl_label = "Import BRDF"                # on the button of the file browser, which has little room
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    complaint: StringProperty(options={"HIDDEN", "SKIP_SAVE"}, description="Why users are asked what the numbers are")
    is_checked: BoolProperty(options={"HIDDEN", "SKIP_SAVE"},
                             description="Whether users know that no surface is like this")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        making.begin_with_preference(self, context)
        if not self.filepath and not self.files:
            self.remember_target(context)
            folder = preferences.get(context).data_folder
            self.filepath = os.path.join(bpy.path.abspath(folder), "") if folder else ""    # a folder ends with a slash
            context.window_manager.fileselect_add(self)
            return {"RUNNING_MODAL"}
        self.remember_target(context, event)
        if self.complaint:
            return context.window_manager.invoke_props_dialog(self, width=IMPORT_DIALOG,
                                                              title="What Are These Numbers?",
                                                              confirm_text="Import")
        paths = self._paths()
        try:
            if len(paths) == 1 and not self.sample and len(list_samples(paths[0], self.columns or None)) > 1:
                return self._ask_for_sample()
        except ColumnsUnknownError as error:
            return self._report_failure(error)
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self.start(context)

    def draw(self, context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        name_beside_value(layout)
        if self.complaint:
            draw_complaint(layout, self.complaint)
            for name in ("angles", "quantity"):         # what the file does not say
                layout.prop(self, name)
            return
        if context.area is None or context.area.type != "FILE_BROWSER":
            layout.prop(self, "filepath")
        path = next((item.name for item in self.files if item.name), self.filepath)
        making.draw_choices(layout, self, path, with_sample="sample" in open_choices(path))

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.options.is_repeat_last:     # and another object may be active now
            self.target = 0
            return self.run(context)
        return super().execute(context)

    def property_values(self) -> dict[str, Any]:
        return super().property_values() | {"complaint": ""}

    def work(self, context: bpy.types.Context) -> process.Calculation:
        self.remember_target(context)
        making.begin_as_script(self)
        paths = self._paths()
        ask = _can_ask(self) and len(paths) == 1 and not self.is_checked
        return process.Calculation(
            partial(tasks.outcomes, [(path, self.sample) for path in paths], fit_arguments(self),
                    how=load_arguments(self), ask=ask))

    def _report_failure(self, error: Exception) -> OperatorResult:
        # another operator asks, and starts anew
        if _can_ask(self):
            if isinstance(error, UnitsUnknownError):
                checked = self.is_checked or isinstance(error, ImplausibleError)
                return begin_another(self, "import_data", **self.property_values() | {
                    "complaint": str(error), "is_checked": checked})
            if isinstance(error, ColumnsUnknownError) and len(self._paths()) == 1:
                return begin_another(self, "name_columns", **choices_and_target(self) | {
                    "filepath": self._paths()[0], "complaint": str(error)})
            if isinstance(error, SampleUnknownError):
                return self._ask_for_sample()
        return MakesMaterials._report_failure(self, error)

    def _ask_for_sample(self) -> OperatorResult:
        return begin_another(self, "choose_sample", **choices_and_target(self) | {"filepath": self._paths()[0]})

    def _paths(self) -> list[str]:
        return [str(Path(self.directory) / item.name) for item in self.files if item.name] or [
            bpy.path.abspath(self.filepath)]


class MEASUREDBRDF_OT_import_folder(making.FromFolder, MakesMaterials, bpy.types.Operator):
    """Make a material of every measurement in a folder. A CURET file gives one for each sample"""

    bl_idname = "measured_brdf.import_folder"
    bl_label = "Import Folder of Measured BRDFs"
    bl_options = {"REGISTER", "UNDO"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        self.remember_target(context)
        return super().invoke(context, event)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        self.remember_target(context)
        making.begin_as_script(self)
        sources, self._failures = sources_in([self.checked_folder()], self.columns or None)
        return process.Calculation(partial(tasks.outcomes, sources, fit_arguments(self), how=load_arguments(self)))

    def prepare(self, outcomes: making.Outcomes) -> Steps:
        return super().prepare([*self._failures, *outcomes])


class MEASUREDBRDF_FH_measurements(bpy.types.FileHandler):
    """Imports files of measured reflectance that are dropped onto the window."""

    bl_idname = "MEASUREDBRDF_FH_measurements"
    bl_label = "Measured BRDF"
    bl_import_operator = MEASUREDBRDF_OT_import_data.bl_idname
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type in _EDITORS


def _can_ask(operator: bpy.types.Operator) -> bool:
    return bool(operator.options.is_invoke) and not bpy.app.background


def draw_complaint(layout: bpy.types.UILayout, text: str) -> None:
    for number, line in enumerate(textwrap.wrap(text, IMPORT_DIALOG // _DIALOG_CHARACTER)):
        layout.label(text=line, icon="QUESTION" if number == 0 else "BLANK1")


def choices_and_target(operator: Any) -> dict[str, Any]:
    """The choices and the target of an operator, for another that goes on with them."""
    return {name: getattr(operator, name) for name in (*CHOICES, "target", "slot", "others")}


classes = (MEASUREDBRDF_OT_import_data, MEASUREDBRDF_OT_import_folder, MEASUREDBRDF_FH_measurements)
