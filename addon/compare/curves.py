"""The one viewer of fits: a material as its settings are now, beside the pinned one where there is one."""

import math
from functools import partial
from typing import Any, cast

import bpy
import numpy as np

from ...fitter.imaging.drawing import Color
from ...fitter.imaging.pictures import split
from ...fitter.imaging.plane_plot import PAIR
from ...fitter.quality import verdict
from ..core.annotations import not_none
from ..core.shading import comparison, rendered
from ..core.shading import material as materials
from ..core.storage.outcomes import EmbeddedFit, FitRequest, KeptMix, Shown
from ..core.storage.properties import fit_arguments, is_as_fitted
from ..panel.layout import MaterialPanel, draw_picture, draw_row, draw_wrapped, has_data, is_narrow, picture_scale
from ..work import icons, queries, queue
from ..work.job import Job
from . import work as comparisons
from .operators import MEASUREDBRDF_OT_pin

_HEADINGS = "", "A", "B"
_TWO_ABREAST = 36           # characters that two pictures, or two columns of numbers, need beside one another


class MEASUREDBRDF_PT_pictures(MaterialPanel, bpy.types.Panel):
    """The material's fit, its samples, and another material beside it; where the settings have been changed since, what
    they would give"""

    bl_label = "Curves"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 20

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_data(context)

    def draw(self, context: bpy.types.Context) -> None:
        layout, material, scene = not_none(self.layout), not_none(context.material), not_none(context.scene)
        other = _draw_choice(layout, scene, material) if materials.is_shown(material) else None
        if other is not None:
            draw_names(layout, material, other)
        _draw_pictures(layout, context, material, other)
        if other is not None:
            _draw_numbers(layout, [_numbers(each, scene) for each in (material, other)])


def _draw_choice(layout: bpy.types.UILayout, scene: bpy.types.Scene,
                 material: bpy.types.Material) -> bpy.types.Material | None:
    """Draw what the material is compared with, and return it."""
    chosen, other = comparison.get(scene), comparison.pinned(scene, material)
    parts = layout.split(factor=0.35)       # Blender cuts names of pointers
    parts.label(text=chosen.bl_rna.properties["pinned"].name)
    row = parts.row(align=True)
    row.prop(chosen, "pinned", text="")
    row.operator(MEASUREDBRDF_OT_pin.bl_idname, text="", icon="PINNED")
    if chosen.pinned == material:
        draw_wrapped(layout, "This is the pinned material: choose another one to compare it with", "INFO")
    return other


def _draw_pictures(layout: bpy.types.UILayout, context: bpy.types.Context, material: bpy.types.Material,
                   other: bpy.types.Material | None) -> None:
    """Draw the sphere and the plane of incidence, and of an anisotropic fit the plane as it turns."""
    settings, chosen = material.measured_brdf, comparison.get(not_none(context.scene))
    data = queries.data(material).result if settings.filepath else None
    kept = queries.shown_fits(material) if materials.is_measured(material) or not settings.filepath else None
    # the fit in the shader, which needs no measurements, unless the settings have been changed since
    is_kept = kept is not None and (data is None or is_as_fitted(settings, data.digest))
    if data is None and not is_kept:
        return
    about = is_kept, material.session_uid       # neither's picture stands for the other's
    shown: Shown = cast(Shown, kept) if is_kept or data is None else FitRequest(data, fit_arguments(settings))
    anisotropic = (shown.data.description.rotations is not None if isinstance(shown, FitRequest) else
                   materials.tangent_input(material) is not None)
    fits = ((shown, () if isinstance(shown, FitRequest) else queries.reaches(material)),
            *(() if other is None else ((_embedded_fit(other), queries.reaches(other)),)))
    columns = 1 if is_narrow(_TWO_ABREAST) else 2
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, align=True)
    scale = picture_scale(context, columns)

    def draw(title: str, icon: int, job: Job[Any]) -> tuple[bpy.types.UILayout, Job[Any]]:
        column = grid.column()
        column.label(text=title)
        draw_picture(column, icon, job, scale)
        return column, job

    if other is not None:
        at = round(chosen.divide, 2)
        column, _ = draw("Lit sphere", *_split_sphere(shown, fits[1][0], at))
        draw_line(column, chosen)
    elif isinstance(shown, FitRequest):
        draw("Lit sphere", *queries.lit_sphere(about, shown))
    else:
        draw("Lit sphere", *queries.material_sphere(material))
    theta, azimuth = settings.shown_theta, settings.shown_phi if anisotropic else 0.0
    column, job = draw("Plane of incidence", *queries.polar_plot(about, fits, data, theta, azimuth))
    column.prop(settings, "shown_theta", slider=True)
    if anisotropic:
        column.prop(settings, "shown_phi", slider=True)
    if job.result is not None and not math.isnan(job.result[1]):
        column.label(text=f"Dots: samples at {math.degrees(job.result[1]):.1f}\u00b0")
    if isinstance(shown, KeptMix) and shown.share is None:
        column.label(text="Mask: half of each")
    if anisotropic:
        column, _ = draw("Plane, turned", *queries.turned_plane(about, shown, theta))
        column.label(text="Turned: 0\u00b0\u2013360\u00b0")
        column.label(text="Strokes: tangent")


def _split_sphere(first: Shown, second: Shown, at: float) -> tuple[int, Job[Any]]:
    """The icon of a sphere of two materials with a line between them, and the job that is waited for. A mix by a mask
    has half of each: the picture is split already."""
    evenly = [each._replace(share=0.5) if isinstance(each, KeptMix) and each.share is None else each
              for each in (first, second)]
    jobs: list[Job[Any]] = [queries.lit_sphere(each.digest, each)[1] for each in evenly]
    waited = next((job for job in jobs if job.result is None), jobs[0])
    if waited.result is None:
        return 0, waited
    left, right = (not_none(job.result) for job in jobs)
    return icons.at_once(("split", *(each.digest for each in evenly), at), lambda: split(left, right, at)), waited


def draw_names(layout: bpy.types.UILayout, material: bpy.types.Material, other: bpy.types.Material) -> None:
    """Draw which material is A and which is B, with their colours."""
    column = layout.column(align=True)
    for letter, each, color in zip("AB", (material, other), PAIR, strict=True):
        column.label(text=f"{letter}: {each.name}", icon_value=_swatch(color))


def _swatch(color: Color) -> int:
    return icons.at_once(("swatch", color), lambda: np.full((16, 16, 4), color, dtype=np.float32))


def draw_line(layout: bpy.types.UILayout, chosen: Any) -> None:
    """Draw where the line between two materials is."""
    row = layout.row(align=True)
    row.label(text="A | B")
    row.prop(chosen, "divide", text="", slider=True)


def _draw_numbers(layout: bpy.types.UILayout, columns: list[dict[str, str]]) -> None:
    rows = [(name, mine, columns[1][name]) for name, mine in columns[0].items()]
    column = layout.column(align=True)
    if is_narrow(_TWO_ABREAST):
        for name, *values in rows:
            column.label(text=name)
            draw_row(column, *(f"{heading}: {value}" for heading, value in zip(_HEADINGS[1:], values, strict=True)))
        return
    for name, *values in (_HEADINGS, *rows):
        parts = column.split(factor=0.48)
        parts.label(text=name)
        draw_row(parts, *values)


def _numbers(material: bpy.types.Material, scene: bpy.types.Scene) -> dict[str, str]:
    """The numbers of a material as text, by name, as far as they are known."""
    settings, shown = material.measured_brdf, _embedded_fit(material)
    figures: Job[comparisons.Figures] = queue.ask(("figures", shown.digest), partial(comparisons.figures, shown))
    parts = [part.measured_brdf for part in materials.measured_parts(material)]
    error = f"{rendered.in_scene(material, scene).error:.1%}"
    wait = "..." if figures.finished is None else "-"
    fitted, known = settings.coefficients > 0, figures.result
    return {"Match": _worst([part.match for part in parts], verdict.MATCH_LIMITS),
            "Between Measured Angles": _worst([part.between for part in parts], verdict.BETWEEN_LIMITS),
            "Coefficients": f"{known.coefficients:,}" if known is not None else wait,
            "Bytes": f"{known.nbytes:,}" if known is not None else wait,
            "RMSE": f"{settings.rmse:.3g}" if fitted and math.isfinite(settings.rmse) else "-",
            "Albedo %": _percent(known.albedo) if known is not None else wait,
            "Highlight Error": error}


def _embedded_fit(material: bpy.types.Material) -> EmbeddedFit | KeptMix:
    return cast(EmbeddedFit | KeptMix, queries.shown_fits(material))


def _worst(errors: list[float], limits: tuple[float, ...]) -> str:
    """The grade of the worst of a mix's parts, or of the one material, where all are known."""
    return verdict.grade(max(errors), limits) if min(errors, default=-1) >= 0 else "-"


def _percent(albedo: Any) -> str:
    shown = [f"{100 * each:.0f}" for each in albedo]
    return shown[0] if len(set(shown)) == 1 else " ".join(shown)


classes = (MEASUREDBRDF_PT_pictures,)
