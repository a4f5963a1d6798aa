"""The surface of a measured material in other programs: a Principled BSDF that exporters find, and renderers never see.

It has a Material Output of its own, for all renderers. Cycles and EEVEE prefer the outputs that are made for them, and
whoever asks for any output gets this one: MaterialX, and glTF, which takes the active output. USD takes the first
Principled BSDF of a material, OBJ and FBX one that is linked to an output. None looks for it inside of a group.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ...fitter.colours import DEFAULT, conversion
from .annotations import not_none
from .reading import scene_colours

if TYPE_CHECKING:
    from ...fitter.arrays import FloatArray
    from ...fitter.cycles.principled_bsdf import Principled
    from .outcomes import Surface

NAME = "Measured BRDF Export"
_FITTED = "measured_brdf"               # custom property of the node: the values of the last fit


def update(material: bpy.types.Material, surface: Surface) -> None:
    """Set the Principled BSDF that is exported, with an output of its own, to the closest one to the data.

    The material must have outputs for Cycles and for EEVEE. One for all renderers that the user has made stays as it
    is, and is what is exported.
    """
    node = _node(not_none(material.node_tree))
    if node is not None:
        _set(node, inputs(surface.principled, lambda color: shown(surface, color)))


def mix(material: bpy.types.Material, first: bpy.types.Material, second: bpy.types.Material, share: float) -> None:
    """Set the Principled BSDF of a mix between those of two materials; `share` is that of the second.

    Where one of them has none, the mix stays as it is.
    """
    parts = [not_none(item.node_tree).nodes.get(NAME) for item in (first, second)]
    if any(part is None or _FITTED not in part for part in parts):
        return
    node = _node(not_none(material.node_tree))
    if node is not None:
        weights = np.array([1 - share, share])
        names: list[str] = list(not_none(parts[0])[_FITTED].keys())
        _set(node, {name: (weights @ np.array([not_none(part).inputs[name].default_value for part in parts])).tolist()
                    for name in names})


def _set(node: bpy.types.Node, values: dict[str, Any]) -> None:
    before = node.get(_FITTED, {})
    for name, value in values.items():
        socket = node.inputs[name]
        # what a user has changed since the last fit stays
        if name not in before or np.allclose(before[name], socket.default_value, atol=1e-6):
            socket.default_value = value
    node[_FITTED] = values


def inputs(close: Principled, shown: Callable[[FloatArray], FloatArray]) -> dict[str, Any]:
    """The values of the inputs of a Principled BSDF by name; `shown` converts its colours, (3,) each."""
    return {"Base Color": (*shown(close.base_color), 1.0), "Metallic": close.metallic, "Roughness": close.roughness,
            "Specular IOR Level": close.specular_level, "Sheen Weight": close.sheen_weight,
            "Sheen Roughness": close.sheen_roughness, "Sheen Tint": (*shown(close.sheen_tint), 1.0),
            "Coat Weight": close.coat_weight, "Coat Roughness": close.coat_roughness}


def shown(surface: Surface, color: FloatArray) -> FloatArray:
    """A colour of a surface, (3,), in the space of the open file, as Blender takes it: libraries may have another."""
    return np.clip(conversion(surface.colours, scene_colours() or DEFAULT) @ color, 0, 1)


def _node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The Principled BSDF to set, which is made where there is none; None if the user exports something else."""
    node = tree.nodes.get(NAME)
    if node is not None and node.bl_idname != "ShaderNodeBsdfPrincipled":
        node = None
    outputs = [each for each in tree.nodes if each.type == "OUTPUT_MATERIAL"]
    if any(each.target == "ALL" for each in outputs):
        return node
    right = max((each.location.x for each in outputs), default=0)
    below = min((each.location.y for each in outputs), default=0) - 180
    if node is None:
        node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node.name = node.label = output.label = NAME
    output.location, node.location = (right, below), (right - 260, below)
    tree.links.new(node.outputs["BSDF"], output.inputs["Surface"])
    output.is_active_output = True
    return node
