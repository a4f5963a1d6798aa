"""The Blender side of the extension: everything that imports bpy. `fitter`, which never does, holds the domain code.

The layers, from low to high: `scene`, `materials`, `jobs`, `library`, `operators`, `viewport`, `ui`,
`command`. A module imports its own layer and lower ones. `annotations`, `data_sources`, `versions`, `manual` and
`transaction` are below all layers; `preferences` is above `materials`.
"""

from . import command, manual, operators, preferences, ui, viewport
from .annotations import Registrable
from .jobs import icons, process, queue
from .materials import comparison, mix_group, properties, rendered
from .scene import lamps

_MODULES: tuple[Registrable, ...] = (properties, comparison, preferences, icons, operators, viewport, ui, lamps,
                                      rendered, mix_group, manual, command)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    queue.unregister()
    process.unregister()
    for module in reversed(_MODULES):
        module.unregister()
