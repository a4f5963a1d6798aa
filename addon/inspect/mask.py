"""The value of a mask at a spot: of an image that is connected to an input, as renderers look it up."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...fitter.arrays import FloatArray, IntArray
from ..core.blender.previews import picture_of
from ..core.shading.export_inputs import grey_weights, linear_colours

_EDGES: dict[str, Callable[[IntArray, int], IntArray]] = {
    "REPEAT": lambda at, size: at % size, "EXTEND": lambda at, size: np.clip(at, 0, size - 1)}


def value(socket: Any, uv_maps: Mapping[str, FloatArray]) -> float | None:
    """The value, 0 to 1, of the image that is connected to an input of a node; None where something else is.

    `uv_maps` are the coordinates there, (2,), in each UV map by its name; the rendered one is "".
    """
    node: Any = socket.links[0].from_node if socket.is_linked else None
    if node is None or node.type != "TEX_IMAGE" or node.image is None or node.extension not in _EDGES:
        return None
    if node.projection != "FLAT" or min(node.image.size) < 1:
        return None
    name = _uv_map(node.inputs["Vector"])
    return _looked_up(node, uv_maps[name]) if name is not None and name in uv_maps else None


def _uv_map(socket: Any) -> str | None:
    """The name of the UV map that an input takes; None where it takes something else."""
    if not socket.is_linked:
        return ""
    link = socket.links[0]
    if link.from_node.type == "UVMAP":
        return str(link.from_node.uv_map)
    return "" if link.from_node.type == "TEX_COORD" and link.from_socket.name == "UV" else None


def _looked_up(node: Any, at: FloatArray) -> float:
    """The brightness of an image at UV coordinates, between its four pixels, or of the nearest."""
    image, size = node.image, np.array(node.image.size)
    place = at * size - (0.0 if node.interpolation == "Closest" else 0.5)
    corner = np.floor(place).astype(int)
    share = np.zeros(2) if node.interpolation == "Closest" else place - corner
    x, y = (_EDGES[node.extension](np.array([first, first + 1]), length)
            for first, length in zip(corner, size, strict=True))
    grey = linear_colours(image, picture_of(image)[np.ix_(y, x)].astype(float)[..., :3]) @ grey_weights()
    weights = np.outer([1 - share[1], share[1]], [1 - share[0], share[0]])
    return float(np.clip((weights * grey).sum(), 0, 1))
