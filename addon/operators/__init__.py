"""What a user can do, a file for each subject."""

import bpy

from ..jobs import modal
from . import assets, checks, fit, folders, import_data, osl, samples

_MODULES = (modal, import_data, folders, fit, samples, assets, osl, checks)
_REGISTERED = (modal, import_data, folders)        # beside their classes


def register():
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    for module in _REGISTERED:
        module.register()


def unregister():
    for module in reversed(_REGISTERED):
        module.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
