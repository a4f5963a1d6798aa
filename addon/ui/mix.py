"""What a mix of measured materials is made of."""

import bpy

from ..annotations import present
from ..materials import material as materials
from ..materials import mix_group
from .layout import draw_wrapped


def draw_mix(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Draw which materials a mix has, and by which factor."""
    node = present(materials.mix_node(material))
    names = [item.name if item is not None else "a material that has been deleted"
             for item in mix_group.parts(present(node.node_tree))]
    draw_wrapped(layout, "A mix, which follows changes of both materials", "MATERIAL")
    for number, name in enumerate(names):
        draw_wrapped(layout, f"Factor {number}: {name}", "DOT")
    factor = node.inputs[mix_group.FACTOR]
    if factor.is_linked:
        draw_wrapped(layout, f"The factor comes from {present(factor.links)[0].from_node.name}", "DOT")
    else:
        layout.prop(factor, "default_value", text=factor.name, slider=True)
