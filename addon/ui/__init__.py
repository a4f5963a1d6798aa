"""The panels in the material tab, one file for each subject; `layout` has the drawing they share.

Drawing reads stored settings and finished answers only: it opens no file and fits nothing. Nothing but the package
itself imports it; it may import everything but `command`.
"""

import bpy

from . import comparison, fit, library, measurements, pictures, rendering

# in the order in which Blender shows them; the first is the parent of the others
classes = (fit.MEASUREDBRDF_PT_material, pictures.MEASUREDBRDF_PT_pictures, comparison.MEASUREDBRDF_PT_compare,
           measurements.MEASUREDBRDF_PT_data, rendering.MEASUREDBRDF_PT_rendering, *library.classes)


def register() -> None:
    for cls in classes:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(classes):
        bpy.utils.unregister_class(cls)
