"""Presets side by side, as spheres with their numbers."""

from typing import Any, Literal

import bpy

from ...fitter import PRESETS, Fit
from ...fitter.model import Reflectance
from ..core.annotations import Arguments, not_none
from ..core.storage.outcomes import Data, FitRequest
from ..core.storage.properties import OFFERED, ORIGINAL, PRESET_ITEMS, name_of_fit
from ..panel import costs
from ..panel.layout import MaterialPanel, draw_picture, is_narrow, picture_button, picture_scale, wrap_text
from ..work import queries
from ..work.job import Job

_FIT = "measured_brdf.fit"  # of another slice
_CHEAPEST_FIRST = ORIGINAL, *OFFERED
_FORMS = "{} coefficients", "{} KB of the fit", "RMSE {}", "Unseen Angles {}"
_LABELS = {key: label for key, label, _ in PRESET_ITEMS}
_ABREAST = 3 * (max(map(len, _LABELS.values())) + 2)      # characters that three spheres with their names need


_PresetRow = tuple[int, Job[Any], tuple[str, ...], bool]
"""What is shown of a preset: picture, its job, numbers as text, and whether the material has this fit."""


class MEASUREDBRDF_PT_compare(MaterialPanel, bpy.types.Panel):
    """A sphere of each preset, with its size and its errors; worked out while this panel is open"""

    bl_label = "Compare Presets"
    bl_parent_id = "MEASUREDBRDF_PT_pictures"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), not_none(context.material)
        data = queries.data(material).result
        if data is None:
            return
        # questions are answered in the order in which they are asked
        kept = queries.fit_job(material)
        shown = {name: _describe_preset(material, data, kept, name) for name in _CHEAPEST_FIRST}
        columns = 1 if is_narrow(_ABREAST) else 3
        grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True)
        can_choose = (material.is_editable and material.override_library is None
                      and hasattr(bpy.types, "MEASURED_BRDF_OT_fit"))
        for name in (*OFFERED, ORIGINAL):
            _draw_preset(grid, name, shown[name], picture_scale(context, columns), can_choose)
        for line in wrap_text("RMSE at the samples, and Error at Unseen Angles, 1/sr"):
            layout.label(text=line)


def _describe_preset(material: bpy.types.Material, data: Data, kept: Job[Reflectance] | None, name: str) -> _PresetRow:
    """What is shown of a preset; `kept` reads the fit that the material has, which is not made again."""
    if kept is not None and kept.finished is None:
        return 0, kept, costs.UNKNOWN_ROW, False
    arguments: Arguments = {**PRESETS[name]}
    settings = material.measured_brdf
    is_chosen = kept is not None and data.digest == settings.digest and name_of_fit(settings) == name
    if is_chosen and kept is not None and isinstance(kept.result, Fit) and kept.result.edit is None:
        numbers = costs.texts(settings.coefficients, settings.bytes, settings.rmse)
        return *queries.material_sphere(material), (*numbers, costs.held_out(queries.held_out(data, arguments))), True
    wanted = FitRequest(data, arguments)
    return *queries.lit_sphere(wanted.digest, wanted), costs.numbers(*queries.cost(data, arguments)), is_chosen


def _draw_preset(layout: bpy.types.UILayout, name: str, row: _PresetRow, scale: float, can_choose: bool) -> None:
    (picture, job, numbers, is_chosen), column = row, layout.column(align=True)
    column.enabled = name != ORIGINAL or numbers != costs.UNKNOWN_ROW       # its error is known before it can be chosen
    icon: Literal["CHECKMARK", "NONE"] = "CHECKMARK" if is_chosen else "NONE"
    if can_choose and picture:
        picture_button(column, _FIT, picture, scale).preset = name
    else:
        draw_picture(column, picture, job, scale)
    if can_choose:
        column.operator(_FIT, text=_LABELS[name], depress=is_chosen, icon=icon).preset = name
    else:
        column.label(text=_LABELS[name], icon=icon)
    for form, text in zip(_FORMS, numbers, strict=True):
        column.label(text="" if text in (*costs.UNKNOWN_ROW, *costs.FAILED_ROW) else form.format(text))


classes = (MEASUREDBRDF_PT_compare,)
