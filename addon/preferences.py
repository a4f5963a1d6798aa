"""Preferences: what new materials begin with, and where data and assets lie."""

from types import SimpleNamespace

import bpy
from bpy.props import EnumProperty, StringProperty

from . import manual
from .materials.properties import PRESET_ITEMS

_PACKAGE = __package__.rpartition(".addon")[0]
_DEFAULTS = SimpleNamespace(preset="Standard", data_folder="", asset_library="")


class MeasuredPreferences(bpy.types.AddonPreferences):
    """Shown in Blender's preferences, below the extension."""

    bl_idname = _PACKAGE

    preset: EnumProperty(name="Default Preset", items=PRESET_ITEMS, default=_DEFAULTS.preset,
                         description="What files are fitted with when they are dropped or imported")
    data_folder: StringProperty(name="Data Folder", subtype="DIR_PATH",
                                description="Where the file browser opens to import measurements")
    asset_library: StringProperty(name="Asset Library", subtype="DIR_PATH",
                                  description="Where Save to Asset Library writes. Empty: materials are marked as "
                                              "assets of the open file")

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("preset", "data_folder", "asset_library"):
            layout.prop(self, name)
        manual.draw_link(layout)


def get(context):
    """The preferences, or the defaults where the add-on runs without being installed."""
    addon = context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon is not None and addon.preferences is not None else _DEFAULTS


def register():
    bpy.utils.register_class(MeasuredPreferences)


def unregister():
    bpy.utils.unregister_class(MeasuredPreferences)
