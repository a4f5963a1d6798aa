"""What fits cost: the one with the present settings, and the one of each preset."""

from typing import Any

import bpy

from ...fitter import PRESETS
from ..annotations import Arguments, present
from ..jobs import queries, tasks
from ..jobs.process import Job
from ..materials.properties import fit_arguments
from .layout import MaterialPanel, draw_row, draw_warning

_HEADINGS = "Coefficients", "KB", "RMSE", "Held out"


class MEASUREDBRDF_PT_compare(MaterialPanel, bpy.types.Panel):
    """Size and error of each preset for these measurements; calculated while this panel is open"""

    bl_label = "Compare Presets"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        data = queries.data(present(context.material)).result
        if data is None:
            return
        table = layout.column(align=True)
        draw_row(table, "Preset", *_HEADINGS)
        for name, preset in PRESETS.items():
            arguments: Arguments = {**preset}
            draw_row(table, name, *_numbers(*queries.cost(data, arguments)))
        layout.label(text="RMSE at the samples, and at held-out samples (1/sr)")


def draw_cost(layout: bpy.types.UILayout, settings: Any, data: tasks.Data | None) -> None:
    """Draw what a fit with these settings costs, before the material has it."""
    column = layout.column(align=True)
    if data is None:
        return
    found, held = queries.cost(data, fit_arguments(settings))
    if found.error is not None:
        draw_warning(layout, str(found.error))
        return
    draw_row(column, *_HEADINGS)
    draw_row(column, *_numbers(found, held))


def _numbers(found: Job[tasks.Fitted], held: Job[float]) -> tuple[str, str, str, str]:
    """Coefficients, kilobytes, RMSE and held-out RMSE as text, as far as they are known."""
    if found.error is not None:
        return "-", "-", "-", "-"
    if found.result is None:
        return "...", "...", "...", "..."
    made, errors, _ = found.result
    held_out = f"{held.fraction:.0%}" if held.finished is None else "-" if held.error else f"{held.result:.3g}"
    return f"{made.coefficient_count:,}", f"{made.nbytes / 1000:,.0f}", f"{errors.rmse:.3g}", held_out
