"""The manual, which comes with the extension: opened by a button, and by F1 over a control."""

from pathlib import Path

import bpy

PATH = Path(__file__).parents[1] / "docs" / "manual.md"


def draw_link(layout):
    """A button that opens the manual."""
    layout.operator("wm.url_open", text="Manual", icon="HELP").url = PATH.as_uri()


def manual_map():
    """For `bpy.utils.register_manual_map`: what F1 opens over operators and settings of the add-on."""
    names = ("bpy.ops.measured_brdf.*", "bpy.types.measured*", "bpy.types.material.measured_brdf*")
    return PATH.parent.as_uri() + "/", tuple((name, PATH.name) for name in names)


def register():
    bpy.utils.register_manual_map(manual_map)


def unregister():
    bpy.utils.unregister_manual_map(manual_map)
