"""The panels in the material tab, one file for each subject; `layout` has the drawing they share.

Drawing reads stored settings and finished answers only: it opens no file and fits nothing. Nothing but the package
itself imports it; it may import everything but `command`.
"""

import bpy

from . import adjust, compare_with, comparison, details, fit, inspect, library, measurements, menu, pictures, rendering

# in the order in which Blender shows them; the first two are the parents of the others
classes = (
    fit.MEASUREDBRDF_PT_begin, fit.MEASUREDBRDF_PT_material, adjust.MEASUREDBRDF_PT_adjust,
    pictures.MEASUREDBRDF_PT_pictures,
    comparison.MEASUREDBRDF_PT_compare, *compare_with.classes, rendering.MEASUREDBRDF_PT_rendering,
    details.MEASUREDBRDF_PT_settings, details.MEASUREDBRDF_PT_details, measurements.MEASUREDBRDF_PT_data,
    *library.classes, fit.MEASUREDBRDF_PT_sidebar, adjust.MEASUREDBRDF_PT_adjust_sidebar, *inspect.classes)


def register() -> None:
    for cls in classes:
        bpy.utils.register_class(cls)
    menu.register()


def unregister() -> None:
    menu.unregister()
    for cls in reversed(classes):
        bpy.utils.unregister_class(cls)
