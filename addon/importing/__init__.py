"""Files of measurements become materials, are fitted again, and told about."""

import bpy

from ..core import checks, manual
from ..panel import main, menu, nodes
from . import colours, compared_presets, curves, details, fit, folders, import_data, measurements, presets, samples

_MODULES = (import_data, samples, folders, fit, presets, curves, measurements, compared_presets, details)
_ENTRIES = menu.entries((import_data.MEASUREDBRDF_OT_browse, "Import Measured BRDF..."),
                        (folders.MEASUREDBRDF_OT_import_folder, "Import Folder of Measured BRDFs..."),
                        (fit.MEASUREDBRDF_OT_fit, "Fit Measured BRDF Again"))
_TOPICS = (*manual.over_operators("manual#get-data-in", "browse", "import_data", "import_folder", "choose_sample"),
           *manual.over_operators("formats#if-the-file-does-not-say", "say_units"),
           *manual.over_operators("manual#fit", "fit"),
           *manual.over_operators("manual#choose-what-it-may-cost", "use_preset"),
           *manual.over_operators("manual#keep-and-reuse", "find_file"))


def _draw_import(layout: bpy.types.UILayout) -> None:
    layout.operator(import_data.MEASUREDBRDF_OT_import_data.bl_idname, text="Import File...", icon="IMPORT")


def _in_file_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(import_data.MEASUREDBRDF_OT_browse.bl_idname,
                         text="Measured BRDF (MERL, RGL, CURET, table...)")
    menu.layout.operator(folders.MEASUREDBRDF_OT_import_folder.bl_idname, text="Measured BRDFs (folder)")


def _in_add_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(import_data.MEASUREDBRDF_OT_browse.bl_idname, text="Import...", icon="IMPORT")


def register() -> None:
    manual.of_slices.append(_TOPICS)
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_in_file_menu)
    menu.MEASUREDBRDF_MT_menu.append(_ENTRIES)
    nodes.MEASUREDBRDF_MT_add_node.append(_in_add_menu)
    main.beginnings.append(_draw_import)
    main.unfitted.append(measurements.draw_source)
    checks.others.append(colours.check)


def unregister() -> None:
    checks.others.remove(colours.check)
    main.unfitted.remove(measurements.draw_source)
    main.beginnings.remove(_draw_import)
    nodes.MEASUREDBRDF_MT_add_node.remove(_in_add_menu)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRIES)
    bpy.types.TOPBAR_MT_file_import.remove(_in_file_menu)
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
    manual.of_slices.remove(_TOPICS)
