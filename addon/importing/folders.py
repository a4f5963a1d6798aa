"""Imports all measurements of a folder as materials."""

from functools import partial

import bpy

from ..core.annotations import OperatorResult
from ..core.properties import fit_arguments
from ..core.reading import load_arguments
from ..work import process, tasks
from ..work.discovery import sources_in
from ..work.making import FromFolder, MakesMaterials, Outcomes
from ..work.modal import Steps


class MEASUREDBRDF_OT_import_folder(FromFolder, MakesMaterials, bpy.types.Operator):
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


classes = (MEASUREDBRDF_OT_import_folder,)
