"""What to begin with: published fits, the measurements of the data folder, and where to get more."""

from typing import Any

import bpy

from ...fitter.library.matching import match_lines
from ...fitter.model.published import PublishedMaterial
from ...fitter.model.translucent import TRANSLUCENT
from ..core import manual, preferences
from ..core.annotations import not_none
from ..core.storage.reading import scene_colours
from ..panel.layout import draw_warning, draw_wrapped, has_data, on_buttons, picture_button, room
from . import operators as library
from . import shelf, starter, thumbnails

_CELL_CHARACTERS = 16       # characters: the width of a cell with a thumbnail
_THUMBNAIL_SCALE = 4.5      # of thumbnails
_OTHER_FINISHES = 3         # pictures below one another beside one of a metal
_OF_FAVOURITES = 2.0        # scale of the pictures of favourites
_MOST = 60                  # cells
_CELLS_ABREAST, _SMALL_SCALE = 7, 3.2  # cells of the popover beside one another, and the scale of their thumbnails
_CELL_UNITS = 7             # units of Blender's interface: of a cell of the popover
_UNIT, _STAR = 20, 22       # pixels at a scale of 1: of a unit, and of a star with the gap before it
# rows of the popover at most; pixels at a scale of 1: of one, and around all
_MOST_ROWS_SHOWN, _ROW_PIXELS, _PIXELS_AROUND = 4, 95, 200
_LARGE_SCALE, _LARGE_ROW = 5.0, 135     # the same where all have room that are found: scale, and pixels of a row
_RGL = "https://rgl.epfl.ch/materials"       # measurements under CC0, with pictures; the browser opens it
_IMPORT = "measured_brdf.import_data"


class _BeginPanel:
    """A mix-in for panels in the material tab that are shown without a measured material, too."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_order = 70


class MEASUREDBRDF_PT_start(_BeginPanel, bpy.types.Panel):
    """Materials that come with the extension: metals by their optical constants, and published fits of materials of \
MERL"""

    bl_label = "Material Library"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not has_data(context)

    def draw(self, context: bpy.types.Context) -> None:
        _draw_published(not_none(self.layout), context, _columns())


class MEASUREDBRDF_PT_library(bpy.types.Panel):
    """Materials that come with the extension: metals by their optical constants, and published fits of materials of \
MERL"""

    bl_space_type = "PROPERTIES"
    bl_region_type = "HEADER"               # of no editor: a popover
    bl_label = "Material Library"
    bl_ui_units_x = _CELL_UNITS * _CELLS_ABREAST

    def draw(self, context: bpy.types.Context) -> None:
        _draw_published(not_none(self.layout), context, _CELLS_ABREAST, _SMALL_SCALE,
                        _CELLS_ABREAST * _rows(context, _ROW_PIXELS), _UNIT * _CELL_UNITS * _CELLS_ABREAST,
                        _CELLS_ABREAST * _rows(context, _LARGE_ROW))


def _rows(context: bpy.types.Context, height: int) -> int:
    """Rows of a height that fit into the popover above or below its button: one that has more opens at its end."""
    if context.window is None:
        return _MOST_ROWS_SHOWN
    scale = context.preferences.system.ui_scale or 1            # 0 without a screen
    room_for = (context.window.height / scale / 2 - _PIXELS_AROUND) / height
    return min(max(int(room_for), 1), _MOST_ROWS_SHOWN)


def draw_button(layout: bpy.types.UILayout) -> None:
    shelf.coming()
    layout.popover(MEASUREDBRDF_PT_library.__name__, text="Library", icon="ASSET_MANAGER")


class MEASUREDBRDF_PT_folder(_BeginPanel, bpy.types.Panel):
    """The measurements in the data folder of the preferences"""

    bl_label = "Data Folder"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return hasattr(bpy.types, "MEASUREDBRDF_PT_data")       # of the slice that imports; operators are no such types

    def draw(self, context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        _draw_folder(layout, context)
        row = layout.row(align=True)
        row.operator("wm.url_open", text="Get from RGL", icon="URL").url = _RGL
        row.operator("wm.url_open", text="Where to Get Data", icon="HELP").url = manual.url(manual.DATA_PAGE)


def _draw_published(layout: bpy.types.UILayout, context: bpy.types.Context, columns: int,
                    scale: float = _THUMBNAIL_SCALE, most: int = _MOST, width: int = 0, most_large: int = 0) -> None:
    choices = context.window_manager.measured_brdf_shelf
    row = layout.row(align=True)
    row.prop(choices, "search", text="", icon="VIEWZOOM")
    kind = row.row(align=True)
    kind.active = not choices.search        # which is in all kinds
    kind.prop(choices, "tag", text="")
    favourites = shelf.favourites()
    _draw_row(layout, [{"name": each.name} for each in favourites[:columns * 2]])
    layout.operator(library.MEASUREDBRDF_OT_match_photograph.bl_idname, text="Match a Photograph...", icon="IMAGE_DATA")
    _draw_row(layout, [{"name": each.material.name, "note": line, "diffuse": each.diffuse, "highlight": each.highlight}
                       for each, line in zip(shelf.nearest, match_lines("", shelf.nearest)[1:], strict=True)])
    offered = shelf.find_offered(choices.search, shelf.ALL if choices.search else choices.tag)
    groups = shelf.group_finishes(offered)
    if len(groups) <= most_large:
        scale = _LARGE_SCALE
    if not offered:
        draw_wrapped(layout, "No material has these words in its name or kind", "INFO")
    grid = _grid(layout, columns)
    for group in groups[:most]:
        row = grid.row(align=True)
        name = group[0].substance if len(group) > 1 else group[0].label
        _draw_finishes(row.column(align=True), group, on_buttons(name, columns, _STAR, width), scale)
        row.operator(library.MEASUREDBRDF_OT_favourite.bl_idname, text="", emboss=False,
                     icon="SOLO_ON" if group[0] in favourites else "SOLO_OFF").name = group[0].name
    _draw_rest(layout, len(groups) - most, "materials")
    if choices.tag in (TRANSLUCENT, shelf.ALL):
        layout.operator(library.MEASUREDBRDF_OT_translucent_material.bl_idname, text="Translucent...", icon="ADD")
    draw_wrapped(layout, "Metals: computed from measured optical constants; translucent materials: from measured "
                         "scattering and absorption. Others: published fits of MERL's materials (Low et al. 2012), not "
                         "measurements", "INFO")
    if not starter.is_offered(context):
        layout.operator(library.MEASUREDBRDF_OT_add_starter_library.bl_idname, icon="ASSET_MANAGER")


def _draw_folder(layout: bpy.types.UILayout, context: bpy.types.Context) -> None:
    settings = preferences.get(context)
    if isinstance(settings, bpy.types.AddonPreferences):
        layout.prop(settings, "data_folder", text="")
    if not settings.data_folder:
        draw_wrapped(layout, "Choose a folder: its measurements are listed here, with pictures", "INFO")
        return
    job = shelf.watch_folder(bpy.path.abspath(settings.data_folder))
    if job.error is not None:
        draw_warning(layout, str(job.error))
        return
    if job.result is None:
        layout.label(text="Looking for measurements", icon="TIME")
        return
    choices = context.window_manager.measured_brdf_shelf
    layout.prop(choices, "data_search", text="", icon="VIEWZOOM")
    words = choices.data_search.lower().split()
    wanted = [each for each in job.result if all(word in f"{each.label} {each.path}".lower() for word in words)]
    if not wanted:
        draw_wrapped(layout, "No measurements" + (" of that name" if words else " in this folder"), "INFO")
    grid, how = _grid(layout, _columns()), {"colours": scene_colours() or "Rec.709"}
    broken = [each for each in wanted if each.error]
    for each in [each for each in wanted if not each.error][:_MOST]:
        _draw_measurement(grid.column(align=True), each, how)
    _draw_rest(layout, len(wanted) - len(broken) - _MOST, "measurements")
    if broken:
        header, body = layout.panel("MEASUREDBRDF_unreadable", default_closed=True)
        header.label(text=f"{len(broken)} files cannot be read" if len(broken) > 1 else "One file cannot be read")
        for each in broken[:_MOST] if body is not None else ():
            draw_wrapped(body, each.error, "DOT")


def _draw_measurement(cell: bpy.types.UILayout, measurement: thumbnails.FolderEntry, how: dict[str, str]) -> None:
    icon, error = shelf.measurement_icon(measurement, how) if measurement.has_picture else (0, None)
    meanwhile = "ERROR" if error is not None else "FILE" if not measurement.has_picture else "TIME"
    for button in (picture_button(cell, _IMPORT, icon or _icon(meanwhile), _THUMBNAIL_SCALE),
                   *(cell.operator(_IMPORT, text=line) for line in on_buttons(measurement.label, _columns()))):
        button.filepath, button.sample = measurement.path, measurement.sample


def _draw_finishes(cell: bpy.types.UILayout, group: list[PublishedMaterial], lines: tuple[str, ...], scale: float,
                   ) -> None:
    """Draw the picture and the name of a material, and beside it the pictures of a metal's other finishes."""
    first, *others = group
    use, row = library.MEASUREDBRDF_OT_use_published.bl_idname, cell.row(align=True)
    buttons = [(first, picture_button(row.column(), use, shelf.published_icon(first.name), scale))]
    column = row.column(align=True) if others else row
    buttons += [(each, picture_button(column, use, shelf.published_icon(each.name), scale / _OTHER_FINISHES))
                for each in others]
    buttons += [(first, cell.operator(use, text=line)) for line in lines]
    for each, button in buttons:
        button.name = each.name


def _draw_row(layout: bpy.types.UILayout, materials: list[dict[str, Any]]) -> None:
    """Draw small pictures of materials, which are buttons with these properties."""
    if materials:
        row = layout.row(align=True)
        row.alignment = "LEFT"
    for properties in materials:
        button = picture_button(row.column(), library.MEASUREDBRDF_OT_use_published.bl_idname,
                                shelf.published_icon(properties["name"]), _OF_FAVOURITES)
        for name, value in properties.items():
            setattr(button, name, value)


def _icon(name: str) -> int:
    return bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items[name].value


def _draw_rest(layout: bpy.types.UILayout, count: int, what: str) -> None:
    if count > 0:
        layout.label(text=f"{count} more {what}: search by name")


def _grid(layout: bpy.types.UILayout, columns: int) -> bpy.types.UILayout:
    return layout.grid_flow(row_major=True, columns=columns, even_columns=True, align=False)


def _columns() -> int:
    return max(room() // _CELL_CHARACTERS, 2)


classes = (MEASUREDBRDF_PT_start, MEASUREDBRDF_PT_library, MEASUREDBRDF_PT_folder)
