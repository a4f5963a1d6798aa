"""A spot of an object's surface, with normal and tangent as Cycles has them there."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...fitter.arrays import ArrayLike, FloatArray, IntArray
from ..core.annotations import not_none
from ..core.blender.previews import image_pixels
from ..core.shading import material as materials
from ..core.shading import mixing, tangents
from ..core.shading.export_inputs import grey_weights, linear_colours

_LEAST = 1e-9               # length of a tangent that says something
_EDGES: dict[str, Callable[[IntArray, int], IntArray]] = {      # of images: what is beyond them
    "REPEAT": lambda at, size: at % size, "EXTEND": lambda at, size: np.clip(at, 0, size - 1)}


@dataclass(frozen=True, eq=False)
class Spot:
    """A spot of a surface; it moves with its object. Vectors, (3,), are in the coordinates of the object."""

    item: int                   # the `session_uid` of the object
    material: int               # and of the material that it has there
    location: FloatArray
    normal: FloatArray
    tangent: FloatArray         # it is turned into the surface when it is used
    as_normal: bool             # the tangent goes to the world as normals do, by Cycles' default; else as a direction
    turn: float                 # by which the material turns the tangent, counter-clockwise, radians
    origin: str                 # where the tangent comes from, for users
    masked: float | None = None     # of a mix by a mask, the share of the second material there, if it is known

    def frame(self, world: ArrayLike) -> FloatArray:
        """The frame of the surface in the world, to which a matrix leads from the object, (4, 4): x is the tangent,
        z the normal, and the last column the spot."""
        matrix = np.array(world, dtype=float)
        of_normals = np.linalg.pinv(matrix[:3, :3]).T
        normal = _unit(of_normals @ self.normal, np.array([0.0, 0.0, 1.0]))
        given = (of_normals if self.as_normal else matrix[:3, :3]) @ self.tangent
        tangent = given - (given @ normal) * normal
        if np.linalg.norm(tangent) <= _LEAST * np.linalg.norm(given):
            tangent = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
        x = _unit(tangent, tangent)
        y = np.cross(normal, x)
        x, y = (math.cos(self.turn) * x + math.sin(self.turn) * y, math.cos(self.turn) * y - math.sin(self.turn) * x)
        frame = np.eye(4)
        frame[:3] = np.stack([x, y, normal, (matrix @ np.append(self.location, 1))[:3]], axis=-1)
        return frame


def find_spot(item: bpy.types.Object, depsgraph: bpy.types.Depsgraph, origin: FloatArray,
              direction: FloatArray) -> Spot | None:
    """The first spot of an object on a ray in the world; None if it does not meet its surface."""
    evaluated = item.evaluated_get(depsgraph)
    to_local = evaluated.matrix_world.inverted_safe()
    is_hit, location, _, face = evaluated.ray_cast(to_local @ Vector(origin.tolist()),
                                                   to_local.to_3x3() @ Vector(direction.tolist()))
    return _spot(item, evaluated, np.array(location), face, -direction) if is_hit else None


def nearest(item: bpy.types.Object, depsgraph: bpy.types.Depsgraph, point: ArrayLike,
            toward: FloatArray) -> Spot | None:
    """The spot of an object's surface that is nearest to a point in the world, (3,), on the side that the viewer sees,
    in the direction `toward`, (3,); None if it has no surface."""
    evaluated = item.evaluated_get(depsgraph)
    to_local = evaluated.matrix_world.inverted_safe()
    is_there, location, _, face = evaluated.closest_point_on_mesh(to_local @ Vector(np.asarray(point).tolist()))
    return _spot(item, evaluated, np.array(location), face, toward) if is_there else None


def _spot(item: bpy.types.Object, evaluated: bpy.types.Object, location: FloatArray, face: int,
          toward: FloatArray) -> Spot:
    mesh: Any = evaluated.data
    corners, weights = _triangle(mesh, face, location)
    matrix = np.array(evaluated.matrix_world)[:3, :3]
    # Cycles takes the normals of corners to the world, makes them of length 1, and interpolates then
    at_corners = np.array([mesh.corner_normals[corner].vector for corner in corners]) @ np.linalg.pinv(matrix)
    at_corners /= np.maximum(np.linalg.norm(at_corners, axis=1, keepdims=True), 1e-30)
    normal = (weights @ at_corners) @ matrix
    seen = np.linalg.pinv(matrix) @ toward
    if np.array(mesh.polygons[face].normal) @ seen < 0:
        normal = -normal                    # as a renderer does that sees the back
    slots = evaluated.material_slots
    there = slots[min(mesh.polygons[face].material_index, len(slots) - 1)].material if len(slots) else None
    if there is None or not materials.is_shown(there):
        there = item.active_material
    material = not_none(not_none(there).original)
    tangent, as_normal, origin = _tangent(material, evaluated, corners, weights)
    return Spot(item.session_uid, material.session_uid, location, normal, tangent, as_normal, _turn(material), origin,
                _mask_value(material, mesh, corners, weights))


def _triangle(mesh: bpy.types.Mesh, face: int, location: FloatArray) -> tuple[list[int], FloatArray]:
    """The corners of the triangle of a face that a location is in, and its barycentric coordinates: (3,)."""
    mesh.calc_loop_triangles()
    of_face = np.empty(len(mesh.loop_triangles), dtype=np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", of_face)
    triangles: list[tuple[float, list[int], FloatArray]] = []
    for index in np.flatnonzero(of_face == face).tolist():
        triangle = mesh.loop_triangles[index]
        a, b, c = (np.array(mesh.vertices[vertex].co) for vertex in triangle.vertices)
        (u, v), *_ = np.linalg.lstsq(np.stack([b - a, c - a], axis=-1), location - a, rcond=None)
        weights = np.array([1 - u - v, u, v])
        triangles.append((float(weights.min()), list(triangle.loops), weights))
    _, corners, weights = max(triangles, key=lambda each: each[0])
    weights = np.maximum(weights, 0)
    return corners, weights / weights.sum()


def _tangent(material: bpy.types.Material, evaluated: bpy.types.Object, corners: list[int],
             weights: FloatArray) -> tuple[FloatArray, bool, str]:
    """The tangent in the coordinates of the object, whether it goes to the world as a normal, and where it is from."""
    socket = materials.tangent_input(material)
    node: Any = tangents.find_tangent_node(material) if socket is not None else None
    axis, origin = "Z", "around Z"
    if node is not None and node.type == "TANGENT":
        if node.direction_type == "UV_MAP":
            along = _u_direction(evaluated, corners, weights, node.uv_map)
            if along is not None:
                return along, False, "of the UV map"
            origin = "around Z, because the UV map has none here"
        else:
            axis, origin = node.axis, f"around {node.axis}"
    elif node is not None:
        origin = "around Z here; in renders, from nodes"
    mesh = evaluated.data
    at = weights @ np.array([mesh.vertices[mesh.loops[corner].vertex_index].undeformed_co for corner in corners])
    x, y, z = (at - np.array(mesh.texspace_location)) / np.maximum(np.array(mesh.texspace_size), 1e-9)
    return np.array({"X": (0, -z, y), "Y": (-z, 0, x), "Z": (-y, x, 0)}[axis]), node is None, origin


def _u_direction(evaluated: bpy.types.Object, corners: list[int], weights: FloatArray, name: str) -> FloatArray | None:
    """The direction in which U grows on a triangle, in the coordinates of the object."""
    mesh = evaluated.to_mesh()              # a copy: tangents are written into the mesh that they are asked of
    try:
        layers = mesh.uv_layers
        layer = layers.get(name) if name else next((each for each in layers if each.active_render), layers.active)
        if layer is None:
            return None
        uv = np.array([layer.uv[corner].vector for corner in corners])
        try:
            mesh.calc_tangents(uvmap=layer.name)
            along = weights @ np.array([mesh.loops[corner].tangent for corner in corners])
        except RuntimeError:                # a mesh with faces of more than four corners
            at = np.array([mesh.vertices[mesh.loops[corner].vertex_index].co for corner in corners])
            along = np.linalg.lstsq(uv[1:] - uv[0], at[1:] - at[0], rcond=None)[0][0]
    finally:
        evaluated.to_mesh_clear()
    return along if np.linalg.norm(along) > _LEAST else None


def _mask_value(material: bpy.types.Material, mesh: bpy.types.Mesh, corners: list[int],
            weights: FloatArray) -> float | None:
    """The share of the second material of a mix by a mask; None for other materials, and where it is not known."""
    node = None if materials.group_node(material) is not None else materials.mix_node(material)
    if node is None or mixing.mixes.parts(node)[2] is not None:
        return None
    uv_maps = {layer.name: weights @ np.array([layer.uv[corner].vector for corner in corners])
               for layer in mesh.uv_layers if len(layer.uv) > max(corners)}
    rendered = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
    return image_value(mixing.mixes.factor(node), uv_maps | ({"": uv_maps[rendered]} if rendered in uv_maps else {}))


def image_value(socket: Any, uv_maps: Mapping[str, FloatArray]) -> float | None:
    """The brightness, 0 to 1, of the image that is connected to an input of a node, as renderers look it up at the
    coordinates in each UV map, (2,), of which the rendered one is ""; None where something else is."""
    node: Any = socket.links[0].from_node if socket.is_linked else None
    if node is None or node.type != "TEX_IMAGE" or node.image is None or node.extension not in _EDGES:
        return None
    if node.projection != "FLAT" or min(node.image.size) < 1:
        return None
    name = _uv_map(node.inputs["Vector"])
    if name is None or name not in uv_maps:
        return None
    is_nearest = node.interpolation == "Closest"            # else it is interpolated between four pixels
    place = uv_maps[name] * np.array(node.image.size) - (0.0 if is_nearest else 0.5)
    corner = np.floor(place).astype(int)
    share = np.zeros(2) if is_nearest else place - corner
    x, y = (_EDGES[node.extension](np.array([first, first + 1]), length)
            for first, length in zip(corner, node.image.size, strict=True))
    grey = linear_colours(node.image, image_pixels(node.image)[np.ix_(y, x)].astype(float)[..., :3]) @ grey_weights()
    weights = np.outer([1 - share[1], share[1]], [1 - share[0], share[0]])
    return float(np.clip((weights * grey).sum(), 0, 1))


def _uv_map(socket: Any) -> str | None:
    """The name of the UV map that an input takes; None where it takes something else."""
    if not socket.is_linked:
        return ""
    link = socket.links[0]
    if link.from_node.type == "UVMAP":
        return str(link.from_node.uv_map)
    return "" if link.from_node.type == "TEX_COORD" and link.from_socket.name == "UV" else None


def _turn(material: bpy.types.Material) -> float:
    """The material's Rotation as an angle; that of a texture is not known, and 0."""
    node = materials.surface_node(material)
    socket: Any = None if node is None else node.inputs.get("Rotation")
    return 0.0 if socket is None or socket.is_linked else 2 * math.pi * float(socket.default_value)


def _unit(vector: FloatArray, otherwise: FloatArray) -> FloatArray:
    length = np.linalg.norm(vector)
    return np.asarray(vector / length if length > 0 else otherwise)
