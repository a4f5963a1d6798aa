"""Asset libraries: materials are saved to one, and folders of measurements converted to one.

Code that opens .blend files (`batch`, `core.libraries.library_file`) runs only in a Blender of its own.
"""

import bpy

from ..core import manual
from ..core.registration import Registration
from ..panel import main, menu
from ..work import command as commands
from . import command, operators

_ENTRIES = menu.entries((operators.MEASUREDBRDF_OT_convert_folder, "Convert Folder to Measured BRDF Library..."),
                        (operators.MEASUREDBRDF_OT_save_asset, "Save Measured BRDF to Asset Library"))
_IN_FILE_MENU = menu.entries((operators.MEASUREDBRDF_OT_convert_folder, "Measured BRDFs (folder to asset library)"))
_TOPICS = (*manual.operator_topics("manual#keep-and-reuse", "save_asset"),
           *manual.operator_topics("manual#a-folder-into-an-asset-library", "convert_folder"))


def _draw_save(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    layout.operator(operators.MEASUREDBRDF_OT_save_asset.bl_idname, text="Save...", icon="ASSET_MANAGER")


_slice = Registration(operators, additions=(
    (manual.slice_topics, _TOPICS), ("TOPBAR_MT_file_import", _IN_FILE_MENU), (menu.MEASUREDBRDF_MT_menu, _ENTRIES),
    (main.material_buttons, _draw_save), (commands.commands, command.add)))
register, unregister = _slice.register, _slice.unregister
