"""Imports files of measurements as materials: with File > Import, and by drag and drop."""

import textwrap
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.props import CollectionProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...fitter import DatasetError, UnitsUnknownError
from ...fitter.formats import EXTENSIONS, FORMAT_NAMES, list_samples
from .. import preferences
from ..annotations import OperatorResult, present
from ..jobs import process, tasks
from ..jobs.modal import InBackground, Steps
from ..library.discovery import GLOB
from ..materials import compiler, material
from ..materials.properties import CHOICES, LEVELS, READING, FitChoices, complete, fit_arguments, use_preset
from ..materials.reading import draw_reading, load_arguments
from ..transaction import by_session_uid

Outcomes = Sequence[tuple[str, str, tasks.Outcome | ValueError]]
"""As `tasks.outcomes` returns them."""
_Prepared = Sequence[tuple[str, str, tasks.Outcome | ValueError, compiler.Shader | None]]

_DIALOG, _CHARACTER = 480, 7       # pixels: the width of a dialog, and of a character on average
_EDITORS = {"VIEW_3D", "PROPERTIES", "OUTLINER", "NODE_EDITOR", "FILE_BROWSER"}


class MakesMaterials(InBackground):
    """A mix-in for operators whose work returns `Outcomes`: each becomes a material.

    The first is assigned to the object that was active when the work began. Files that failed are reported as warnings;
    if all of them failed, the first is reported as an error.
    """

    def remember_target(self, context: bpy.types.Context) -> None:
        """Remember the active object by its `session_uid`: it may be gone when the work is done."""
        self._target = context.object.session_uid if context.object is not None else None

    def prepare(self, outcomes: Outcomes) -> Steps:
        prepared: list[tuple[str, str, tasks.Outcome | ValueError, compiler.Shader | None]] = []
        for number, (path, sample, outcome) in enumerate(outcomes):
            if isinstance(outcome, Exception):
                prepared.append((path, sample, outcome, None))
            else:
                yield number / len(outcomes), f"Compiling {outcome.measured.name}"
                prepared.append((path, sample, outcome, compiler.compile_shader(outcome.source, outcome.nodes)))
        return prepared

    def apply(self, context: bpy.types.Context, prepared: _Prepared) -> None:
        made: list[bpy.types.Material] = []
        failed = [outcome for _, _, outcome, _ in prepared if isinstance(outcome, Exception)]
        if len(failed) == len(prepared):
            raise failed[0]
        choices = SimpleNamespace(**{name: getattr(self, name) for name in CHOICES})
        for path, sample, outcome, shader in prepared:
            if not isinstance(outcome, Exception):
                choices.filepath, choices.sample = path, sample
                made.append(material.create(outcome, choices, context, shader))
        for item in made[1:]:
            item.use_fake_user = True           # without a user, Blender does not save it
        target = by_session_uid(bpy.data.objects, self._target)
        if not assign_to(target, made[0]):
            made[0].use_fake_user = True
            self.report({"WARNING"}, f"{made[0].name} is not assigned: no active object can have a material")
        for error in failed:
            self.report({"WARNING"}, str(error))
        first = made[0].measured_brdf
        self.report({"INFO"}, f"{made[0].name}: {first.coefficients:,} coefficients, RMSE {first.rmse:.3g}"
                    if len(made) == 1 else f"{len(made)} materials; {len(failed)} files failed")


class MEASUREDBRDF_OT_import_data(FitChoices, MakesMaterials, bpy.types.Operator):
    """Make materials of files of measured reflectance, and assign the first to the active object"""

    bl_idname = "measured_brdf.import_data"
    bl_label = "Import Measured BRDF"
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        if not self.filepath and not self.files:
            bpy.ops.measured_brdf.browse("INVOKE_DEFAULT")
            return {"CANCELLED"}            # the other operator continues; this one makes no undo step
        begin_with_preference(self, context)
        paths = self._paths()
        try:
            if len(paths) == 1 and not self.sample and len(list_samples(paths[0])) > 1:
                bpy.ops.measured_brdf.choose_sample("INVOKE_DEFAULT", filepath=paths[0])
                return {"CANCELLED"}
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        complete(self)
        return self.run(context)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        self.remember_target(context)
        return process.Calculation(
            partial(tasks.outcomes, [(path, self.sample) for path in self._paths()], fit_arguments(self),
                    how=load_arguments(self)))

    def _failed(self, error: Exception) -> OperatorResult:
        if isinstance(error, UnitsUnknownError) and self.options.is_invoke and not bpy.app.background:
            bpy.ops.measured_brdf.say_units("INVOKE_DEFAULT", complaint=str(error), **_given(self))
            return {"CANCELLED"}            # the other operator asks, and starts anew
        return MakesMaterials._failed(self, error)

    def _paths(self) -> list[str]:
        return [str(Path(self.directory) / item.name) for item in self.files if item.name] or [
            bpy.path.abspath(self.filepath)]


class MEASUREDBRDF_OT_browse(FitChoices, bpy.types.Operator, ImportHelper):
    """Choose files of measured reflectance and make materials of them"""

    bl_idname = "measured_brdf.browse"
    bl_label = "Import Measured BRDF"

    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        begin_with_preference(self, context)
        folder = preferences.get(context).data_folder
        if folder and not self.filepath:
            self.filepath = str(Path(bpy.path.abspath(folder)) / "")
        return super().invoke(context, event)

    def draw(self, _context: bpy.types.Context) -> None:
        layout = present(self.layout)
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in CHOICES[1:]:
            if name not in READING:
                layout.prop(self, name)
        draw_reading(layout, self)

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **_given(self))
        return {"FINISHED"}


class MEASUREDBRDF_OT_say_units(FitChoices, bpy.types.Operator):
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


def _given(operator: Any) -> dict[str, Any]:
    """The files and choices of an operator, for another that goes on with them."""
    return {"directory": operator.directory, "files": [{"name": item.name} for item in operator.files],
            **{name: getattr(operator, name) for name in CHOICES}}


def begin_with_preference(operator: Any, context: bpy.types.Context) -> None:
    """Use the preset of the preferences if the caller gave no choices."""
    given = operator.properties.is_property_set
    if not any(given(name) for name in ("preset", "use_tolerance", *LEVELS)):
        use_preset(operator, preferences.get(context).preset)


def assign_to(target: bpy.types.Object | None, item: bpy.types.Material) -> bool:
    """Assign a material to the active slot of an object: whether that was possible."""
    if target is None or not hasattr(target.data, "materials") or not target.is_editable:
        return False
    slot = target.material_slots[present(target.active_material_index)] if target.material_slots else None
    if not target.data.is_editable and (slot is None or slot.link == "DATA"):
        return False
    if slot is None:
        target.data.materials.append(item)
    else:
        slot.material = item
    return True


def _menu_item(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(MEASUREDBRDF_OT_browse.bl_idname, text=f"Measured BRDF ({', '.join(FORMAT_NAMES)})")


classes = (MEASUREDBRDF_OT_import_data, MEASUREDBRDF_OT_browse, MEASUREDBRDF_OT_say_units, MEASUREDBRDF_FH_measurements)


def register() -> None:
    bpy.types.TOPBAR_MT_file_import.append(_menu_item)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(_menu_item)
