"""What to begin with: published fits of 100 materials, the measurements of a folder, and where to get more."""

import bpy

from ..core import manual, preferences
from ..panel import menu
from ..work import command as commands
from . import command, operators, panel, placeholders

_CLASSES = (*operators.classes, *panel.classes)
_ENTRIES = menu.entries(
    (operators.MEASUREDBRDF_OT_search_published, "Measured BRDF from the Starter Library..."),
    (operators.MEASUREDBRDF_OT_add_starter_library, "Starter Library of Measured BRDFs to the Asset Browser"))
_TOPICS = (*manual.over_operators("manual#start-from-the-library", "use_published", "search_published",
                                  "add_starter_library"),
           *manual.over_settings("manual#your-data-folder", "measuredshelf", "data_search"),
           *manual.over_settings("manual#start-from-the-library", "measuredshelf", "*"))


def register() -> None:
    manual.of_slices.append(_TOPICS)
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
    manual.of_slices.remove(_TOPICS)
