"""What the file of measurements holds."""

import bpy

from ..annotations import present
from ..jobs import queries
from .layout import MaterialPanel


class MEASUREDBRDF_PT_data(MaterialPanel, bpy.types.Panel):
    """Directions, gaps and values of the measurements"""

    bl_label = "Measurements"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        data = queries.data(present(context.material)).result
        if data is None:
            return
        description = data.description
        layout.label(text=description.name)
        column = layout.column(align=True)
        for label, text, worrying in description.rows():
            split = column.split(factor=0.3)
            split.alert = worrying
            split.label(text=label)
            split.label(text=text, icon="ERROR" if worrying else "NONE")
