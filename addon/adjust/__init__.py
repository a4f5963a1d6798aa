"""Artists change the diffuse part and the highlight of a measured material, and coat it."""

from ..core import manual
from ..core.registration import Registration
from ..core.storage import edits
from ..panel import main
from . import flakes, operators, panel, settings

_TOPICS = (*manual.operator_topics("manual/adjusting#adjust-and-mix", "adjust"),
           *manual.operator_topics("manual/adjusting#texture-and-flakes", "add_flakes"),
           *manual.setting_topics("manual/adjusting#adjust-and-mix", "measuredadjustments", "*"))
_slice = Registration(settings, operators, flakes, panel, additions=(
    (manual.slice_topics, _TOPICS), (main.mix_part_rows, panel.draw_mix_part),
    (edits.edit_sources, settings.edit_arguments), (edits.sliders, settings.SLIDERS),
    (settings.listeners, operators.apply_soon)))
register, unregister = _slice.register, _slice.unregister
