"""Artists change the diffuse part and the highlight of a measured material, and coat it."""

import bpy

from . import operators, panel, settings

_CLASSES = (*operators.classes, *panel.classes)


def register() -> None:
    settings.register()
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    operators.register()


def unregister() -> None:
    operators.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    settings.unregister()
