"""The Blender side: everything that imports bpy. Domain code is in `fitter`, which never does."""

from . import command, manual, operators, preferences
from .jobs import icons, queue
from .materials import checks, properties
from .scene import lamps
from .ui import panels

_MODULES = (properties, preferences, icons, operators, panels, checks, lamps, manual, command)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    queue.unregister()
    for module in reversed(_MODULES):
        module.unregister()
