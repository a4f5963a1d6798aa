"""Node trees of materials, worlds and groups: making one, the inputs of a group, and what leads to an output."""

from collections.abc import Iterable
from typing import Any

import bpy

from ..annotations import not_none


def use_nodes(owner: bpy.types.Material | bpy.types.World) -> bpy.types.NodeTree:
    """The node tree of a new material or world, which it is given where it has none."""
    if bpy.app.version < (5, 0, 0):             # since then each has one
        owner.use_nodes = True
    return not_none(owner.node_tree)


def displayed_name(node: bpy.types.Node) -> str:
    """What the Shader Editor calls a node."""
    tree = getattr(node, "node_tree", None)
    return node.label or (node.name if tree is None else tree.name)


def list_upstream(links: Iterable[bpy.types.NodeLink]) -> list[bpy.types.Node]:
    """The nodes that these links come from, and all nodes before those."""
    nodes: list[bpy.types.Node] = []
    waiting = list(links)
    while waiting:
        node = not_none(waiting.pop().from_node)
        if node not in nodes:
            nodes.append(node)
            waiting += [link for socket in node.inputs for link in not_none(socket.links)]
    return nodes


def add_input(tree: bpy.types.NodeTree, name: str, kind: str, description: str, **settings: Any) -> Any:
    """Give a group an input of a kind, such as "Float", with settings of its socket: the socket."""
    socket = not_none(tree.interface).new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    socket.description = description
    for setting, value in settings.items():
        setattr(socket, setting, value)
    return socket
