"""Choosing a sample of a CURET file by name, in a searchable list."""

import bpy
from bpy.props import BoolProperty, EnumProperty

from ...fitter import DatasetError
from ...fitter.formats import list_samples
from ..annotations import OperatorResult, present
from ..materials.properties import CHOICES, FitChoices
from .active_material import active_material
from .import_data import begin_with_preference

_items: list[tuple[str, str, str]] = []     # Blender keeps no reference to the strings that an items function returns


def _list(_operator: bpy.types.Operator, _context: bpy.types.Context | None) -> list[tuple[str, str, str]]:
    return _items


class MEASUREDBRDF_OT_choose_sample(FitChoices, bpy.types.Operator):
    """Choose a sample of this file by name"""

    bl_idname = "measured_brdf.choose_sample"
    bl_label = "Choose Sample"
    bl_options = {"INTERNAL"}
    bl_property = "item"

    item: EnumProperty(name="Sample", items=_list, options={"SKIP_SAVE"})
    for_material: BoolProperty(options={"SKIP_SAVE", "HIDDEN"})

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        if self.for_material:
            self.filepath = bpy.path.abspath(present(active_material(context)).measured_brdf.filepath)
        begin_with_preference(self, context)
        try:
            samples = list_samples(self.filepath)
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not samples:
            self.report({"INFO"}, "This file holds only one sample")
            return {"CANCELLED"}
        _items[:] = [(name, f"{name}  ({number})", f"CURET sample {number}") for number, name in samples]
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if self.for_material:
            present(active_material(context)).measured_brdf.sample = self.item
            return {"FINISHED"}
        choices = {name: getattr(self, name) for name in CHOICES} | {"sample": self.item}
        bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **choices)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_choose_sample,)
