"""A measured material beside another: pictures, curves and numbers, and renders of both."""

import bpy

from ..core import beside, manual
from ..panel import menu
from ..work import command as commands
from . import command, looks, operators, panel, settings

_CLASSES = (*operators.classes, *panel.classes)
_ENTRIES = menu.entries((operators.MEASUREDBRDF_OT_pin, "Compare with This Measured BRDF"),
                        (operators.MEASUREDBRDF_OT_render_look, "Test Render of Measured BRDF"))
_TOPICS = (*manual.over_operators("manual#compare", "pin", "render_look"),
           *manual.over_settings("manual#compare", "measuredcomparison", "*"),
           ("bpy.types.scene.measured_brdf_comparison*", "manual#compare"))


def register() -> None:
    manual.of_slices.append(_TOPICS)
    settings.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    menu.MEASUREDBRDF_MT_menu.append(_ENTRIES)
    beside.chosen_by.append(settings.pinned)
    commands.commands.append(command.add)


def unregister() -> None:
    commands.commands.remove(command.add)
    beside.chosen_by.remove(settings.pinned)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRIES)
    looks.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    settings.unregister()
    manual.of_slices.remove(_TOPICS)
