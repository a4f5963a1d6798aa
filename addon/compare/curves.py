"""The one viewer of fits: a material as its settings are now, beside the pinned one where there is one; and renders of
both by Cycles."""

import math
from functools import partial
from typing import Any, cast

import bpy
import numpy as np

from ...fitter.arrays import FloatArray
from ...fitter.imaging.pictures import split
from ...fitter.imaging.plane_plot import PAIR
from ...fitter.quality import verdict
from ..core.annotations import not_none
from ..core.shading import comparison, rendered
from ..core.shading import material as materials
from ..core.storage.outcomes import EmbeddedFit, FitRequest, KeptMix, Shown
from ..core.storage.properties import fit_arguments, is_as_fitted
from ..panel.layout import SubPanel, draw_picture, draw_wrapped, has_data, is_narrow, picture_scale
from ..work import icons, queries, queue, tasks
from ..work.job import Job
from .operators import MEASUREDBRDF_OT_pin, MEASUREDBRDF_OT_render_look, render_key, renders

_NUMBERS = "Match", "Between Measured Angles", "Coefficients", "Bytes", "RMSE", "Albedo %", "Highlight Error"
_INSPECT = "measured_brdf.inspect"      # of another slice: the same plane over the viewport
_TWO_ABREAST = 36           # characters that two pictures, or two columns of numbers, need beside one another


class MEASUREDBRDF_PT_pictures(SubPanel, bpy.types.Panel):
    """The material's fit, its samples, and another material beside it; where the settings have been changed since, what
    they would give"""

    bl_label = "Curves"
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
            _draw_numbers(layout, _numbers(material, scene), _numbers(other, scene))


def _draw_choice(layout: bpy.types.UILayout, scene: bpy.types.Scene,
                 material: bpy.types.Material) -> bpy.types.Material | None:
    """Draw what the material is compared with, and return it."""
    chosen, other = comparison.get(scene), comparison.find_pinned(scene, material)
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
    is_own = materials.is_measured(material) or not settings.filepath
    shown: Shown | None = queries.shown_fits(material) if is_own else None
    domain, anisotropic = queries.reaches(material), materials.tangent_input(material) is not None
    # the fit in the shader, which needs no measurements, unless the settings have been changed since
    if data is not None and (shown is None or not is_as_fitted(settings, data.digest)):
        shown, domain = FitRequest(data, fit_arguments(settings)), ()
        anisotropic = data.description.rotations is not None
    if shown is None:
        return
    about = isinstance(shown, FitRequest), material.session_uid     # neither's picture stands for the other's
    fits = [(shown, domain)]
    columns = 1 if is_narrow(_TWO_ABREAST) else 2
    grid = layout.grid_flow(row_major=True, columns=columns, even_columns=True, align=True)

    def draw(title: str, icon: int, job: Job[Any]) -> bpy.types.UILayout:
        column = grid.column()
        column.label(text=title)
        draw_picture(column, icon, job, picture_scale(context, columns))
        return column

    if other is not None:
        fits.append((cast(Shown, queries.shown_fits(other)), queries.reaches(other)))
        draw_line(draw("Lit sphere", *_split_sphere(shown, fits[1][0], round(chosen.divide, 2))), chosen)
    else:
        draw("Lit sphere", *(queries.lit_sphere(about, shown) if isinstance(shown, FitRequest) else
                             queries.material_sphere(material)))
    theta = settings.shown_theta
    icon, job = queries.polar_plot(about, tuple(fits), data, theta, settings.shown_phi if anisotropic else 0.0)
    column = draw("Plane of incidence", icon, job)
    if hasattr(bpy.types, "MEASURED_BRDF_OT_inspect"):
        column.operator(_INSPECT, text="In the 3D View", icon="LIGHT_HEMI").place = "MOUSE"
    column.prop(settings, "shown_theta", slider=True)
    if anisotropic:
        column.prop(settings, "shown_phi", slider=True)
    if job.result is not None and not math.isnan(job.result[1]):
        column.label(text=f"Dots: samples at {math.degrees(job.result[1]):.1f}\u00b0")
    if isinstance(shown, KeptMix) and shown.share is None:
        column.label(text="Mask: half of each")
    if anisotropic:
        column = draw("Plane, turned", *queries.turned_plane(about, shown, theta))
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
    return icons.draw_at_once(("split", *(each.digest for each in evenly), at), lambda: split(left, right, at)), waited


def draw_names(layout: bpy.types.UILayout, material: bpy.types.Material, other: bpy.types.Material) -> None:
    column = layout.column(align=True)
    for letter, each, color in zip("AB", (material, other), PAIR, strict=True):
        swatch = icons.draw_at_once(("swatch", color), partial(np.full, (16, 16, 4), color, np.float32))
        column.label(text=f"{letter}: {each.name}", icon_value=swatch)


def draw_line(layout: bpy.types.UILayout, chosen: Any) -> None:
    row = layout.row(align=True)
    row.label(text="A | B")
    row.prop(chosen, "divide", text="", slider=True)


def _draw_numbers(layout: bpy.types.UILayout, *columns: tuple[str, ...]) -> None:
    """Draw the numbers of both materials beside one another; below their names, where there is little room."""
    column, narrow = layout.column(align=True), is_narrow(_TWO_ABREAST)
    if not narrow:
        columns = ("A", *columns[0]), ("B", *columns[1])
    for name, *values in zip(_NUMBERS if narrow else ("", *_NUMBERS), *columns, strict=True):
        row = column if narrow else column.split(factor=0.48)
        row.label(text=name)
        beside = row.row()
        for letter, value in zip("AB", values, strict=True):
            beside.label(text=f"{letter}: {value}" if narrow else value)


def _numbers(material: bpy.types.Material, scene: bpy.types.Scene) -> tuple[str, ...]:
    """The numbers of a material as text, as far as they are known: those of `_NUMBERS`."""
    settings, kept = material.measured_brdf, cast(EmbeddedFit | KeptMix, queries.shown_fits(material))
    parts = [part.measured_brdf for part in materials.measured_parts(material)]
    albedo: Job[FloatArray] = queue.ask(("albedo", kept.digest), partial(tasks.normal_albedo, kept))
    percent = [f"{100 * each:.0f}" for each in (() if albedo.result is None else albedo.result)]
    return (_worst([part.match for part in parts], verdict.MATCH_LIMITS),
            _worst([part.between for part in parts], verdict.BETWEEN_LIMITS),
            f"{sum(part.coefficients for part in parts):,}", f"{sum(part.bytes for part in parts):,}",
            f"{settings.rmse:.3g}" if settings.coefficients and math.isfinite(settings.rmse) else "-",
            " ".join(percent[:1] if len(set(percent)) == 1 else percent) or ("-" if albedo.finished else "..."),
            f"{rendered.scene_rendering(material, scene).error:.1%}")


def _worst(errors: list[float], limits: tuple[float, ...]) -> str:
    """The grade of the worst of a mix's parts, or of the one material, where all are known."""
    return verdict.grade(max(errors), limits) if min(errors, default=-1) >= 0 else "-"


class MEASUREDBRDF_PT_look(SubPanel, bpy.types.Panel):
    """A render by Cycles, on a sphere or a shader ball, with the pinned material beside it"""

    bl_label = "Test Render"
    bl_order = 40

    def draw(self, context: bpy.types.Context) -> None:
        layout, scene, material = not_none(self.layout), not_none(context.scene), not_none(context.material)
        chosen = comparison.get(scene)
        layout.row().prop(chosen, "shape", expand=True)
        layout.row().prop(chosen, "lighting", expand=True)
        other = comparison.find_pinned(scene, material)
        wanted = [material] if other is None else [material, other]
        made = [renders[key] for each in wanted if (key := render_key(scene, each)) in renders]
        layout.operator(MEASUREDBRDF_OT_render_look.bl_idname, text="Render Both" if other is not None else "Render",
                        icon="RENDER_STILL")
        if len(made) < len(wanted):
            return
        (first, *_), (last, *_) = made[0], made[-1]
        icon = icons.draw_at_once(("look", *(number for _, number in made), round(chosen.divide, 2)),
                             lambda: split(first, last, chosen.divide) if other is not None else first)
        layout.template_icon(icon_value=icon, scale=picture_scale(context, 1, 16))
        if other is not None:
            draw_line(layout, chosen)
            draw_names(layout, material, other)


classes = (MEASUREDBRDF_PT_pictures, MEASUREDBRDF_PT_look)
