"""Small bright places in the world, which the shader is told of as it is of suns.

Found are the sun of a Sky Texture, and what stands out in an Environment Texture. One that is missed, or found where
there is none, costs noise and no correctness (`lamps`).
"""

import math

import numpy as np
from mathutils import Euler, Vector

_ROWS = 512                     # an image is looked at in this resolution: a third of a degree
_FEWEST_ROWS = 16               # in which a spot and what is around it can be told apart
_MOST_PIXELS = 1 << 26
_SPOTS = 4
_LARGEST = math.radians(6)      # the radius of a spot
_AROUND = 1.4                   # times the largest radius: what lies there is what the spot stands out from
_LEAST_LIGHT = 0.02             # of all light, for a spot to be worth a lobe
_HELD = 0.95                    # of a spot's light lies within its radius
_KEPT = 16                      # images whose spots are remembered
_found = {}                     # by image


def bright_spots(world):
    """The bright places of a world: a list of (direction, angular radius, irradiance), radians."""
    tree = world.node_tree if world is not None else None
    if tree is None:
        return []
    strength = max((node.inputs["Strength"].default_value for node in tree.nodes if node.type == "BACKGROUND"),
                   default=0.0)
    spots = []
    for node in _before([link for link in tree.links if link.to_node.type == "OUTPUT_WORLD"], tree.links):
        if node.type == "TEX_SKY" and getattr(node, "sun_disc", False):
            spots.append((_turned(node, _sun(node)), max(node.sun_size / 2, 1e-4), math.pi * strength))
        elif node.type == "TEX_ENVIRONMENT" and node.projection == "EQUIRECTANGULAR" and node.image is not None:
            spots += [(_turned(node, direction), radius, light * strength)
                      for direction, radius, light in _in_image(node.image.original)]
    return spots


def _before(links, every):
    """The nodes that these links come from, and those before them."""
    nodes, waiting = [], list(links)
    while waiting:
        node = waiting.pop().from_node
        if node not in nodes:
            nodes.append(node)
            waiting += [link for link in every if link.to_node == node]
    return nodes


def _sun(node):
    return Vector((math.sin(node.sun_rotation) * math.cos(node.sun_elevation),
                   math.cos(node.sun_rotation) * math.cos(node.sun_elevation), math.sin(node.sun_elevation)))


def _turned(node, direction):
    """The world's direction that a texture shows in a direction of its own, by the rotation of a Mapping node."""
    vector = node.inputs.get("Vector")
    links = vector.links if vector is not None else ()
    if links and links[0].from_node.type == "MAPPING":
        mapping = links[0].from_node
        rotation = Euler(mapping.inputs["Rotation"].default_value).to_matrix()
        direction = (rotation if mapping.vector_type == "TEXTURE" else rotation.inverted()) @ Vector(direction)
    return tuple(direction)


def _in_image(image):
    """`spots` of an image, looked for once."""
    width, height = image.size
    key = image.session_uid, image.filepath, width, height
    if key not in _found:
        while len(_found) >= _KEPT:
            del _found[next(iter(_found))]
        found = []
        if image.source in {"FILE", "GENERATED"} and 0 < width * height <= _MOST_PIXELS:
            pixels = np.empty(width * height * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            found = spots(pixels.reshape(height, width, image.channels)[..., :3].mean(axis=2))
        _found[key] = found
    return _found[key]


def spots(radiance):
    """What stands out in an equirectangular image.

    Parameters
    ----------
    radiance : (height, width) array
        The lowest row first, as Blender has it.

    Returns
    -------
    list of (direction, angular radius, irradiance)
        The brightest first.
    """
    step = max(radiance.shape[0] // _ROWS, 1)
    height, width = (size // step * step for size in radiance.shape)
    if min(height, width) < _FEWEST_ROWS:
        return []
    radiance = np.nan_to_num(radiance[:height, :width], posinf=0, neginf=0)
    radiance = radiance.reshape(height // step, step, width // step, step).mean(axis=(1, 3), dtype=float)
    latitude = ((np.arange(len(radiance)) + 0.5) / len(radiance) - 0.5)[:, None] * np.pi
    longitude = (0.5 - (np.arange(radiance.shape[1]) + 0.5) / radiance.shape[1]) * 2 * np.pi
    unit = np.stack(np.broadcast_arrays(np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
                                        np.sin(latitude)), axis=-1)
    solid_angle = np.cos(latitude) * (2 * np.pi**2 / radiance.size)
    total = (radiance * solid_angle).sum()
    left, found = radiance.copy(), []
    for _ in range(_SPOTS):
        direction = unit[np.unravel_index(left.argmax(), left.shape)]
        for _ in range(2):                      # the brightest pixel, and then the middle of what is about it
            angle = np.arccos(np.clip(unit @ direction, -1, 1))
            inside = angle < _LARGEST
            ring = (angle < _AROUND * _LARGEST) & ~inside
            more = np.where(inside, np.maximum(left - np.median(left[ring]), 0), 0) * solid_angle
            light = more.sum()
            if not light > _LEAST_LIGHT * total:
                return found
            middle = np.einsum("ij,ijk", more, unit)
            direction = middle / np.linalg.norm(middle)
        angle = np.arccos(np.clip(unit @ direction, -1, 1))
        order = np.argsort(angle[inside])
        held = np.searchsorted(np.cumsum(more[inside][order]), _HELD * light)
        pixel = np.pi / len(radiance)
        found.append((tuple(direction), float(angle[inside][order][min(held, len(order) - 1)] + pixel / 2),
                      float(light)))
        left[inside] = np.median(left[ring])
    return found
