"""What a mix of measured materials is made of: a stack of layers."""

import bpy

from ..core.annotations import not_none
from ..core.shading import material as materials
from ..panel import main
from ..panel.layout import MaterialPanel
from ..work import queries
from . import mix_group
from .operators import MEASUREDBRDF_OT_mix

_PICTURE_SCALE, _PICTURE = 3, 0.2  # of pictures, and their share of the width


class MEASUREDBRDF_PT_mix(MaterialPanel, bpy.types.Panel):
    """The materials that this one lays upon one another, the uppermost first, and the share of each. The mix follows \
what is changed of them"""

    bl_label = "Mix"
    bl_order = 10
    bl_parent_id = "MEASUREDBRDF_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.mix_node(context.material) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), not_none(context.material)
        for layer in mix_group.layers(not_none(materials.mix_node(material))):
            column = layout.column()
            column.enabled = material.is_editable
            _draw_layer(column, layer)


def _draw_layer(layout: bpy.types.UILayout, layer: mix_group.Layer) -> None:
    row, material = layout.split(factor=_PICTURE), layer.material
    if material is not None and queries.shown_fits(material) is not None:
        row.template_icon(icon_value=queries.material_sphere(material)[0], scale=_PICTURE_SCALE)
    else:
        row.label(text="")
    column = row.column(align=True)
    column.label(text="A material that has been deleted" if material is None else material.name)
    if layer.share is None:
        column.label(text="Base")
    elif layer.share.is_linked:
        column.label(text=f"Factor from {not_none(layer.share.links)[0].from_node.name}")
    else:
        column.prop(layer.share, "default_value", text=layer.share.name, slider=True)
    if material is not None:
        for draw_part in main.mix_part_rows:
            draw_part(layout, material)


def draw_button(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    layout.operator(MEASUREDBRDF_OT_mix.bl_idname, text="Mix...", icon="NODE_MATERIAL")


classes = (MEASUREDBRDF_PT_mix,)
