"""The button that opens the lobe over the 3D view."""

import bpy

from ..core import material as materials
from ..core.active_material import active_material
from ..core.annotations import present
from . import session
from .operators import MEASUREDBRDF_OT_inspect


def draw_button(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Draw the button of the main panel; mixes have no lobe of their own."""
    if materials.group_node(material) is not None:
        _draw(layout, "Inspect")


def _draw(layout: bpy.types.UILayout, text: str) -> None:
    """Draw the button; while it runs, one that ends it."""
    running = session.running is not None
    row = layout.row(align=True)
    row.operator_context = "INVOKE_DEFAULT"
    row.operator(MEASUREDBRDF_OT_inspect.bl_idname, icon="X" if running else "LIGHT_HEMI",
                 text="End Inspection" if running else text)


class MEASUREDBRDF_PT_inspect(bpy.types.Panel):
    """The lobe of the material as an overlay, with the light dragged"""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Measured BRDF"
    bl_label = "Inspect Reflectance"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        material = active_material(context)
        return material is not None and materials.group_node(material) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout = present(self.layout)
        _draw(layout, "Inspect in the Viewport")
        column = layout.column(align=True)
        column.operator_context = "INVOKE_DEFAULT"
        column.enabled = session.running is None
        for place, label in (("CURSOR", "At the 3D Cursor"), ("ORIGIN", "At the Origin")):
            column.operator(MEASUREDBRDF_OT_inspect.bl_idname, text=label).place = place


classes = (MEASUREDBRDF_PT_inspect,)
