"""The operators, one file for each subject, and the entries in the File > Import menu.

Operators are thin: they read their settings, call `library`, `materials` and `jobs`, and report. Of the layers, only
`ui` imports this package.
"""

import bpy

from ..annotations import Registrable
from ..jobs import modal
from . import (
    adjust,
    assets,
    checks,
    compare,
    fit,
    folders,
    import_data,
    large_view,
    library,
    local,
    mix,
    nodes,
    placeholders,
    presets,
    rendering,
    samples,
    update,
)

_MODULES = (modal, import_data, folders, fit, update, presets, samples, assets, rendering, checks, library,
            placeholders, local, compare, large_view, adjust, mix, nodes)
# these register more than classes
_WITH_HANDLERS: tuple[Registrable, ...] = (modal, import_data, folders, library, placeholders, large_view, adjust,
                                           nodes)


def register() -> None:
    for module in _MODULES:
        for cls in module.classes:
            bpy.utils.register_class(cls)
    for registrable in _WITH_HANDLERS:
        registrable.register()


def unregister() -> None:
    for registrable in reversed(_WITH_HANDLERS):
        registrable.unregister()
    for module in reversed(_MODULES):
        for cls in reversed(module.classes):
            bpy.utils.unregister_class(cls)
