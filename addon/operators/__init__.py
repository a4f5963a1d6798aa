"""What a user can do, a file for each subject."""

import bpy

from . import assets, fit, folders, import_data, in_background, osl, samples

_MODULES = (in_background, import_data, folders, fit, samples, assets, osl)
_WITH_MENUS = (import_data, folders)


def register():
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    for module in _WITH_MENUS:
        module.register()


def unregister():
    for module in reversed(_WITH_MENUS):
        module.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
