"""The Blender side: everything that imports bpy. Domain code is in `fitter`, which never does."""

from . import checks, lamps, operators, panels, properties

_MODULES = (properties, operators, panels, checks, lamps)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    for module in reversed(_MODULES):
        module.unregister()
