"""What a mix of measured materials is made of."""

import bpy

from ..core import material as materials
from ..core.annotations import not_none
from ..panel.layout import MaterialPanel, draw_wrapped
from . import mix_group
from .operators import MEASUREDBRDF_OT_mix


class MEASUREDBRDF_PT_mix(MaterialPanel, bpy.types.Panel):
    """The materials that this one mixes, and how much of each"""

    bl_label = "Mix"
    bl_order = 10
    bl_parent_id = "MEASUREDBRDF_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.mix_node(context.material) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, node = not_none(self.layout), not_none(materials.mix_node(not_none(context.material)))
        draw_wrapped(layout, "It follows changes of both materials", "MATERIAL")
        for place, item in zip(("Base", "On Top"), mix_group.parts(not_none(node.node_tree)), strict=True):
            draw_wrapped(layout, f"{place}: {'a material that has been deleted' if item is None else item.name}", "DOT")
        factor = node.inputs[mix_group.FACTOR]
        if factor.is_linked:
            draw_wrapped(layout, f"The factor comes from {not_none(factor.links)[0].from_node.name}", "DOT")
        else:
            layout.prop(factor, "default_value", text=factor.name, slider=True)


def draw_button(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    """Draw the button that mixes a material with another."""
    layout.operator(MEASUREDBRDF_OT_mix.bl_idname, text="Mix...", icon="NODE_MATERIAL")


classes = (MEASUREDBRDF_PT_mix,)
