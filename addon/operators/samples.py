"""Choosing one of the samples of a CURET file by its name, in a list that can be searched."""

import bpy
from bpy.props import BoolProperty, EnumProperty

from ...fitter import DatasetError
from ...fitter.formats import list_samples
from ..materials.properties import CHOICES, FitChoices
from .fit import active_material
from .import_data import begin_with_preference

_items = []                 # Blender keeps no reference to the texts of a list that a function makes


def _list(_operator, _context):
    return _items


class MEASUREDBRDF_OT_choose_sample(FitChoices, bpy.types.Operator):
    """Choose one of the samples in this file by its name"""

    bl_idname = "measured_brdf.choose_sample"
    bl_label = "Choose Sample"
    bl_options = {"INTERNAL"}
    bl_property = "item"

    item: EnumProperty(name="Sample", items=_list, options={"SKIP_SAVE"})
    for_material: BoolProperty(options={"SKIP_SAVE", "HIDDEN"})

    def invoke(self, context, _event):
        if self.for_material:
            self.filepath = bpy.path.abspath(active_material(context).measured_brdf.filepath)
        begin_with_preference(self, context)
        try:
            samples = list_samples(self.filepath)
        except DatasetError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not samples:
            self.report({"INFO"}, "This file holds one sample only")
            return {"CANCELLED"}
        _items[:] = [(name, f"{name}  ({number})", f"CURET sample {number}") for number, name in samples]
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        if self.for_material:
            active_material(context).measured_brdf.sample = self.item
            return {"FINISHED"}
        choices = {name: getattr(self, name) for name in CHOICES} | {"sample": self.item}
        bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", **choices)
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_choose_sample,)
