"""The Blender side: everything that imports bpy. Domain code is in `fitter`, which never does."""

from . import (
    background,
    checks,
    command,
    lamps,
    manual,
    operators,
    panels,
    preferences,
    previews,
    properties,
)

_MODULES = (properties, preferences, previews, operators, panels, checks, lamps, manual, command)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    background.unregister()
    for module in reversed(_MODULES):
        module.unregister()
