"""Asks what a file does not say: which of its samples is wanted, in a searchable list, and which column of a table is
which, where their names mean nothing or are not there."""

import textwrap
from typing import Any

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty

from ...fitter import DatasetError
from ...fitter.formats import list_samples, names, preview
from ..core.annotations import OperatorMixIn, OperatorResult, not_none
from ..core.blender.active_material import active_material, is_editable
from ..core.storage.properties import FitChoices
from ..panel.layout import name_beside_value
from ..work import icons
from ..work.making import HasTarget, begin_with_preference
from ..work.modal import errors_reported
from .import_data import IMPORT_DIALOG, choices_and_target, draw_complaint

_Item = tuple[str, str, str, int, int]
_items: list[_Item] = []     # Blender keeps no reference to the strings that an items function returns
_SKIP, _NAMED = "SKIP", "NAMED"
_MEANINGS = (
    (_SKIP, "Not Read", "This column is passed over"),
    ("theta_i", "Incident Angle", "Polar angle toward the light, from the normal"),
    ("theta_o", "Outgoing Angle", "Polar angle toward the detector, from the normal"),
    ("phi_i", "Incident Azimuth", "Azimuth of the light, from the tangent"),
    ("phi_o", "Outgoing Azimuth", "Azimuth of the detector, from the tangent"),
    ("phi", "Azimuth Between", "Azimuth between light and detector: 180 degrees to the mirror direction"),
    ("BRDF", "Value", "The only value"), ("R", "Red", "Linear"), ("G", "Green", "Linear"), ("B", "Blue", "Linear"),
    ("wavelength", "Wavelength", "Each wavelength has a row of its own"),
    ("standard", "White Standard", "What the detector read of a white standard"),
    (_NAMED, "As Named", "What its name says"))
_OF_ROLES = {"theta_s": "theta_o", "phi_s": "phi_o"}
_SHOWN = 24                 # columns in the dialog; the others are read as they are named
_CELL_LETTERS = 24       # characters of a cell


class AsksAboutFile(FitChoices, HasTarget, OperatorMixIn):
    """A mix-in for dialogs about a file that is to be imported, or about that of the active material."""

    for_material: BoolProperty(options={"SKIP_SAVE", "HIDDEN"})

    def is_refused(self, context: bpy.types.Context) -> bool:
        """Whether it is asked for a material that cannot be changed, which is reported."""
        refused = self.for_material and not is_editable(type(self), context)
        if refused:
            self.report({"ERROR"}, "There is no active material, or it belongs to another file")
        return refused

    def path(self, context: bpy.types.Context) -> str:
        own = self.for_material and not self.filepath
        return bpy.path.abspath(not_none(active_material(context)).measured_brdf.filepath if own else self.filepath)


def _list(_operator: bpy.types.Operator, _context: bpy.types.Context | None) -> list[_Item]:
    return _items


class MEASUREDBRDF_OT_choose_sample(AsksAboutFile, bpy.types.Operator):
    """Choose a sample of this file by name"""

    bl_idname = "measured_brdf.choose_sample"
    bl_label = "Choose Sample"
    bl_options = {"INTERNAL"}
    bl_property = "item"

    item: EnumProperty(name="Sample", items=_list, options={"SKIP_SAVE"})
    refit: StringProperty(options={"SKIP_SAVE", "HIDDEN"})         # the preset to fit with then; empty: do not fit

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        if self.is_refused(context):
            return {"CANCELLED"}
        begin_with_preference(self, context)
        path = self.path(context)
        try:
            samples = list_samples(path)
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not samples:
            self.report({"INFO"}, "This file holds only one sample")
            return {"CANCELLED"}
        _items[:] = [(name, f"{name}  ({number})", f"CURET sample {number}",
                      next((icon(path, name) for icon in icons.sample_icons), 0), place)
                     for place, (number, name) in enumerate(samples)]
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.is_refused(context):
            return {"CANCELLED"}
        with errors_reported(self):
            if not self.for_material:
                bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **choices_and_target(self) | {"sample": self.item})
                return {"FINISHED"}
            not_none(active_material(context)).measured_brdf.sample = self.item
            if self.refit:
                bpy.ops.measured_brdf.fit("INVOKE_DEFAULT", filepath=self.filepath, preset=self.refit)
        return {"FINISHED"}


class MeasuredColumn(bpy.types.PropertyGroup):
    """A column of a table: its name, its first numbers, and what it is."""

    label: StringProperty()
    numbers: StringProperty()
    meaning: EnumProperty(name="Meaning", items=_MEANINGS, default=_SKIP)


class MEASUREDBRDF_OT_name_columns(AsksAboutFile, bpy.types.Operator):
    """Say which column of this table is which"""

    bl_idname = "measured_brdf.name_columns"
    bl_label = "Which Column Is Which?"
    bl_options = {"INTERNAL"}

    table: CollectionProperty(type=MeasuredColumn, options={"HIDDEN", "SKIP_SAVE"})
    complaint: StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        if self.is_refused(context):
            return {"CANCELLED"}
        begin_with_preference(self, context)
        try:
            fill(self, self.path(context))
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return context.window_manager.invoke_props_dialog(self, width=IMPORT_DIALOG, confirm_text="Read")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        draw_complaint(layout, self.complaint)
        column = layout.column(align=True)
        for item in self.table[:_SHOWN]:
            row = column.split(factor=0.3)
            row.label(text=item.label)
            right = row.split(factor=0.5)
            right.label(text=item.numbers)
            right.prop(item, "meaning", text="")
        if len(self.table) > _SHOWN:
            layout.label(text=f"{len(self.table) - _SHOWN} more columns are read as they are named", icon="BLANK1")
        name_beside_value(layout)
        for name in ("angles", "quantity"):
            layout.prop(self, name)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        self.columns = stated_columns(self.table)
        with errors_reported(self):
            if not self.for_material:
                bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **choices_and_target(self))
                return {"FINISHED"}
            settings = not_none(active_material(context)).measured_brdf
            for name in ("columns", "angles", "quantity"):
                setattr(settings, name, getattr(self, name))
        return {"FINISHED"}


def fill(operator: Any, path: str) -> None:
    """Fill the dialog with the columns of a file, and what their names say. Raises DatasetError."""
    heads, rows = preview(path)
    operator.table.clear()
    for number in range(len(rows[0])):
        item = operator.table.add()
        cells = [textwrap.shorten(row[number], _CELL_LETTERS, placeholder="...") for row in rows if number < len(row)]
        item.label, item.numbers = heads[number] if heads else f"Column {number + 1}", ", ".join(cells)
        item.meaning = _meaning(heads[number]) if heads else _SKIP


def _meaning(name: str) -> str:
    role = names.role(name)
    role = _OF_ROLES.get(role or "", role)
    if role in {key for key, *_ in _MEANINGS}:
        return str(role)
    value = names.value(name)
    return _SKIP if value is None else _NAMED


def stated_columns(table: Any) -> str:
    """What users have said, as the option `columns` of reading."""
    words = []
    for item in table:
        named = item.label.replace('"', "'")
        words.append({_SKIP: "-", _NAMED: f'"{named}"'}.get(item.meaning, item.meaning))
    return ",".join(words)


classes = (MEASUREDBRDF_OT_choose_sample, MeasuredColumn, MEASUREDBRDF_OT_name_columns)
