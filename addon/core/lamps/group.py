"""The node group that tells the measured materials of a file about its lamps. It holds nothing but nodes with values.

A group is recognised by its nodes, because users may rename it. It has room for as many lamps as it has pairs of a
`Lamp` and an `Extent` node: files of other versions may hold fewer or more than this version's shader takes.
"""

import math
import re
from collections.abc import Collection, Sequence
from typing import Any

import bpy

from ....fitter.shader_constants import MAX_LAMPS
from .lamp import Lamp

NAME = "Measured BRDF Lamps"
LAMPS = "Lamps"
FRUGAL = "Frugal"
_NUMBERED = re.compile(r"(Lamp|Extent)([1-9][0-9]*)")


def node_tree() -> bpy.types.NodeTree:
    """The shared node group of this version's shader; made if there is none yet."""
    return next(iter(_local()), None) or _create()


def _local() -> list[bpy.types.NodeTree]:
    """The groups of this version's shader that belong to this file."""
    return [tree for tree in trees() if tree.library is None and tree.override_library is None
            and capacity(tree) == MAX_LAMPS]


def merge() -> None:
    """Put one group in the place of all that say the same: appending, making local and overriding bring more.

    An override gives way to what it overrides.
    """
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
    if LAMPS not in tree.nodes or FRUGAL not in tree.nodes:
        return 0
    numbers: dict[str, set[int]] = {"Lamp": set(), "Extent": set()}
    for node in tree.nodes:
        if numbered := _NUMBERED.fullmatch(node.name):
            numbers[numbered[1]].add(int(numbered[2]))
    count = len(numbers["Lamp"])
    return count if numbers["Lamp"] == numbers["Extent"] == set(range(1, count + 1)) else 0


def sockets(tree: bpy.types.NodeTree, number: int) -> list[bpy.types.NodeSocket]:
    """The five sockets of one lamp: its position or direction (three), its size, its strength."""
    return [*tree.nodes[f"Lamp{number}"].inputs, *tree.nodes[f"Extent{number}"].inputs[:2]]


def store(tree: bpy.types.NodeTree, lamps: Sequence[Lamp], frugal: bool,
          driven: Collection[tuple[int, int]] = frozenset()) -> None:
    """Write the values that differ: every write makes Cycles update the shader.

    An assignment to a socket makes Blender copy all node trees that have the group in them, with their bytecode. So
    values are written in blocks, and the group alone is marked as changed: its users are evaluated anew, not copied.
    Blender takes no blocks for linked groups.

    Frugal is whether few closures fit. Sockets that are driven, by lamps from 1 and indices into their `sockets`, are
    skipped.
    """
    changed = [_write(tree.nodes[name].outputs, [float(value)]) for name, value in ((LAMPS, len(lamps)),
                                                                                    (FRUGAL, frugal))]
    for number, (position, size, strength) in enumerate(lamps, 1):
        values = [socket.default_value if (number, index) in driven else value for index, (socket, value)
                  in enumerate(zip(sockets(tree, number), (*position, size, strength), strict=True))]
        changed += [_write(tree.nodes[f"Lamp{number}"].inputs, values[:3]),
                    _write(tree.nodes[f"Extent{number}"].inputs, [*values[3:], 0.0])]
    if any(changed):
        tree.update_tag()


def _write(sockets: Any, values: list[float]) -> bool:
    """Write values into sockets, the inputs or outputs of a node, where they differ: whether any does."""
    before = [socket.default_value for socket in sockets]
    if all(math.isclose(old, new, rel_tol=1e-6, abs_tol=1e-9) for old, new in zip(before, values, strict=True)):
        return False
    if sockets.id_data.library is None and sockets.id_data.override_library is None:
        sockets.foreach_set("default_value", values)
        return True
    for socket, old, new in zip(sockets, before, values, strict=True):
        if old != new:
            socket.default_value = new
    return True


def _create() -> bpy.types.NodeTree:
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    for row, name in enumerate((FRUGAL, LAMPS), -1):
        _add(tree, output, "ShaderNodeValue", name, "NodeSocketFloat", row)
        tree.nodes[name].outputs[0].default_value = 0
    for number in range(1, MAX_LAMPS + 1):
        for kind in ("Lamp", "Extent"):
            _add(tree, output, "ShaderNodeCombineXYZ", f"{kind}{number}", "NodeSocketVector", number)
    return tree


def _add(tree: bpy.types.NodeTree, output: bpy.types.Node, kind: str, name: str, socket_type: str, row: int) -> None:
    tree.interface.new_socket(name, in_out="OUTPUT", socket_type=socket_type)
    node = tree.nodes.new(kind)
    node.name = node.label = name
    node.location = (200 if name.startswith("Extent") else 0, -150 * row)
    tree.links.new(node.outputs[0], output.inputs[name])
