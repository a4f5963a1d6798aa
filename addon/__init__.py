"""The Blender side: everything that imports bpy. Domain code is in `fitter`, which never does."""

from . import command, manual, operators, preferences
from .jobs import icons, process, queue
from .materials import properties
from .scene import lamps
from .ui import panels

_MODULES = (properties, preferences, icons, operators, panels, lamps, manual, command)


def register():
    for module in _MODULES:
        module.register()


def unregister():
    queue.unregister()
    process.unregister()
    for module in reversed(_MODULES):
        module.unregister()
