"""Placeholders: light materials that look like a published fit, and are baked when somebody uses them.

A placeholder has the Principled BSDF that is closest to the published model, under the name of the surface that other
programs get (`export_surface`), so that it becomes that surface when the material is fitted.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...fitter.published import Published, name_in
from ..core import export_surface
from ..core.annotations import present
from ..core.properties import use_preset
from ..core.transaction import new_data_removed_on_error

if TYPE_CHECKING:
    from ...fitter.arrays import FloatArray
    from ...fitter.cycles.principled_bsdf import Principled

_MARK = "measured_brdf_placeholder"         # custom property of the material
_PRESET = "Standard"


def create(wanted: Published, close: Principled) -> bpy.types.Material:
    """Make a placeholder of a published material, given the Principled BSDF that is close to it, in linear Rec.709."""
    with new_data_removed_on_error():
        material = bpy.data.materials.new(wanted.title)
        if bpy.app.version < (5, 0, 0):         # since then every material does
            material.use_nodes = True
        tree = present(material.node_tree)
        tree.nodes.clear()
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
        node.name = node.label = export_surface.NAME
        for name, value in export_surface.inputs(close, _clipped).items():
            node.inputs[name].default_value = value
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        output.location = node.location.x + 300, node.location.y
        tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
        material.diffuse_color = (*_clipped(close.base_color), 1)
        material.roughness, material.metallic = close.roughness, close.metallic
        settings = material.measured_brdf
        use_preset(settings, _PRESET)
        settings.filepath = wanted.path
        material[_MARK] = True
    return material


def is_placeholder(material: bpy.types.Material) -> bool:
    """Whether a material is a placeholder that has not been fitted and may be."""
    settings = material.measured_brdf
    return (material.get(_MARK) is not None and not settings.coefficients and name_in(settings.filepath) is not None
            and material.is_editable and material.override_library is None)


def _clipped(color: FloatArray) -> FloatArray:
    return np.clip(color, 0, 1)
