"""The Blender side of the extension: everything that imports bpy. `fitter`, which never does, holds the domain code.

`core` is what a measured material is, `work` the processes that fit, `panel` the panel and menus to which the slices
add. A slice is what users do: it imports these three and no other slice, and everything else works without it.
"""

from . import adjust, baking, compare, importing, inspect, library, mix, panel, photographs, starter
from .core import lamps, manual, preferences
from .core.registration import Registration
from .core.shading import comparison, export_follow, rendered
from .core.storage import paths, properties
from .work import command, icons, process, queue

_CORE = Registration(properties, preferences, icons, lamps, export_follow, rendered, comparison, paths, manual, command,
                     panel)
_SLICES = (adjust, mix, importing, compare, inspect, baking, library, photographs, starter)


def register() -> None:
    for part in (_CORE, *_SLICES):
        part.register()


def unregister() -> None:
    queue.unregister()
    process.unregister()
    for part in (*reversed(_SLICES), _CORE):
        part.unregister()
