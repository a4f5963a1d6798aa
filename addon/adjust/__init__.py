"""Artists change the diffuse part and the highlight of a measured material, and coat it."""

from ..core import manual
from ..core.registration import Registration
from . import operators, panel, settings

_TOPICS = (*manual.over_operators("manual/adjusting#adjust-and-mix", "adjust"),
           *manual.over_settings("manual/adjusting#adjust-and-mix", "measuredadjustments", "*"))
_slice = Registration(settings, operators, panel, additions=((manual.of_slices, _TOPICS),))
register, unregister = _slice.register, _slice.unregister
