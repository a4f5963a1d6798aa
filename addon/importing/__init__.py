"""Files of measurements become materials, are fitted again, and told about."""

import bpy

from ..core import checks, manual
from ..core.registration import Registration
from ..panel import main, menu, nodes
from . import asking, details, fit, import_data, measurements, relink

_OF_FILES = ((relink.MEASUREDBRDF_OT_find_missing, "Find Missing Measurements..."),
             (relink.MEASUREDBRDF_OT_forget_paths, "Forget Paths of Measurements"))
_ENTRIES = menu.entries((import_data.MEASUREDBRDF_OT_import_data, "Import Measured BRDF..."),
                        (import_data.MEASUREDBRDF_OT_import_folder, "Import Folder of Measured BRDFs..."),
                        (fit.MEASUREDBRDF_OT_fit, "Fit Measured BRDF Again"),
                        *_OF_FILES)
_IN_FILE_MENU = menu.entries(
    (import_data.MEASUREDBRDF_OT_import_data, "Measured BRDF (MERL, RGL, CURET, table...)"),
    (import_data.MEASUREDBRDF_OT_import_folder, "Measured BRDFs (folder)"))
_IN_DATA_MENU = menu.entries(*_OF_FILES)
_IN_ADD_MENU = menu.entries((import_data.MEASUREDBRDF_OT_import_data, "Import..."))
_TOPICS = (*manual.operator_topics("manual#get-data-in", "import_data", "import_folder", "choose_sample",
                                 "name_columns"),
           *manual.operator_topics("manual#fit", "fit"),
           *manual.operator_topics("manual#choose-what-it-may-cost", "use_preset"),
           *manual.operator_topics("manual#keep-and-reuse", "find_file", "find_missing", "forget_paths"))


def _draw_import(layout: bpy.types.UILayout) -> None:
    layout.operator(import_data.MEASUREDBRDF_OT_import_data.bl_idname, text="Import...", icon="IMPORT")


_slice = Registration(
    import_data, asking, fit, relink, measurements, details,
    additions=(
        (manual.slice_topics, _TOPICS), ("TOPBAR_MT_file_import", _IN_FILE_MENU),
        ("TOPBAR_MT_file_external_data", _IN_DATA_MENU), (menu.MEASUREDBRDF_MT_menu, _ENTRIES),
        (nodes.MEASUREDBRDF_MT_add_node, _IN_ADD_MENU), (main.start_buttons, _draw_import),
        (main.unfitted_rows, measurements.draw_source), (checks.slice_checks, fit.check_colours)))
register, unregister = _slice.register, _slice.unregister
