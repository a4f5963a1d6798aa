"""Pictures of the fit with the present settings."""

import math
from typing import Any

import bpy

from ..core import material as materials
from ..core.annotations import present
from ..core.properties import fit_arguments, is_as_fitted
from ..panel.layout import MaterialPanel, draw_picture
from ..work import queries
from ..work.job import Job


class MEASUREDBRDF_PT_pictures(MaterialPanel, bpy.types.Panel):
    """The material's fit; where the settings have been changed since, what they would give, and every level"""

    bl_label = "Curves"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 20

    def draw(self, context: bpy.types.Context) -> None:
        material = present(context.material)
        settings, data = material.measured_brdf, queries.data(material).result
        # the fit in the shader, which needs no measurements, unless the settings have been changed since
        is_kept = materials.is_measured(material) and (data is None or is_as_fitted(settings))
        if data is None and not is_kept:
            return
        anisotropic = (materials.tangent_input(material) is not None if is_kept or data is None
                       else data.description.rotations is not None)
        theta, azimuth = settings.shown_theta, settings.shown_phi if anisotropic else 0.0
        pictures = self.layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        if is_kept or data is None:
            _draw_picture(pictures, "Lit sphere", *queries.material_sphere(material))
            polar = queries.material_polar(material, theta, azimuth, data)
            turned = queries.material_turned(material, theta) if anisotropic else None
        else:
            arguments = fit_arguments(settings)
            _draw_picture(pictures, "Lit sphere", *queries.lit_sphere(data, arguments))
            polar = queries.polar_plot(data, arguments, theta, azimuth)
            turned = queries.turned_plane(data, arguments, theta) if anisotropic else None
        job = _draw_picture(pictures, "Plane of incidence", *polar)
        if turned is not None:
            _draw_picture(pictures, "Plane, turned", *turned)
        if data is not None and not is_kept:
            _draw_picture(pictures, "RMSE by level", *queries.errors_by_level(data, fit_arguments(settings)))
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
    draw_picture(column, icon, job, 9)
    return job


classes = (MEASUREDBRDF_PT_pictures,)
