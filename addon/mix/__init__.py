"""Two measured materials are mixed into a new one, by a factor or by a mask."""

from ..core import manual
from ..core.registration import Registration
from ..panel import main, menu, nodes
from . import mix_group, mixed, operators, panel

_ENTRY = menu.entries((operators.MEASUREDBRDF_OT_mix, "Mix Measured BRDFs..."))
_TOPICS = manual.operator_topics("manual/adjusting#mix-measured-materials", "mix")
_slice = Registration(mixed, mix_group, operators, panel, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRY), (nodes.MEASUREDBRDF_MT_add_node, _ENTRY),
    (main.material_buttons, panel.draw_button)))
register, unregister = _slice.register, _slice.unregister
