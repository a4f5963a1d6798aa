"""Opens the manual, which is part of the extension: from a button, and with F1 over a control."""

from pathlib import Path

import bpy

PATH = Path(__file__).parents[1] / "docs" / "manual.md"


def draw_link(layout: bpy.types.UILayout) -> None:
    """Draw a button that opens the manual."""
    layout.operator("wm.url_open", text="Manual", icon="HELP").url = PATH.as_uri()


def manual_map() -> tuple[str, tuple[tuple[str, str], ...]]:
    """What F1 opens over operators and settings of the add-on, as `bpy.utils.register_manual_map` takes it."""
    names = ("bpy.ops.measured_brdf.*", "bpy.types.measured*", "bpy.types.material.measured_brdf*")
    return PATH.parent.as_uri() + "/", tuple((name, PATH.name) for name in names)


def register() -> None:
    bpy.utils.register_manual_map(manual_map)


def unregister() -> None:
    bpy.utils.unregister_manual_map(manual_map)
