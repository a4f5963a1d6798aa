"""What a user can do, a file for each subject."""

import bpy

from . import assets, fit, folders, import_data, in_background, osl, samples

_MODULES = (in_background, import_data, folders, fit, samples, assets, osl)
_REGISTERED = (in_background, import_data, folders)        # beside their classes


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
