"""Small bright places in the world, which the shader takes for suns: that of a Sky Texture, and spots in an Environment
Texture. One that is missed, or found where there is none, only adds noise."""

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import bpy
import numpy as np
from mathutils import Euler, Vector

from ....fitter.arrays import FloatArray, SingleArray
from ....fitter.storage.files import time_and_size
from ..annotations import Vector3
from ..blender.node_trees import list_upstream

_IMAGE_ROWS = 512               # an image is searched at this resolution: a third of a degree
_MIN_ROWS = 16                  # below this a spot cannot be told from its surroundings
_MAX_PIXELS = 1 << 26
_MAX_SPOTS = 4
_MAX_RADIUS = math.radians(6)   # of a spot
_LEAST_RING = 1.4               # least outer radius of the ring that gives the background of a spot, over _MAX_RADIUS
_MIN_SHARE = 0.02               # of all light, for a spot to be worth a lobe
_ENCLOSED = 0.95                # share of a spot's light that lies within its radius
_MAX_IMAGES = 16                # whose spots are cached


class Spot(NamedTuple):
    """A bright place: a unit vector toward it, its angular radius in radians, and its irradiance."""

    direction: Vector3
    radius: float
    irradiance: float


def bright_spots(world: bpy.types.World | None) -> list[Spot]:
    tree = world.node_tree if world is not None else None
    if tree is None:
        return []
    strength = max((node.inputs["Strength"].default_value for node in tree.nodes if node.type == "BACKGROUND"),
                   default=0.0)
    bright: list[Spot] = []
    for node in list_upstream(link for link in tree.links if link.to_node.type == "OUTPUT_WORLD"):
        if node.type == "TEX_SKY" and getattr(node, "sun_disc", False):
            bright.append(Spot(_to_world(node, _sun(node)), max(node.sun_size / 2, 1e-4), math.pi * strength))
        elif node.type == "TEX_ENVIRONMENT" and node.projection == "EQUIRECTANGULAR" and node.image is not None:
            bright += [Spot(_to_world(node, direction), radius, light * strength)
                       for direction, radius, light in _image_spots(node.image.original)]
    return bright


def _sun(node: bpy.types.Node) -> Vector3:
    horizontal = math.cos(node.sun_elevation)
    return (math.sin(node.sun_rotation) * horizontal, math.cos(node.sun_rotation) * horizontal,
            math.sin(node.sun_elevation))


def _to_world(node: bpy.types.Node, direction: Vector3) -> Vector3:
    """The world direction in which a texture shows one of its own directions: undoes the rotation of a Mapping node."""
    socket = node.inputs.get("Vector")
    links: Sequence[bpy.types.NodeLink] = socket.links if socket is not None else ()
    if not links or links[0].from_node.type != "MAPPING":
        return direction
    mapping = links[0].from_node
    rotation = Euler(mapping.inputs["Rotation"].default_value).to_matrix()
    x, y, z = (rotation if mapping.vector_type == "TEXTURE" else rotation.inverted()) @ Vector(direction)
    return x, y, z


def _image_spots(image: bpy.types.Image) -> list[Spot]:
    """The `spots` of an image, searched for anew where its file, size or colour space is another, or pixels were
    changed; that they were changed again is noticed when the image is saved."""
    path = bpy.path.abspath(image.filepath, library=image.library)
    return _search_image(image.session_uid, path, time_and_size(path), image.is_dirty, image.colorspace_settings.name,
                         *image.size)


@lru_cache(maxsize=_MAX_IMAGES)
def _search_image(session_uid: int, _path: str, _stamp: tuple[int, int] | None, _is_dirty: bool, _colours: str,
                  width: int, height: int) -> list[Spot]:
    image = next(each for each in bpy.data.images if each.session_uid == session_uid)
    if image.source not in {"FILE", "GENERATED"} or not 0 < width * height <= _MAX_PIXELS:
        return []
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return spots(pixels.reshape(height, width, image.channels)[..., :3].mean(axis=2))


def directions(height: int, width: int) -> FloatArray:
    """Where the texels of an equirectangular image are, (height, width, 3) unit vectors, the lowest row first."""
    latitude = ((np.arange(height) + 0.5) / height - 0.5)[:, None] * np.pi
    longitude = (0.5 - (np.arange(width) + 0.5) / width) * 2 * np.pi
    return np.stack(np.broadcast_arrays(np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
                                        np.sin(latitude)), axis=-1)


def spots(image: FloatArray | SingleArray) -> list[Spot]:
    """The bright spots, the brightest first, of an equirectangular image of radiance, the lowest row first."""
    step = max(image.shape[0] // _IMAGE_ROWS, 1)
    height, width = (size // step * step for size in image.shape)
    if min(height, width) < _MIN_ROWS:
        return []
    finite = np.nan_to_num(image[:height, :width], posinf=0, neginf=0)
    radiance = finite.reshape(height // step, step, width // step, step).mean(axis=(1, 3), dtype=float)
    unit = directions(*radiance.shape)
    solid_angle = np.hypot(unit[..., 0], unit[..., 1]) * (2 * np.pi**2 / radiance.size)
    total = (radiance * solid_angle).sum()
    left = radiance.copy()
    pixel = np.pi / len(radiance)
    ring_radius = max(_LEAST_RING * _MAX_RADIUS, _MAX_RADIUS + pixel)  # so that there are pixels in it
    brightest: list[Spot] = []
    for _ in range(_MAX_SPOTS):
        direction = unit[np.unravel_index(left.argmax(), left.shape)]
        for _ in range(2):                      # first around the brightest pixel, then around the centroid
            angle = np.arccos(np.clip(unit @ direction, -1, 1))
            inside = angle < _MAX_RADIUS
            ring = (angle < ring_radius) & ~inside
            excess = np.where(inside, np.maximum(left - np.median(left[ring]), 0), 0) * solid_angle
            light = excess.sum()
            if not light > _MIN_SHARE * total:
                return brightest
            centroid = np.einsum("ij,ijk", excess, unit)
            direction = centroid / np.linalg.norm(centroid)
        angle = np.arccos(np.clip(unit @ direction, -1, 1))
        order = np.argsort(angle[inside])
        last = min(np.searchsorted(np.cumsum(excess[inside][order]), _ENCLOSED * light), len(order) - 1)
        x, y, z = direction
        brightest.append(Spot((x, y, z), float(angle[inside][order][last] + pixel / 2), float(light)))
        left[inside] = np.median(left[ring])
    return brightest
