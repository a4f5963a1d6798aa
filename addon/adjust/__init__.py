"""Artists change the diffuse part and the highlight of a measured material, and coat it."""

import bpy

from ..core import manual
from . import operators, panel, settings

_CLASSES = (*operators.classes, *panel.classes)
_TOPICS = (*manual.over_operators("manual/adjusting#adjust-and-mix", "adjust"),
           *manual.over_settings("manual/adjusting#adjust-and-mix", "measuredadjustments", "*"))


def register() -> None:
    manual.of_slices.append(_TOPICS)
    settings.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    operators.register()


def unregister() -> None:
    operators.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    settings.unregister()
    manual.of_slices.remove(_TOPICS)
