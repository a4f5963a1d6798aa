"""What artists change of a measured material."""

import bpy

from ..core.annotations import not_none
from ..core.blender.active_material import active_material
from ..core.shading import material as materials
from ..core.storage import edits
from ..panel.layout import MaterialPanel, SubPanel, choices, is_narrow, name_beside_value
from . import flakes
from .operators import VARIATION_ITEMS, MEASUREDBRDF_OT_adjust
from .settings import edit_arguments, get

_TEXTURED = "Tint", "Strength", "Normal"        # inputs of the node


def draw(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    settings = get(material)
    name_beside_value(layout)
    layout.enabled = material.is_editable
    buttons = choices(layout, [label for _, label, _ in VARIATION_ITEMS[1:]])
    for name, label, _ in VARIATION_ITEMS[1:]:
        buttons.operator(MEASUREDBRDF_OT_adjust.bl_idname, text=label).variation = name
    for names in (("diffuse_gain", "diffuse_tint"), ("highlight_gain", "highlight_tint", "highlight_width"),
                  ("coat",)):
        column = layout.column(align=True)
        _draw_sliders(column, settings, names)
    column = layout.column(align=True)
    column.active = settings.coat > 0
    _draw_sliders(column, settings, ("coat_roughness",))
    row = layout.column(align=True) if is_narrow() else layout.row(align=True)
    apply = row.row(align=True)
    apply.enabled = not edits.is_as_wanted(material)
    apply.operator(MEASUREDBRDF_OT_adjust.bl_idname, text="Apply").reset = False
    back = row.row(align=True)
    back.enabled = bool(edit_arguments(material)) or not edits.is_as_wanted(material)
    back.operator(MEASUREDBRDF_OT_adjust.bl_idname, text="As Measured", icon="LOOP_BACK").reset = True


def _draw_sliders(column: bpy.types.UILayout, settings: bpy.types.PropertyGroup, names: tuple[str, ...]) -> None:
    """Draw sliders with their names before them, or, where these would be cut, above them."""
    is_above = is_narrow()
    column.use_property_split = not is_above
    for name in names:
        if is_above:
            column.label(text=settings.bl_rna.properties[name].name)
            column.prop(settings, name, text="", slider=True)
        else:
            column.prop(settings, name, slider=True)


def draw_mix_part(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Draw the adjustments of a material that a mix is made of, where they are asked for."""
    if not materials.is_measured(material):
        return
    header, body = layout.panel(f"MEASUREDBRDF_adjust_{material.session_uid}", default_closed=True)
    header.label(text="Adjust")
    if body is not None:
        body.context_pointer_set("material", material)
        draw(body, material)


class _Adjust:
    """What the panels in the material tab and in the sidebar share."""

    bl_label = "Adjust"
    bl_order = 10

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        material = active_material(context)
        return material is not None and materials.is_measured(material)

    def draw(self, context: bpy.types.Context) -> None:
        draw(not_none(self.layout), not_none(active_material(context)))


class MEASUREDBRDF_PT_adjust(_Adjust, MaterialPanel, bpy.types.Panel):
    """Diffuse part, highlight and a coat; exact in every rendering"""

    bl_parent_id = "MEASUREDBRDF_PT_material"


class MEASUREDBRDF_PT_adjust_sidebar(_Adjust, bpy.types.Panel):
    """Diffuse part, highlight and a coat; exact in every rendering"""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Measured BRDF"
    bl_parent_id = "MEASUREDBRDF_PT_sidebar"


class MEASUREDBRDF_PT_texture(SubPanel, bpy.types.Panel):
    """What varies over the surface: a colour that multiplies the reflectance, bumps and flakes"""

    bl_label = "Texture and Flakes"
    bl_order = 15

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), not_none(context.material)
        node = not_none(materials.surface_node(material))
        name_beside_value(layout)
        layout.enabled = material.is_editable
        for name in _TEXTURED:
            layout.template_node_view(material.node_tree, node, node.inputs[name])
        layout.operator(flakes.MEASUREDBRDF_OT_add_flakes.bl_idname)


classes = (MEASUREDBRDF_PT_adjust, MEASUREDBRDF_PT_adjust_sidebar, MEASUREDBRDF_PT_texture)
