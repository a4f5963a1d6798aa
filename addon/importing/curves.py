"""Pictures of the fit with the present settings."""

import math
from typing import Any, cast

import bpy

from ..core import material as materials
from ..core.annotations import not_none
from ..core.outcomes import KeptMix, Shown, Wanted
from ..core.properties import fit_arguments, is_as_fitted
from ..panel.layout import MaterialPanel, draw_picture, has_data
from ..work import queries
from ..work.job import Job


class MEASUREDBRDF_PT_pictures(MaterialPanel, bpy.types.Panel):
    """The material's fit; where the settings have been changed since, what they would give"""

    bl_label = "Curves"
    bl_parent_id = "MEASUREDBRDF_PT_material"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 20

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_data(context)

    def draw(self, context: bpy.types.Context) -> None:
        material = not_none(context.material)
        settings = material.measured_brdf
        data = queries.data(material).result if settings.filepath else None
        kept = queries.shown(material) if materials.is_measured(material) or not settings.filepath else None
        # the fit in the shader, which needs no measurements, unless the settings have been changed since
        is_kept = kept is not None and (data is None or is_as_fitted(settings, data.digest))
        if data is None and not is_kept:
            return
        about = is_kept, material.session_uid       # neither's picture stands for the other's
        if is_kept or data is None:
            anisotropic = materials.tangent_input(material) is not None
            shown: Shown = cast(Shown, kept)
            sphere = queries.material_sphere(material)
        else:
            anisotropic = data.description.rotations is not None
            shown = Wanted(data, fit_arguments(settings))
            sphere = queries.lit_sphere(about, shown)
        pictures = self.layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)
        _draw_picture(pictures, "Lit sphere", *sphere)
        theta, azimuth = settings.shown_theta, settings.shown_phi if anisotropic else 0.0
        job = _draw_picture(pictures, "Plane of incidence", *queries.polar_plot(about, shown, data, theta, azimuth))
        if anisotropic:
            _draw_picture(pictures, "Plane, turned", *queries.turned_plane(about, shown, theta))
        column = pictures.column()
        column.label(text="Incidence")
        column.prop(settings, "shown_theta", text="")
        if job.result is not None and not math.isnan(job.result[1]):
            column.label(text=f"Samples at {math.degrees(job.result[1]):.1f}°")
        column.label(text="Radius: cube root")
        if isinstance(shown, KeptMix) and shown.share is None:
            column.label(text="Mask: half of each")
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
