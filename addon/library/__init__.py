"""Asset libraries: materials are saved to one, and folders of measurements converted to one.

Code that opens .blend files (`batch`, `core.library_file`) runs only in a Blender of its own.
"""

import bpy

from ..core import manual
from ..panel import main, menu
from ..work import command as commands
from . import command, folders, operators

_CLASSES = (*operators.classes, *folders.classes)
_ENTRIES = menu.entries((folders.MEASUREDBRDF_OT_convert_folder, "Convert Folder to Measured BRDF Library..."),
                        (operators.MEASUREDBRDF_OT_save_asset, "Save Measured BRDF to Asset Library"))
_TOPICS = (*manual.over_operators("manual#keep-and-reuse", "save_asset"),
           *manual.over_operators("manual#a-folder-into-an-asset-library", "convert_folder"))


def _draw_save(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    layout.operator(operators.MEASUREDBRDF_OT_save_asset.bl_idname, icon="ASSET_MANAGER")


def _in_file_menu(menu: bpy.types.Menu, _context: bpy.types.Context) -> None:
    menu.layout.operator(folders.MEASUREDBRDF_OT_convert_folder.bl_idname,
                         text="Measured BRDFs (folder to asset library)")


def register() -> None:
    manual.of_slices.append(_TOPICS)
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_in_file_menu)
    menu.MEASUREDBRDF_MT_menu.append(_ENTRIES)
    main.measured.append(_draw_save)
    commands.commands.append(command.add)


def unregister() -> None:
    commands.commands.remove(command.add)
    main.measured.remove(_draw_save)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRIES)
    bpy.types.TOPBAR_MT_file_import.remove(_in_file_menu)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    manual.of_slices.remove(_TOPICS)
