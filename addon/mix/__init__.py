"""Two measured materials are mixed into a new one, by a factor or by a mask."""

import bpy

from ..core import manual
from ..panel import main, menu, nodes
from . import mix_group, mixed, operators, panel

_CLASSES = (*operators.classes, *panel.classes)
_ENTRY = menu.entries((operators.MEASUREDBRDF_OT_mix, "Mix Measured BRDFs..."))
_TOPICS = manual.over_operators("manual/adjusting#mix-measured-materials", "mix")


def register() -> None:
    manual.of_slices.append(_TOPICS)
    mixed.register()
    mix_group.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    menu.MEASUREDBRDF_MT_menu.append(_ENTRY)
    nodes.MEASUREDBRDF_MT_add_node.append(_ENTRY)
    main.measured.append(panel.draw_button)


def unregister() -> None:
    main.measured.remove(panel.draw_button)
    nodes.MEASUREDBRDF_MT_add_node.remove(_ENTRY)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRY)
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    mix_group.unregister()
    mixed.unregister()
    manual.of_slices.remove(_TOPICS)
