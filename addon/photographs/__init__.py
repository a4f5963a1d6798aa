"""Photographs of a painted ball become its material, in a scene that stands for the dark room; those of a flat sample a
mix of several."""

from ..core import manual
from ..core.registration import Registration
from ..core.storage import paths
from ..panel import menu
from ..work import command
from . import comparison, flat, operators, panel, settings
from .operators import MEASUREDBRDF_OT_measure_photographs, MEASUREDBRDF_OT_measure_sample_photographs

_ENTRY = menu.entries((MEASUREDBRDF_OT_measure_photographs, "Measure Photographs of a Ball..."),
                      (MEASUREDBRDF_OT_measure_sample_photographs, "Measure Photographs of a Flat Sample..."))
_IN_FILE_MENU = menu.entries((MEASUREDBRDF_OT_measure_photographs, "Photographs of a Ball (measured BRDF)"),
                             (MEASUREDBRDF_OT_measure_sample_photographs,
                              "Photographs of a Flat Sample (measured BRDF)"))
_PAGE = "manual/measure-your-own"
_TOPICS = (*manual.operator_topics(f"{_PAGE}#in-blender", "measure_photographs", "fit_outline", "place_lamp",
                                  "measure_ball", "compare_photograph"),
           *manual.operator_topics(f"{_PAGE}#a-flat-sample-in-blender", "measure_sample", "measure_sample_photographs"),
           *manual.setting_topics(f"{_PAGE}#in-blender", "measuredphotographs", "*"))


_slice = Registration(settings, operators, flat, panel, additions=(
    (manual.slice_topics, _TOPICS), ("TOPBAR_MT_file_import", _IN_FILE_MENU), (menu.MEASUREDBRDF_MT_menu, _ENTRY),
    (paths.scene_places, settings.places),
    (command.commands, command.answering("photograph", comparison.answer))))
register, unregister = _slice.register, _slice.unregister
