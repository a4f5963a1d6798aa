"""What a fit costs before a material has it: its size and its errors, as text."""

from typing import Any

import bpy

from ..core.storage.outcomes import Data, Fitted
from ..core.storage.properties import fit_arguments
from ..work import queries
from ..work.job import Job
from .layout import draw_value, draw_warning

_COST_HEADINGS = "Coefficients", "KB of the Fit", "RMSE", "Error at Unseen Angles"
UNKNOWN_ROW, FAILED_ROW = ("...",) * 4, ("-",) * 4


def draw_cost(layout: bpy.types.UILayout, settings: Any, data: Data | None) -> None:
    column = layout.column(align=True)
    if data is None:
        return
    fitting, held = queries.cost(data, fit_arguments(settings))
    if fitting.error is not None:
        draw_warning(layout, str(fitting.error))
        return
    for name, text in zip(_COST_HEADINGS, numbers(fitting, held), strict=True):
        draw_value(column, name, text)


def numbers(fitting: Job[Fitted], held: Job[float]) -> tuple[str, ...]:
    """Coefficients, kilobytes, RMSE and held-out RMSE as text, as far as they are known."""
    if fitting.error is not None:
        return FAILED_ROW
    if fitting.result is None:
        return UNKNOWN_ROW
    made, errors, *_ = fitting.result
    return *texts(made.coefficient_count, made.nbytes, errors.rmse), held_out(held)


def texts(coefficients: int, nbytes: int, rmse: float) -> tuple[str, str, str]:
    return f"{coefficients:,}", f"{nbytes / 1000:,.0f}", f"{rmse:.3g}"


def held_out(held: Job[float]) -> str:
    """The RMSE at held-out samples; while it is worked out, how far that is."""
    return f"({held.fraction:.0%} done)" if held.finished is None else "-" if held.error else f"{held.result:.3g}"
