"""What to begin with: published fits, the measurements of a folder, and where to get more."""

from ..core import manual
from ..core.registration import Registration
from ..panel import main, menu
from ..work import command, icons
from . import compiling, operators, panel, shelf, starter

_ENTRY = menu.entries(
    (operators.MEASUREDBRDF_OT_translucent_material, "Translucent Measured BRDF"),
    (operators.MEASUREDBRDF_OT_add_starter_library, "Starter Library of Measured BRDFs to the Asset Browser"))
_TOPICS = (*manual.operator_topics("manual#start-from-the-library", "use_published", "favourite",
                                  "translucent_material",
                                  "add_starter_library", "match_photograph"),
           *manual.setting_topics("manual#your-data-folder", "measuredshelf", "data_search"),
           *manual.setting_topics("manual#start-from-the-library", "measuredshelf", "*"))
_slice = Registration(shelf, operators, panel, compiling, additions=(
    (manual.slice_topics, _TOPICS), (menu.MEASUREDBRDF_MT_menu, _ENTRY), (command.commands, starter.add_command),
    (main.start_buttons, panel.draw_button), (icons.sample_icons, shelf.sample_icon)))
register, unregister = _slice.register, _slice.unregister
