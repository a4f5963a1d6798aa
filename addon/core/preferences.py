"""Preferences: the preset of new materials, and the folders of measurements and assets."""

from typing import Any, NamedTuple

import bpy
from bpy.props import EnumProperty, StringProperty

from . import manual
from .annotations import not_none
from .storage.properties import PRESET_ITEMS, draw_presets

_PACKAGE = __package__.rpartition(".addon")[0]


class _Defaults(NamedTuple):
    """Nothing can be stored in them, as who stores a preference learns."""

    preset: str = "Standard"
    data_folder: str = ""
    asset_library: str = ""
    favourites: str = ""


_DEFAULTS = _Defaults()


class MeasuredPreferences(bpy.types.AddonPreferences):
    """Shown in Blender's preferences, below the extension."""

    bl_idname = _PACKAGE

    preset: EnumProperty(name="Default Preset", items=PRESET_ITEMS, default=_DEFAULTS.preset,
                         description="Preset for files that are dropped or imported")
    data_folder: StringProperty(name="Data Folder", subtype="DIR_PATH",
                                description="Folder of measurements. The panel lists them with pictures, and notices "
                                            "new ones; the file browser opens there to import")
    asset_library: StringProperty(name="Asset Library", subtype="DIR_PATH",
                                  description="Folder that Save to Asset Library offers first, and into which folders "
                                              "of measurements are converted. Scripts save into it without a question; "
                                              "if it is empty, they make materials assets of the open file")

    favourites: StringProperty(options={"HIDDEN"}, description="Names of favourite materials of the library, with "
                                                               "commas between them")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        column = layout.column()
        column.use_property_split = True
        draw_presets(column, self)
        for name in ("data_folder", "asset_library"):
            column.prop(self, name)
        layout.operator("wm.url_open", text="Manual", icon="HELP").url = manual.url()


def get(context: bpy.types.Context) -> Any:
    """The `MeasuredPreferences`; the defaults if the add-on runs without being installed."""
    addon = context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon is not None and addon.preferences is not None else _DEFAULTS


classes = (MeasuredPreferences,)
