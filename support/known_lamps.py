"""The lamps of which a measured material knows: what its nodes read from an object, as Cycles reads it."""

import bpy
import numpy as np

POINTER = "measured_brdf_lamps"


def lamp_groups():
    return [tree for tree in bpy.data.node_groups if "Lamps" in tree.nodes]


def readers(scene=None):
    """The objects of a scene, by default the open one, that read lamps."""
    return [item for item in (scene or bpy.context.scene).objects if POINTER in item]


def known(tree=None, depsgraph=None, item=None):
    """The lamps that the nodes of a lamp group read from an object, (n, 5): position or direction, size and strength.

    By default the only group of the file, and the first object of the scene that reads lamps; with a dependency graph,
    as that evaluates it.
    """
    if tree is None:
        tree, = lamp_groups()
    item = item or next(iter(readers()), None)
    if item is not None and depsgraph is not None:
        item = item.evaluated_get(depsgraph)
    count = round(tree.nodes["Lamps"].outputs[0].default_value)
    nodes = [[tree.nodes[f"{kind}{number}"] for kind in ("Lamp", "Extent")] for number in range(1, count + 1)]
    assert not any(node.mute for pair in nodes for node in pair)
    following = tree.nodes.get(f"Lamp{count + 1}")
    assert following is None or following.mute
    if item is None:
        return np.zeros((0, 5))
    return np.array([[*item.path_resolve(place.attribute_name), *item.path_resolve(extent.attribute_name)][:5]
                     for place, extent in nodes]).reshape(count, 5)
