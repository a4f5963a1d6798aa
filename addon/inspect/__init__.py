"""The lobe of a material over the 3D view, with the light dragged; and its plane of incidence beside it."""

import bpy

from ..core import manual
from ..panel import main, menu
from . import operators, panel, session

_CLASSES = (*operators.classes, *panel.classes)
_ENTRY = menu.entries((operators.MEASUREDBRDF_OT_inspect, "Inspect Reflectance of Measured BRDF"))
_TOPICS = manual.over_operators("manual#look-at-the-lobe", "inspect")


def register() -> None:
    manual.of_slices.append(_TOPICS)
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    session.register()
    menu.MEASUREDBRDF_MT_menu.append(_ENTRY)
    main.measured.append(panel.draw)


def unregister() -> None:
    main.measured.remove(panel.draw)
    menu.MEASUREDBRDF_MT_menu.remove(_ENTRY)
    session.unregister()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
    manual.of_slices.remove(_TOPICS)
