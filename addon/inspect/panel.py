"""The button that opens the lobe over the 3D view."""

import bpy

from . import session
from .operators import MEASUREDBRDF_OT_inspect


def draw_button(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    """Draw the button of the main panel, which ends what it has begun."""
    running = session.running is not None
    row = layout.row(align=True)
    row.operator_context = "INVOKE_DEFAULT"
    row.operator(MEASUREDBRDF_OT_inspect.bl_idname, icon="X" if running else "LIGHT_HEMI",
                 text="End Inspection" if running else "Inspect")
