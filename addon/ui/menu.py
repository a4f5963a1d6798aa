"""The menu Measured BRDF, in the menus of objects and of materials. What is in a menu is found by searching (F3)."""

import bpy

from ..operators import assets, checks, compare, fit, folders, import_data, large_view, library, mix, rendering, update
from ..viewport import inspect_reflectance

# what it says, for those that are called something else on a button
_ENTRIES: tuple[tuple[type[bpy.types.Operator], str], ...] = (
    (import_data.MEASUREDBRDF_OT_browse, "Import Measured BRDF..."),
    (folders.MEASUREDBRDF_OT_import_folder, "Import Folder of Measured BRDFs..."),
    (folders.MEASUREDBRDF_OT_convert_folder, "Convert Folder to Measured BRDF Library..."),
    (library.MEASUREDBRDF_OT_search_published, "Measured BRDF from the Starter Library..."),
    (library.MEASUREDBRDF_OT_add_starter_library, "Starter Library of Measured BRDFs to the Asset Browser"),
    (fit.MEASUREDBRDF_OT_fit, "Fit Measured BRDF Again"),
    (inspect_reflectance.MEASUREDBRDF_OT_inspect, "Inspect Reflectance of Measured BRDF"),
    (compare.MEASUREDBRDF_OT_pin, "Compare with This Measured BRDF"),
    (compare.MEASUREDBRDF_OT_render_look, "Test Render of Measured BRDF"),
    (large_view.MEASUREDBRDF_OT_large_view, "Large View of Measured BRDF..."),
    (mix.MEASUREDBRDF_OT_mix, "Mix Measured BRDFs..."),
    (update.MEASUREDBRDF_OT_update_materials, "Update Measured BRDFs"),
    (assets.MEASUREDBRDF_OT_save_asset, "Save Measured BRDF to Asset Library"),
    (rendering.MEASUREDBRDF_OT_enable_osl, "Enable OSL for Measured BRDFs"),
    (checks.MEASUREDBRDF_OT_check_scene, "Check Scene for Measured BRDFs"))


class MEASUREDBRDF_MT_menu(bpy.types.Menu):
    """Import, fit and compare measured materials"""

    bl_idname = "MEASUREDBRDF_MT_menu"
    bl_label = "Measured BRDF"

    def draw(self, _context: bpy.types.Context) -> None:
        for operator, text in _ENTRIES:
            self.layout.operator(operator.bl_idname, text=text)


def _entry(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.menu(MEASUREDBRDF_MT_menu.bl_idname, icon="MATERIAL")


_IN = ("VIEW3D_MT_object", "NODE_MT_node", "MATERIAL_MT_context_menu")


def register() -> None:
    bpy.utils.register_class(MEASUREDBRDF_MT_menu)
    for name in _IN:
        getattr(bpy.types, name).append(_entry)


def unregister() -> None:
    for name in _IN:
        getattr(bpy.types, name).remove(_entry)
    bpy.utils.unregister_class(MEASUREDBRDF_MT_menu)
