"""What to begin with: published fits of 100 materials, the measurements of a folder, and where to get more."""

import bpy

from ..core import preferences
from ..panel import menu
from ..work import command as commands
from . import command, operators, panel, placeholders

_CLASSES = (*operators.classes, *panel.classes)
_ENTRIES = menu.entries(
    (operators.MEASUREDBRDF_OT_search_published, "Measured BRDF from the Starter Library..."),
    (operators.MEASUREDBRDF_OT_add_starter_library, "Starter Library of Measured BRDFs to the Asset Browser"))


def register() -> None:
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    operators.register()
    placeholders.register()
    menu.MEASUREDBRDF_MT_menu.append(_ENTRIES)
    commands.commands.append(command.add)
    preferences.sections.append(panel.draw_preferences)


def unregister() -> None:
    preferences.sections.remove(panel.draw_preferences)
    commands.commands.remove(command.add)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRIES)
    placeholders.unregister()
    operators.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
