"""What a user can do, a file for each subject."""

import bpy

from . import assets, convert, fit, import_data, in_background, osl, samples

_MODULES = (in_background, import_data, fit, samples, assets, convert, osl)


def register():
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    import_data.register()


def unregister():
    import_data.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
