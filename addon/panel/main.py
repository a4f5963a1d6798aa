"""The main panel: what the material looks like and what it is worth, and how to begin. The sidebar shows the same.

Slices add buttons to it, and panels below it.
"""

import time
from collections.abc import Callable

import bpy

from ..core import manual, versions
from ..core.annotations import not_none
from ..core.blender import targets
from ..core.blender.active_material import active_material, can_change
from ..core.shading import material as materials
from ..core.shading import node_group
from ..core.storage.edits import edit_arguments
from ..core.storage.properties import label_of_fit, quality_summary
from ..work import modal, queries
from . import rendering
from .layout import MaterialPanel, draw_picture, draw_wrapped, has_data, name_beside_value, picture_scale
from .update import MEASUREDBRDF_OT_make_local, MEASUREDBRDF_OT_update_materials

start_buttons: list[Callable[[bpy.types.UILayout], None]] = []
"""Draw the buttons by which users begin, beside one another."""
unfitted_rows: list[Callable[[bpy.types.UILayout, bpy.types.Material], None]] = []
"""Draw what is to be done with a material that has measurements and no fit."""
material_buttons: list[Callable[[bpy.types.UILayout, bpy.types.Material], None]] = []
"""Draw the buttons for a material that shows measurements or a mix, beside one another."""
mix_part_rows: list[Callable[[bpy.types.UILayout, bpy.types.Material], None]] = []
"""Draw what can be changed of a material that a mix is made of."""


class _Main:
    """What the panels in the material tab and in the sidebar share: what is measured, or how to begin."""

    bl_label = "Measured BRDF"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_data(context) or (context.object is not None and targets.has_surface(context.object))

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), active_material(context)
        name_beside_value(layout)
        if material is not None and materials.is_shown(material):
            _draw_look(layout, context, material)
        _draw_start(layout)
        if material is None:
            return
        if materials.is_shown(material):
            _draw_version(layout, material)
        if not can_change(material):
            draw_wrapped(layout, "This material belongs to another file. Make it local to change it", "INFO")
            layout.operator(MEASUREDBRDF_OT_make_local.bl_idname, icon="LIBRARY_DATA_DIRECT")
        elif material.measured_brdf.filepath and not materials.is_shown(material):
            for draw_unfitted in unfitted_rows:
                draw_unfitted(layout, material)
        if materials.is_shown(material):
            row = layout.row(align=True)
            for draw_measured in material_buttons:
                draw_measured(row, material)


class MEASUREDBRDF_PT_material(_Main, MaterialPanel, bpy.types.Panel):
    """A material of measured reflectance"""

    bl_options = {"HIDE_HEADER"}            # panels without a header come first, below the list of materials


class MEASUREDBRDF_PT_sidebar(_Main, bpy.types.Panel):
    """The measured material of the active object"""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Measured BRDF"


def _draw_start(layout: bpy.types.UILayout) -> None:
    """Draw how to begin; while a job runs its progress, in the same place and of the same height."""
    row = layout.row(align=True)
    if draw_running(row):
        return
    for draw_beginning in start_buttons:
        draw_beginning(row)
    row.operator("wm.url_open", text="", icon="HELP").url = manual.url()


def draw_running(row: bpy.types.UILayout) -> bool:
    if modal.running is None:
        return False
    after = f" ({len(modal.waiting)} waiting)" if modal.waiting else ""
    left = modal.running.time_left(time.monotonic())
    row.progress(factor=modal.running.fraction,
                 text=f"{modal.running.doing}{after}" + (f": {left}" if left else ""))
    row.operator(modal.MEASUREDBRDF_OT_cancel.bl_idname, text="", icon="X")
    return True


def _draw_look(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material) -> None:
    settings = material.measured_brdf
    if queries.shown_fits(material) is not None:
        draw_picture(layout, *queries.material_sphere(material), picture_scale(context, 1))
    column = layout.column(align=True)
    name = f"{material.name}: Mix"
    if materials.is_measured(material):
        adjusted = ", adjusted" if edit_arguments(material) else ""
        name = f"{settings.name_of_data}: {label_of_fit(settings)}{adjusted}"
    draw_wrapped(column, name, "MATERIAL")
    if (value := quality_summary(settings)).line:
        draw_wrapped(column, value.line, value.icon)
    rendering.draw_words(column, context, material)


def _draw_version(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    if materials.is_outdated(material):
        column = layout.box().column()
        made_by = material.measured_brdf.version or "unknown"
        text = (f"Made by version {made_by}; this is {versions.CURRENT}. It renders as before. An update brings the "
                "improvements to all materials of this file")
        if not node_group.is_compiled(not_none(not_none(materials.group_node(material)).node_tree)):
            text = "Made where there is no OSL. An update compiles the shaders of all materials of this file"
        draw_wrapped(column, text, "INFO")
        column.operator(MEASUREDBRDF_OT_update_materials.bl_idname, icon="FILE_REFRESH")


classes = (MEASUREDBRDF_PT_material, MEASUREDBRDF_PT_sidebar)
