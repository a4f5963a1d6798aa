"""Node groups that all measured materials of a file share: what their closure nodes have in common.

A group is recognised by a custom property, which names what is in it, and found again by what is in it: one that a user
has changed is left to the materials that have it. Appended materials bring groups of their own, which `merge` replaces.
"""

import hashlib
from collections.abc import Callable
from typing import Any

import bpy

from .active_material import can_change

_GROUP_PREFIX = "Measured BRDF "
_KIND = "measured_brdf_kind"
_DIGEST = "measured_brdf_digest"        # of the group as it was made
_SETTINGS = "operation", "use_clamp", "distribution", "rotation_type", "invert", "noise_dimensions"     # of its nodes


def shared_group(kind: str, fill: Callable[[bpy.types.NodeTree], None]) -> bpy.types.NodeTree:
    """The group of this file of a kind; made and filled if there is none yet."""
    for tree in _local():
        if tree[_KIND] == kind and is_unchanged(tree):
            return tree
    tree = bpy.data.node_groups.new(_GROUP_PREFIX + kind, "ShaderNodeTree")
    fill(tree)
    tree[_KIND], tree[_DIGEST] = kind, _digest(tree)
    return tree


def is_unchanged(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a group is one that is shared, as it was made."""
    return tree is not None and tree.get(_KIND) is not None and tree.get(_DIGEST) == _digest(tree)


def used_only_by(tree: bpy.types.NodeTree) -> list[bpy.types.NodeTree]:
    shared = [each for each in _local() if not each.use_fake_user]
    users = bpy.data.user_map(subset=shared)
    return [each for each in shared if users[each] == {tree}]


def merge() -> None:
    """Put one group in the place of all that are the same: appending and making local bring more."""
    first: dict[tuple[str, str], bpy.types.NodeTree] = {}
    for tree in _local():
        shared = first.setdefault((tree[_KIND], tree[_DIGEST]), tree)
        if shared != tree and is_unchanged(shared) and is_unchanged(tree):
            tree.user_remap(shared)
            bpy.data.node_groups.remove(tree)


def _local() -> list[bpy.types.NodeTree]:
    return [tree for tree in bpy.data.node_groups if tree.get(_KIND) is not None and can_change(tree)]


def _digest(tree: bpy.types.NodeTree) -> str:
    sockets = [(item.name, item.identifier, item.in_out, item.socket_type, _value(item))
               for item in tree.interface.items_tree if item.item_type == "SOCKET"]
    nodes = [(node.name, node.bl_idname, node.mute, *(getattr(node, name, "") for name in _SETTINGS),
              [_value(socket) for socket in node.inputs]) for node in tree.nodes]
    links = sorted((link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
                   for link in tree.links)
    return hashlib.sha256(repr((sockets, nodes, links)).encode()).hexdigest()


def _value(socket: Any) -> tuple[float, ...] | float | None:
    value: Any = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") else value
