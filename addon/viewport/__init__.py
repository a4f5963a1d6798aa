"""The lobe of a material over the 3D view, with the light dragged; and its plane of incidence beside it."""

import bpy

from . import inspect_reflectance, session


def register() -> None:
    for cls in inspect_reflectance.classes:
        bpy.utils.register_class(cls)
    session.register()


def unregister() -> None:
    session.unregister()
    for cls in reversed(inspect_reflectance.classes):
        bpy.utils.unregister_class(cls)
