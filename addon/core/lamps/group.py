"""The node group that tells the measured materials of a file about the lamps: how many there are, and by nodes that
read them from an object's carrier (`carrier`) where and how strong they are.

A group is recognised by its nodes, because users may rename it. It has room for as many lamps as it has pairs of a
`Lamp` and an `Extent` node: files of other versions may hold fewer or more than this version's shader takes.
"""

import re
from typing import Any

import bpy

from ....fitter.shader_constants import MAX_LAMPS
from ..blender.active_material import can_change
from .carrier import CARRIER_NAME, PROPERTY_KINDS, attribute

LAMP_GROUP = "Lamps"
FRUGAL = "Frugal"
_NUMBERED = re.compile(r"(Lamp|Extent)([1-9][0-9]*)")


def node_tree() -> bpy.types.NodeTree:
    """The shared node group of this version's shader; made if there is none yet."""
    return next(iter(_local()), None) or _create()


def _local() -> list[bpy.types.NodeTree]:
    return [tree for tree in trees() if can_change(tree) and capacity(tree) == MAX_LAMPS]


def merge() -> None:
    """Put one group in the place of all that say the same, and what is overridden in that of its override."""
    local = _local()
    same = [(tree, local[0]) for tree in local[1:]]
    same += [(tree, tree.override_library.reference) for tree in trees() if tree.override_library is not None]
    for tree, instead in same:
        if _outputs(tree) == _outputs(instead):
            tree.user_remap(instead)
            bpy.data.node_groups.remove(tree)


def _outputs(tree: bpy.types.NodeTree) -> list[tuple[str, str]]:
    return [(item.name, item.identifier) for item in tree.interface.items_tree]


def trees() -> list[bpy.types.NodeTree]:
    """All lamp groups of the file that are complete: a user may have removed nodes, or reused the name."""
    return [tree for tree in bpy.data.node_groups if tree.bl_idname == "ShaderNodeTree" and capacity(tree)]


def capacity(tree: bpy.types.NodeTree) -> int:
    """How many lamps a group holds; 0 if it is not a lamp group, or lacks nodes."""
    if LAMP_GROUP not in tree.nodes or FRUGAL not in tree.nodes:
        return 0
    numbers: dict[str, set[int]] = {"Lamp": set(), "Extent": set()}
    for node in tree.nodes:
        if node.type == "ATTRIBUTE" and (numbered := _NUMBERED.fullmatch(node.name)):
            numbers[numbered[1]].add(int(numbered[2]))
    count = len(numbers["Lamp"])
    return count if numbers["Lamp"] == numbers["Extent"] == set(range(1, count + 1)) else 0


def store(tree: bpy.types.NodeTree, count: int, frugal: bool) -> None:
    """Write what differs, how many lamps there are and whether few closures fit: every write makes Cycles compile the
    materials. Nodes of other lamps are muted, else Cycles would give objects attributes for them."""
    changed = [_write(tree.nodes[name].outputs, "default_value", [value])
               for name, value in ((LAMP_GROUP, float(count)), (FRUGAL, float(frugal)))]
    numbers = [_NUMBERED.fullmatch(node.name) for node in tree.nodes]
    muted = [node.mute if number is None else int(number[2]) > count
             for node, number in zip(tree.nodes, numbers, strict=True)]
    if any([*changed, _write(tree.nodes, "mute", muted)]):
        tree.update_tag()


def _write(items: Any, name: str, values: list[Any]) -> bool:
    """Write a property of sockets or nodes where it differs: whether any does."""
    before = [getattr(item, name) for item in items]
    if before == values:
        return False
    if can_change(items.id_data):
        # an assignment would have Blender copy all node trees that have the group in them, with their bytecode
        items.foreach_set(name, values)
        return True
    for item, old, new in zip(items, before, values, strict=True):      # Blender takes no block for a linked group
        if old != new:
            setattr(item, name, new)
    return True


def _create() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(CARRIER_NAME, "ShaderNodeTree")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    for row, name in enumerate((FRUGAL, LAMP_GROUP), -1):
        tree.interface.new_socket(name, in_out="OUTPUT", socket_type="NodeSocketFloat")
        node = tree.nodes.new("ShaderNodeValue")
        node.name = node.label = name
        node.location, node.outputs[0].default_value = (0, -150 * row), 0
        tree.links.new(node.outputs[0], output.inputs[name])
    for number in range(1, MAX_LAMPS + 1):
        for column, kind in enumerate(PROPERTY_KINDS):
            name = f"{kind}{number}"
            tree.interface.new_socket(name, in_out="OUTPUT", socket_type="NodeSocketVector")
            node = tree.nodes.new("ShaderNodeAttribute")
            node.name = node.label = name
            node.location, node.mute = (200 * column, -150 * number), True
            node.attribute_type, node.attribute_name = "OBJECT", attribute(kind, number)
            tree.links.new(node.outputs["Vector"], output.inputs[name])
    return tree
