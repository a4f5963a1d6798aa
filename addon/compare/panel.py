"""Renders of a material by Cycles, and of the pinned one beside it."""

import bpy

from ...fitter.imaging.pictures import split
from ..core.annotations import not_none
from ..core.shading import comparison
from ..panel.layout import SubPanel, picture_scale
from ..work import icons
from .curves import draw_line, draw_names
from .operators import MEASUREDBRDF_OT_render_look, render_key, renders


class MEASUREDBRDF_PT_look(SubPanel, bpy.types.Panel):
    """A render by Cycles, on a sphere or a shader ball, with the pinned material beside it"""

    bl_label = "Test Render"
    bl_order = 40

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = not_none(self.layout), not_none(context.scene), not_none(context.material)
        chosen = comparison.get(scene)
        layout.row().prop(chosen, "shape", expand=True)
        layout.row().prop(chosen, "lighting", expand=True)
        other = comparison.find_pinned(scene, material)
        wanted = [material] if other is None else [material, other]
        made = [renders[key] for each in wanted if (key := render_key(scene, each)) in renders]
        layout.operator(MEASUREDBRDF_OT_render_look.bl_idname, text="Render Both" if other is not None else "Render",
                        icon="RENDER_STILL")
        if len(made) < len(wanted):
            return
        (first, *_), (last, *_) = made[0], made[-1]
        icon = icons.at_once(("look", *(number for _, number in made), round(chosen.divide, 2)),
                             lambda: split(first, last, chosen.divide) if other is not None else first)
        layout.template_icon(icon_value=icon, scale=picture_scale(context, 1, 16))
        if other is not None:
            draw_line(layout, chosen)
            draw_names(layout, material, other)


classes = (MEASUREDBRDF_PT_look,)
