"""Measured materials become images for games and other programs."""

import bpy

from ..core import manual
from ..core.registration import Registration
from ..panel import menu, rendering
from . import operators

_ENTRIES = menu.entries((operators.MEASUREDBRDF_OT_bake_pbr, "Bake Measured Material..."))
_TOPICS = manual.operator_topics("manual/engines#bake-for-other-programs", "bake_pbr")


def _draw_bake(layout: bpy.types.UILayout) -> None:
    layout.operator_context = "INVOKE_DEFAULT"
    layout.operator(operators.MEASUREDBRDF_OT_bake_pbr.bl_idname, icon="RENDER_RESULT")


_slice = Registration(operators, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRIES), (rendering.export_buttons, _draw_bake)))
register, unregister = _slice.register, _slice.unregister
