"""A measured material as images for programs that know no measurements: base colour, roughness, metallic and normal.

They are what is exported (`core.shading.export_surface`), at a size, of the closest BSDF that they can hold; how far
they are from the fits of the material is worked out at some texels.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy
import numpy as np

from ...fitter.colours import DEFAULT_COLOURS, conversion
from ...fitter.cycles.metallic_roughness import difference, fit_metallic_roughness
from ...fitter.cycles.principled_bsdf import Principled
from ...fitter.model import is_isotropic
from ...fitter.model.mix import Mix
from ..core.annotations import not_none
from ..core.shading import export_inputs, export_surface, mixing
from ..core.shading import material as materials
from ..core.storage.reading import scene_colours
from ..work import queries, tasks

if TYPE_CHECKING:
    from ...fitter.arrays import ArrayLike, FloatArray
    from ...fitter.model import Reflectance

COLOUR, ROUGHNESS, METALLIC, NORMAL = "Base Color", "Roughness", "Metallic", "Normal"
_JUDGED = 3                 # rows and columns of texels that are compared with the fits
_DEFAULT_LEVEL = 0.5        # the specular level of programs that have none


class Maps(NamedTuple):
    """Images of a material."""

    # by name, (size, size, 3): the base colour linear, in the open file's space; the others numbers; the normals of the
    # tangent space, from -1 to 1 stored as 0 to 1
    pictures: dict[str, FloatArray]
    lost: list[str]             # what they do not show
    # how far they are from the fits of what was measured, at texels that are spread evenly, (n,): steps of lightness on
    # a sphere
    errors: FloatArray


def bake(material: bpy.types.Material, size: int) -> Maps:
    """The images of a measured material or of a mix. ValueError if it has no exported surface, or a part no fit."""
    node = not_none(materials.surface_node(material))
    found = export_surface.evaluate(material, node, size, _fit_values)
    if not found.values:
        raise ValueError(f"{material.name} has no exported surface, or a material that it mixes has been deleted")
    lost = [line for line in found.lost if not line.startswith(export_surface.NOT_EVERYWHERE)]
    pictures = {name: np.broadcast_to(found.values[name], (size, size, 3)) for name in (COLOUR, ROUGHNESS, METALLIC)}
    pictures[NORMAL] = _normals(node, size, found.placed, lost)
    vector = None if found.placed is None else found.placed.inputs["Vector"]
    if vector is not None and vector.is_linked:
        lost.append("The images lie as those of the material do: give them the same UV map or Mapping")
    is_varied = any(np.ndim(value) == 3 for value in found.values.values())
    middles = ((2 * np.arange(_JUDGED) + 1) * size // (2 * _JUDGED)).tolist()
    places = list(dict.fromkeys(itertools.product(middles, middles))) if is_varied else [(0, 0)]
    return Maps(pictures, lost, np.array([_error(material, node, found, pictures, place) for place in places]))


def _fit_values(material: bpy.types.Material) -> dict[str, Any]:
    close = fit_metallic_roughness(_reflectance(material))
    return {COLOUR: np.clip(close.base_color, 0, 1), ROUGHNESS: close.roughness, METALLIC: close.metallic}


def _error(material: bpy.types.Material, node: bpy.types.Node, found: export_surface.Evaluated,
           pictures: dict[str, FloatArray], place: tuple[int, int]) -> float:
    inputs = Principled(pictures[COLOUR][place], float(pictures[ROUGHNESS][place][0]),
                        float(pictures[METALLIC][place][0]), _DEFAULT_LEVEL)
    return difference(_fit_at_texel(material, node, found, place), inputs, _there(found.tint, place))


def _fit_at_texel(material: bpy.types.Material | None, node: bpy.types.Node, found: export_surface.Evaluated,
                  place: tuple[int, int]) -> Reflectance:
    if mixing.mixes.is_mix(node.node_tree):
        below, above = (_fit_at_texel(part, inner, found, place) for part, inner in zip(
            mixing.mixes.parts(node)[:2], mixing.mixes.nodes(node), strict=True))
        return Mix(below, above, float(np.clip(_there(found.read(mixing.mixes.factor(node)), place)[0], 0, 1)))
    return _reflectance(not_none(material))


def _reflectance(material: bpy.types.Material) -> Reflectance:
    """The fit that a material keeps. ValueError if it has none."""
    kept = queries.embedded_fit(material)
    if kept is None:
        raise ValueError(f"{material.name} has no fit: Refit it")
    return _Converted(tasks.kept_fit(kept), kept.colours)


def _there(value: FloatArray, place: tuple[int, int]) -> FloatArray:
    """A value at a texel, (3,), of what may be the same at all of them."""
    return np.asarray(value[place]) if value.ndim == 3 else value


@dataclass(frozen=True)
class _Converted:
    """A reflectance, with its colours in the space of the open file."""

    model: Reflectance
    colours: str

    @property
    def isotropic(self) -> bool:
        return is_isotropic(self.model)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        values = self.model.evaluate(theta_i, phi_i, theta_o, phi_o)
        return np.asarray(np.broadcast_to(values, (*values.shape[:-1], 3))
                          @ conversion(self.colours, scene_colours() or DEFAULT_COLOURS).T)


def _normals(node: bpy.types.Node, size: int, placed: bpy.types.Node | None, lost: list[str]) -> FloatArray:
    """The normals of the Normal Map node at a material's node, as an image has them; as Cycles takes its strength."""
    socket = node.inputs.get("Normal")
    source = None if socket is None else export_surface.normal_map(socket)
    flat = np.broadcast_to([0.5, 0.5, 1.0], (size, size, 3))
    if source is None:
        return flat
    inputs = not_none(source.node).inputs
    try:
        product = export_inputs.read(inputs["Color"])
        strength = export_inputs.read(inputs["Strength"])
        if strength.pictures or len(product.pictures) > 1:
            raise ValueError("Normal: an image and a constant strength are baked")
    except ValueError as error:
        lost.append(str(error))
        return flat
    seen = product.constant
    for picture in product.pictures:
        seen = seen * export_inputs.texels([picture], size)[picture]
        if placed is not None and picture.placement != export_inputs.Picture(placed, "Color").placement:
            lost.append("The normals lie otherwise than the other images")
    gain = float(strength.constant[0])
    normal = (2 * np.broadcast_to(seen, (size, size, 3)) - 1) * (gain, gain, 1.0)
    normal[..., 2] = 1 + (normal[..., 2] - 1) * min(gain, 1.0)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    return np.where(length > 0, normal / np.maximum(length, 1e-12), [0.0, 0.0, 1.0]) / 2 + 0.5
