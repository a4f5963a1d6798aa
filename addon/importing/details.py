"""The numbers of a fit, and its settings: for those who want to know, or to choose them."""

import math
from typing import Any

import bpy

from ...fitter import PRESETS
from ..core.annotations import not_none
from ..core.shading import material as materials
from ..core.shading import node_group
from ..core.storage.outcomes import Data
from ..core.storage.properties import NO_SPECULAR_LEVEL, ORIGINAL, fitted_arguments, is_preset, quality_summary
from ..panel.layout import MaterialPanel, draw_value, draw_wrapped, name_beside_value, wrap_text
from ..work import queries
from . import fit

_ERROR_ROWS = ("Nodes", node_group.NODES_ERROR), ("EEVEE", node_group.EEVEE_ERROR)


class MEASUREDBRDF_PT_settings(MaterialPanel, bpy.types.Panel):
    """Levels of the fit, in place of a preset's"""

    bl_label = "Fit Settings"
    bl_parent_id = "MEASUREDBRDF_PT_data"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, settings = not_none(self.layout), not_none(context.material).measured_brdf
        name_beside_value(layout)
        column = layout.column(align=True)
        levels = column.column(align=True)
        levels.active = not settings.use_tolerance
        levels.prop(settings, "diffuse_level", slider=True)
        levels.prop(settings, "specular_level", slider=True)
        row = levels.row()
        row.active = settings.specular_level != NO_SPECULAR_LEVEL
        row.prop(settings, "compression", slider=True)
        row = column.row(heading="Auto")
        row.prop(settings, "use_tolerance", text="")
        row = row.row()
        row.active = settings.use_tolerance
        row.prop(settings, "tolerance", text="")
        draw_wrapped(layout, compression_in_words(settings), "INFO")
        _draw_original(layout, not_none(context.material))


class MEASUREDBRDF_PT_details(MaterialPanel, bpy.types.Panel):
    """Errors, size and time of the fit that the material has"""

    bl_label = "Details"
    bl_parent_id = "MEASUREDBRDF_PT_data"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.material is not None and materials.is_measured(context.material)

    def draw(self, context: bpy.types.Context) -> None:
        layout, material = not_none(self.layout), not_none(context.material)
        if (judged := quality_summary(material.measured_brdf)).whole:
            draw_wrapped(layout, judged.whole, judged.icon)
        column = layout.column(align=True)
        for name, value in rows(material):
            draw_value(column, name, value)
        for line in wrap_text(material.measured_brdf.changes):
            layout.label(text=line)


def _draw_original(layout: bpy.types.UILayout, material: bpy.types.Material) -> None:
    """Draw the choice of the method of 2002, with its error before it is taken."""
    settings, data = material.measured_brdf, queries.data(material).result
    is_chosen = is_preset(settings, ORIGINAL)
    layout.operator(fit.MEASUREDBRDF_OT_use_preset.bl_idname, text="Original 2002 Method",
                    depress=is_chosen).preset = ORIGINAL
    if data is None or is_chosen:
        return
    job = queries.fitting_job(data, {**PRESETS[ORIGINAL]})
    if job.result is not None:
        rmse = job.result.errors.rmse
        times = f", {rmse / settings.rmse:.1f} times that of this fit" if settings.rmse > 0 else ""
        draw_wrapped(layout, f"RMSE {rmse:.3g} / sr{times}", "INFO")
    elif job.error is not None:
        draw_wrapped(layout, str(job.error), "INFO")
    else:
        layout.progress(factor=job.fraction, text=job.doing)


def compression_in_words(settings: Any) -> str:
    if settings.use_tolerance:
        return "Auto chooses the levels and the compression"
    if settings.specular_level == NO_SPECULAR_LEVEL:
        return "There is no fine lattice to compress"
    dropped = settings.compression
    return f"{dropped:.4g} % of the fine lattice dropped, {round(100 - dropped, 4):.4g} % kept"


def rows(material: bpy.types.Material) -> list[tuple[str, str]]:
    settings, tree = material.measured_brdf, not_none(materials.group_node(material)).node_tree
    is_judged = not math.isnan(settings.rmse)           # else its measurements are in no file
    known = [("Levels", settings.fitted_levels)]
    if is_judged:
        known += [("RMSE", f"{settings.rmse:.3g} / sr"),
                  ("MRE", f"{settings.mre:.2%} of the peak" if not math.isnan(settings.mre) else "all values are 0"),
                  ("Error at Unseen Angles", _unseen_error(material))]
    known += [("Coefficients", f"{settings.coefficients:,}"), ("Storage", f"{settings.bytes:,} bytes")]
    if size := node_group.bytes_in_file(tree):
        known.append(("In the .blend", f"about {size / 1000:,.0f} kB"))
    known.append(("Highlight Error", ", ".join(f"{name} {tree[error]:.1%}" for name, error in _ERROR_ROWS)))
    if is_judged:
        known.append(("Fitted in", f"{settings.seconds:.2f} s"))
    if materials.tangent_input(material) is not None:
        known.append(("Direction", "Tangent, Rotation"))
    return known


def _unseen_error(material: bpy.types.Material) -> str:
    """The RMSE at samples that the fit of a material has not seen, or why it is not known."""
    settings = material.measured_brdf
    arguments = fitted_arguments(settings)
    data: Data | None = queries.data(material).result if settings.filepath else None
    if data is None or data.digest != settings.digest:
        return "needs the measurements"
    if arguments is None:
        return "needs a refit"
    job = queries.held_out(data, arguments)
    if job.finished is None:
        return f"working out, {job.fraction:.0%}"
    return str(job.error) if job.error is not None else f"{job.result:.3g} / sr"


classes = (MEASUREDBRDF_PT_settings, MEASUREDBRDF_PT_details)
