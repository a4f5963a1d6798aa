"""Choosing a sample of a CURET file by name, in a searchable list."""

import bpy
from bpy.props import EnumProperty, StringProperty

from ...fitter import DatasetError
from ...fitter.formats import list_samples
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material
from ..work import icons
from ..work.making import begin_with_preference
from ..work.modal import errors_reported
from .import_data import AsksAboutFile, choices_and_target

_Item = tuple[str, str, str, int, int]
_items: list[_Item] = []     # Blender keeps no reference to the strings that an items function returns


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


classes = (MEASUREDBRDF_OT_choose_sample,)
