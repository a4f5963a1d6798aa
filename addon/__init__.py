"""The Blender side: everything that imports bpy. Domain code is in `fitter`, which never does."""

from . import lamps, operators, panels, properties

_MODULES = (properties, operators, panels, lamps)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
