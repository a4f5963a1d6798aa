"""Preferences: the preset of new materials, the folders of measurements and assets, and where to get data."""

from typing import NamedTuple, Protocol

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from . import manual
from .annotations import present
from .data_sources import SOURCES
from .materials.properties import PRESET_ITEMS

_PACKAGE = __package__.rpartition(".addon")[0]


class Preferences(Protocol):
    """The settings of `MeasuredPreferences`."""

    @property
    def preset(self) -> str: ...

    @property
    def data_folder(self) -> str: ...

    @property
    def asset_library(self) -> str: ...

    @property
    def offer_library(self) -> bool: ...


class _Defaults(NamedTuple):
    preset: str = "Standard"
    data_folder: str = ""
    asset_library: str = ""
    offer_library: bool = True


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
                                  description="Folder into which Save to Asset Library writes. Empty: materials become "
                                              "assets of the open file")
    offer_library: BoolProperty(name="Offer the Starter Library", default=_DEFAULTS.offer_library,
                                description="Open Start from... in the Material tab of files that have no measured "
                                            "material yet")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = present(self.layout)
        column = layout.column()
        column.use_property_split = True
        for name in ("preset", "data_folder", "asset_library", "offer_library"):
            column.prop(self, name)
        layout.operator("measured_brdf.add_starter_library", text="Add the Starter Library to the Asset Browser",
                        icon="ASSET_MANAGER")
        header, body = layout.panel("MEASUREDBRDF_sources", default_closed=True)
        header.label(text="Where to Get Data")
        if body is not None:
            for source in SOURCES:
                column = body.column(align=True)
                column.operator("wm.url_open", text=source.name, icon="URL").url = source.url
                for text in source.facts:
                    column.label(text=text)
        manual.draw_link(layout)


def get(context: bpy.types.Context) -> Preferences:
    """The preferences; the defaults if the add-on runs without being installed."""
    addon = context.preferences.addons.get(_PACKAGE)
    return addon.preferences if addon is not None and addon.preferences is not None else _DEFAULTS


def register() -> None:
    bpy.utils.register_class(MeasuredPreferences)


def unregister() -> None:
    bpy.utils.unregister_class(MeasuredPreferences)
