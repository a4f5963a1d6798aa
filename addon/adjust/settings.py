"""What artists change of a measured material: the settings of `fitter.edited`, stored with the material."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
from bpy.props import FloatProperty, FloatVectorProperty, PointerProperty

from ...fitter.model.edit import COAT_WIDTHS, WIDTH_BOUNDS
from ..core.annotations import Arguments
from ..core.storage import edits

ADJUSTMENTS = ("diffuse_gain", "diffuse_tint", "highlight_gain", "highlight_tint", "highlight_width", "coat",
               "coat_roughness")
_LEAST_ROUGHNESS = COAT_WIDTHS[0] ** 0.5
_ARGUMENT_DIGITS = 6        # of arguments: single precision has no more

listeners: list[Callable[[bpy.types.Material], object]] = []
"""Called with a material when one of its adjustments has been changed."""


def _notify_listeners(settings: Any, _context: bpy.types.Context) -> None:
    for listener in listeners:
        listener(settings.id_data)


class MeasuredAdjustments(bpy.types.PropertyGroup):
    """Stored with the material."""

    diffuse_gain: FloatProperty(
        name="Diffuse", default=1, min=0, max=100, soft_max=2, update=_notify_listeners,
        description="Multiplies the diffuse part of the reflectance, which is seen from everywhere")
    diffuse_tint: FloatVectorProperty(
        name="Diffuse Tint", subtype="COLOR", size=3, default=(1, 1, 1), min=0, soft_max=1, update=_notify_listeners,
        description="Colour by which the diffuse part is multiplied")
    highlight_gain: FloatProperty(
        name="Highlight", default=1, min=0, max=100, soft_max=2, update=_notify_listeners,
        description="Multiplies the highlight, which is all that is brighter than the diffuse part")
    highlight_tint: FloatVectorProperty(
        name="Highlight Tint", subtype="COLOR", size=3, default=(1, 1, 1), min=0, soft_max=1, update=_notify_listeners,
        description="Colour by which the highlight is multiplied")
    highlight_width: FloatProperty(
        name="Highlight Width", default=1, min=WIDTH_BOUNDS[0], max=WIDTH_BOUNDS[1], update=_notify_listeners,
        description="Above 1 roughens: the highlight becomes wider and less bright. Below 1 sharpens. It reflects as "
                    "much light as before")
    coat: FloatProperty(
        name="Coat", default=0, min=0, max=1, subtype="FACTOR", update=_notify_listeners,
        description="A layer of clear varnish above the measured surface")
    coat_roughness: FloatProperty(
        name="Coat Roughness", default=0.1, min=_LEAST_ROUGHNESS, max=1, subtype="FACTOR", update=_notify_listeners,
        description="Roughness of the varnish, as a Principled BSDF has it")


def get(material: bpy.types.Material) -> Any:
    return material.measured_brdf_adjustments


def edit_arguments(material: bpy.types.Material) -> Arguments:
    """The keyword arguments of `fitter.edited` that adjustments ask for; empty if nothing is adjusted."""
    return requested_edit(get(material))


def requested_edit(settings: Any) -> Arguments:
    """The keyword arguments of `fitter.edited` that `MeasuredAdjustments`, or what has their values, ask for."""
    wanted = {
        "diffuse": tuple(round(settings.diffuse_gain * value, _ARGUMENT_DIGITS) for value in settings.diffuse_tint),
        "highlight": tuple(round(settings.highlight_gain * value, _ARGUMENT_DIGITS)
                           for value in settings.highlight_tint),
        "width": round(settings.highlight_width, _ARGUMENT_DIGITS)}
    if settings.coat != 0:              # what is not a number is refused by `fitter.edited`, as elsewhere
        wanted |= {"coat": round(settings.coat, _ARGUMENT_DIGITS),
                   "coat_width": max(round(settings.coat_roughness ** 2, _ARGUMENT_DIGITS), COAT_WIDTHS[0])}
    neutral: Arguments = {"diffuse": (1, 1, 1), "highlight": (1, 1, 1), "width": 1}
    return {name: _shortest(value) for name, value in wanted.items() if value != neutral.get(name)}


def _shortest(value: Any) -> Any:
    """One number where a tint has no colour, so that a grey fit stays grey; a list, as JSON has it, elsewhere."""
    if not isinstance(value, tuple):
        return value
    return value[0] if len(set(value)) == 1 else list(value)


def move(material: bpy.types.Material, values: dict[str, Any]) -> None:
    """Take all adjustments back but these, by name."""
    for name in ADJUSTMENTS:
        if name in values:
            setattr(get(material), name, values[name])
        else:
            get(material).property_unset(name)


def adjustment_values(edit: Arguments) -> dict[str, Any]:
    """All adjustments that keyword arguments of `fitter.edited` stand for, in single precision, as Blender has them."""
    values: dict[str, Any] = {"highlight_width": edit.get("width", 1), "coat": edit.get("coat", 0),
                              "coat_roughness": edit["coat_width"] ** 0.5 if "coat_width" in edit else 0.1}
    for part in ("diffuse", "highlight"):
        factors = np.broadcast_to(edit.get(part, 1), 3)
        values[f"{part}_gain"] = float(factors.max()) or 1.0
        values[f"{part}_tint"] = factors / values[f"{part}_gain"]
    return {name: np.asarray(value, np.float32).tolist() for name, value in values.items()}


SLIDERS = edits.Sliders(lambda edit: requested_edit(SimpleNamespace(**adjustment_values(edit))),
                        lambda material, edit: move(material, adjustment_values(edit)))
classes = (MeasuredAdjustments,)
pointers = ((bpy.types.Material, "measured_brdf_adjustments",
             PointerProperty(type=MeasuredAdjustments, name="Adjustments")),)
