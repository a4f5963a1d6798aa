"""The lobe of a material over the 3D view, with the light dragged; and its plane of incidence beside it."""

from ..core import manual
from ..core.registration import Registration
from ..panel import main, menu
from . import operators, panel, session

_ENTRY = menu.entries((operators.MEASUREDBRDF_OT_inspect, "Inspect Reflectance of Measured BRDF"))
_TOPICS = manual.over_operators("manual#look-at-the-lobe", "inspect")
_slice = Registration(operators, session, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRY), (main.material_buttons, panel.draw_button)))
register, unregister = _slice.register, _slice.unregister
