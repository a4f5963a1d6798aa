"""Pictures of the fit with the present settings."""

import math
from typing import Any

import bpy

from ..annotations import present
from ..jobs import queries
from ..jobs.job import Job
from ..materials.properties import fit_arguments
from .layout import MaterialPanel


class MEASUREDBRDF_PT_pictures(MaterialPanel, bpy.types.Panel):
    """Preview of these settings, before the material is fitted"""

    bl_label = "Look"
    bl_parent_id = "MEASUREDBRDF_PT_material"

    def draw(self, context: bpy.types.Context) -> None:
        material = present(context.material)
        settings, data = material.measured_brdf, queries.data(material).result
        if data is None:
            return
        arguments = fit_arguments(settings)
        anisotropic = data.description.rotations is not None
        azimuth = settings.shown_phi if anisotropic else 0.0
        pictures = self.layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        _draw_picture(pictures, "Lit sphere", *queries.lit_sphere(data, arguments))
        polar = queries.polar_plot(data, arguments, settings.shown_theta, azimuth)
        job = _draw_picture(pictures, "Plane of incidence", *polar)
        if anisotropic:
            turned = queries.turned_plane(data, arguments, settings.shown_theta)
            _draw_picture(pictures, "Plane, turned", *turned)
        _draw_picture(pictures, "RMSE by level", *queries.errors_by_level(data, arguments))
        column = pictures.column()
        column.label(text="Incidence")
        column.prop(settings, "shown_theta", text="")
        if job.result is not None and not math.isnan(job.result[1]):
            column.label(text=f"Samples at {math.degrees(job.result[1]):.1f}°")
        column.label(text="Radius: cube root")
        if anisotropic:
            column = pictures.column()
            column.label(text="Light's Azimuth")
            column.prop(settings, "shown_phi", text="")
            column.label(text="Turned: 0°–360°")
            column.label(text="Strokes: tangent")


def _draw_picture(layout: bpy.types.UILayout, title: str, icon: int, job: Job[Any]) -> Job[Any]:
    column = layout.column()
    column.label(text=title)
    if icon:
        column.template_icon(icon_value=icon, scale=9)
    if job.finished is None:
        column.progress(factor=job.fraction, text=job.doing)
    elif job.error is not None:
        column.label(text=str(job.error), icon="ERROR")
    return job
