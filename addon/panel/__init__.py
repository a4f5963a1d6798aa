"""The panel of a measured material, and the menus: slices add to them. What every file needs is here: how materials are
rendered, what is wrong in a scene, and updates."""

import bpy

from ..work import modal
from . import fixes, local, main, menu, nodes, rendering, update

_MODULES = (modal, fixes, local, update, main, rendering, nodes, menu)
_WITH_HANDLERS = (modal, nodes, menu)


def register() -> None:
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    for registrable in _WITH_HANDLERS:
        registrable.register()


def unregister() -> None:
    for registrable in reversed(_WITH_HANDLERS):
        registrable.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
