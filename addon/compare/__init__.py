"""A measured material beside another: pictures, curves and numbers, and renders of both."""

from ..core import manual
from ..core.registration import Registration
from ..core.shading import look
from ..panel import menu
from ..work import command
from . import curves, operators, presets

_ENTRIES = menu.entries((operators.MEASUREDBRDF_OT_pin, "Compare with This Measured BRDF"),
                        (operators.MEASUREDBRDF_OT_render_look, "Test Render of Measured BRDF"))
_TOPICS = (*manual.operator_topics("manual#compare", "pin", "render_look"),
           *manual.setting_topics("manual#compare", "measuredcomparison", "*"),
           ("bpy.types.scene.measured_brdf_comparison*", "manual#compare"))
_slice = Registration(operators, curves, presets, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRIES),
    (command.commands, command.answering("look", look.answer))))
register, unregister = _slice.register, _slice.unregister
