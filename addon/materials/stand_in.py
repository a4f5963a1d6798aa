"""The stand-in for a measured material where OSL does not run: in EEVEE, and in the solid viewport."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...fitter.colours import DEFAULT, conversion
from ..annotations import present
from .reading import scene_colours

if TYPE_CHECKING:
    from ...fitter.arrays import FloatArray
    from .material import Outcome

_NODE = "Measured BRDF Fallback"


def update(material: bpy.types.Material, outcome: Outcome) -> None:
    """Set the viewport's colour, and a Principled BSDF with an output for EEVEE, to the best match of the data.

    An EEVEE output of the user's own stays as it is.
    """
    close = outcome.principled
    material.diffuse_color = (*_shown(outcome, outcome.albedo), 1)
    material.roughness, material.metallic = close.roughness, close.metallic
    tree = present(material.node_tree)
    node = tree.nodes.get(_NODE)
    if node is None:
        node = _add(tree)
    if node is not None and node.bl_idname == "ShaderNodeBsdfPrincipled":
        for name, value in (("Base Color", (*_shown(outcome, close.base_color), 1)), ("Roughness", close.roughness),
                            ("Metallic", close.metallic), ("Specular IOR Level", close.specular_level)):
            node.inputs[name].default_value = value


def _shown(outcome: Outcome, color: FloatArray) -> FloatArray:
    """A colour of an outcome, (3,), in the space of the open file, as Blender takes it: libraries may have another."""
    here = scene_colours() or DEFAULT
    return np.clip(conversion(outcome.measured.colours, here) @ color, 0, 1)


def _add(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """Add the fallback node with an EEVEE output; None if the user has made such an output.

    The material must have an output for Cycles.
    """
    cycles = tree.get_output_node("CYCLES")
    if any(node.type == "OUTPUT_MATERIAL" and node.target == "EEVEE" for node in tree.nodes):
        return None
    if cycles.target == "ALL":
        cycles.target = "CYCLES"
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = node.label = _NODE
    output.target = "EEVEE"
    node.location = cycles.location.x - 260, cycles.location.y - 250
    output.location = cycles.location.x, cycles.location.y - 250
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    return node
