"""Where the direction of an anisotropic material comes from on a mesh, and whether that is of use there.

Without a link to the input Tangent, Cycles takes that around the object's Z axis, as a lathe leaves it.
"""

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from ....fitter.arrays import FloatArray
from ..annotations import not_none
from . import material as materials

_MOST_POLYGONS = 256   # polygons of a mesh, evenly over all: panels ask whenever they are drawn
_TURNED_COSINE = 0.3        # cosine between the normal and the lathe's direction, in the mean: less is a turned part
_ROUND_OUTLINE = 1.1        # radii beyond which a corner of its outline shows that a mesh is no turned part
_LEAST_AREA = 1e-10         # of a polygon in the UV map (numerical)
_MAKES_MESHES = {"NODES", "SCREW", "SKIN", "REMESH", "BUILD", "OCEAN", "FLUID"}     # modifiers


def anisotropic(item: bpy.types.Object) -> Iterator[bpy.types.Material]:
    shown = dict.fromkeys(slot.material for slot in item.material_slots if slot.material is not None)
    yield from (material for material in shown if materials.tangent_input(material) is not None)


def find_tangent_node(material: bpy.types.Material) -> bpy.types.Node | None:
    """The node that gives the direction of an anisotropic material; None where it is that around the Z axis."""
    links = not_none(not_none(materials.tangent_input(material)).links)
    return links[0].from_node if len(links) > 0 else None


def can_be_judged(item: bpy.types.Object) -> bool:
    """Whether the mesh at hand has the polygons and UV maps of the one that is rendered."""
    return (item.type == "MESH" and item.mode != "EDIT" and len(item.data.polygons) > 0
            and not any(modifier.type in _MAKES_MESHES for modifier in item.modifiers))


def is_turned(mesh: bpy.types.Mesh) -> bool:
    """Whether a mesh is a surface of revolution about the axis from which Cycles takes its default direction."""
    center, size = np.array(mesh.texspace_location), np.maximum(np.array(mesh.texspace_size), 1e-9)
    cosines, weights, farthest = [], [], 0.0
    for polygon in _some(mesh):
        at = (np.array([mesh.vertices[vertex].co for vertex in polygon.vertices]) - center) / size
        farthest = max(farthest, float(np.hypot(at[:, 0], at[:, 1]).max()))
        along = np.stack([-at[:, 1], at[:, 0]], axis=-1) / np.maximum(np.hypot(at[:, 0], at[:, 1]), 1e-9)[:, None]
        cosines.append(float(np.abs(along @ np.array(polygon.normal)[:2]).mean()))
        weights.append(polygon.area + 1e-12)
    return farthest < _ROUND_OUTLINE and float(np.average(cosines, weights=weights)) < _TURNED_COSINE


def has_uv(mesh: bpy.types.Mesh, name: str = "") -> bool:
    """Whether a mesh has a UV map, the rendered one or that of this name, in which most polygons have an area."""
    uv_map = mesh.uv_layers.get(name) if name else next((each for each in mesh.uv_layers if each.active_render), None)
    if uv_map is None or len(uv_map.uv) < len(mesh.loops):
        return False
    areas = [_area(np.array([uv_map.uv[loop].vector for loop in polygon.loop_indices])) for polygon in _some(mesh)]
    return float(np.mean(np.array(areas) > _LEAST_AREA)) > 0.5


def take_from_uv(material: bpy.types.Material) -> None:
    tree, group = not_none(material.node_tree), not_none(materials.surface_node(material))
    node: Any = tree.nodes.new("ShaderNodeTangent")
    node.direction_type = "UV_MAP"
    node.location = group.location.x - 220, group.location.y - 160
    tree.links.new(node.outputs["Tangent"], not_none(materials.tangent_input(material)))


def take_around_axis(material: bpy.types.Material) -> None:
    tree, socket = not_none(material.node_tree), not_none(materials.tangent_input(material))
    for link in list(not_none(socket.links)):
        tree.links.remove(link)


def _some(mesh: bpy.types.Mesh) -> list[bpy.types.MeshPolygon]:
    """Some polygons of a mesh: the first, the last, and others evenly between them."""
    count = len(mesh.polygons)
    return [mesh.polygons[index] for index in np.unique(np.linspace(0, count - 1, _MOST_POLYGONS).astype(int)).tolist()]


def _area(corners: FloatArray) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2
