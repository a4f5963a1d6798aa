"""The menu Measured BRDF, in the menus of objects and of materials. What is in a menu is found by searching (F3).

Slices append their entries to it.
"""

from collections.abc import Callable

import bpy

from .fixes import MEASUREDBRDF_OT_check_export, MEASUREDBRDF_OT_check_scene
from .rendering import MEASUREDBRDF_OT_add_studio, MEASUREDBRDF_OT_enable_osl
from .update import MEASUREDBRDF_OT_update_materials

_Draw = Callable[[bpy.types.Menu, bpy.types.Context], None]


def entries(*shown: tuple[type[bpy.types.Operator], str]) -> _Draw:
    """A function that draws operators in a menu, each by a text that may differ from that of its button."""
    def draw(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
        for operator, text in shown:
            menu.layout.operator(operator.bl_idname, text=text)
    return draw


class MEASUREDBRDF_MT_menu(bpy.types.Menu):
    """Import, fit and compare measured materials"""

    bl_idname = "MEASUREDBRDF_MT_menu"
    bl_label = "Measured BRDF"

    def draw(self, context: bpy.types.Context) -> None:
        _draw(self, context)


_draw = entries((MEASUREDBRDF_OT_update_materials, "Update Measured BRDFs"),
                (MEASUREDBRDF_OT_enable_osl, "Enable OSL for Measured BRDFs"),
                (MEASUREDBRDF_OT_check_scene, "Check Scene for Measured BRDFs"),
                (MEASUREDBRDF_OT_check_export, "Check Export of Measured BRDFs"))


def entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.menu(MEASUREDBRDF_MT_menu.bl_idname, icon="MATERIAL")


add_studio = entries((MEASUREDBRDF_OT_add_studio, "Measured BRDF Studio"))
"""Draws the entry of Add > Light."""
MENUS = ("VIEW3D_MT_object", "NODE_MT_node", "MATERIAL_MT_context_menu")
"""The menus of Blender that have this one."""
classes = (MEASUREDBRDF_MT_menu,)
