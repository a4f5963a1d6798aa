"""The lobe of a material over the 3D view, with the light dragged; and its plane of incidence beside it."""

import bpy

from ..core import manual
from ..core.registration import Registration
from ..panel import main, menu
from . import operators, session

_ENTRY = menu.entries((operators.MEASUREDBRDF_OT_inspect, "Inspect Reflectance of Measured BRDF"))
_TOPICS = manual.operator_topics("manual#look-at-the-lobe", "inspect")


def _draw_button(layout: bpy.types.UILayout, _material: bpy.types.Material) -> None:
    """Draw the button of the main panel, which ends what it has begun."""
    running = session.running is not None
    row = layout.row(align=True)
    row.operator_context = "INVOKE_DEFAULT"
    row.operator(operators.MEASUREDBRDF_OT_inspect.bl_idname, icon="X" if running else "LIGHT_HEMI",
                 text="End Inspection" if running else "Inspect")


_slice = Registration(operators, session, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRY), (main.material_buttons, _draw_button)))
register, unregister = _slice.register, _slice.unregister
