"""The node group through which the measured materials of a file know its lamps: nodes with values, and no more.

A group is known by its nodes, not by its name, which users may change. It has as many lamps as it has pairs of a `Lamp`
and an `Extent` node: files of other versions may hold fewer or more than this version's shader takes.
"""

import math
import re

import bpy

from ....fitter.cycles.bake import MAX_LAMPS

NAME = "Measured BRDF Lamps"
LAMPS = "Lamps"
EVEN = "Even"
_NUMBERED = re.compile(r"(Lamp|Extent)([1-9][0-9]*)")


def node_tree():
    """The shared node group of this version's shader, made where there is none yet."""
    local = (tree for tree in trees() if tree.library is None and capacity(tree) == MAX_LAMPS)
    return next(local, None) or _create()


def trees():
    """The groups that have all their nodes: a user may have taken one apart, or given its name to something else."""
    return [tree for tree in bpy.data.node_groups if tree.bl_idname == "ShaderNodeTree" and capacity(tree)]


def capacity(tree):
    """How many lamps a group holds; 0 where it is not a group of lamps, or some of its nodes are gone."""
    if LAMPS not in tree.nodes or EVEN not in tree.nodes:
        return 0
    numbers = {"Lamp": set(), "Extent": set()}
    for node in tree.nodes:
        if found := _NUMBERED.fullmatch(node.name):
            numbers[found[1]].add(int(found[2]))
    count = len(numbers["Lamp"])
    return count if numbers["Lamp"] == numbers["Extent"] == set(range(1, count + 1)) else 0


def sockets(tree, number):
    """The sockets of one lamp: its position or direction (three), its size, its strength."""
    return [*tree.nodes[f"Lamp{number}"].inputs, *tree.nodes[f"Extent{number}"].inputs[:2]]


def store(tree, lamps, even, driven=frozenset()):
    """Write what is not there already: an assignment makes Cycles take the shader up anew.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
    lamps : sequence of ((x, y, z), size, strength)
        At most `capacity(tree)`.
    even : bool
    driven : set of (number, index)
        Lamps, from 1, and which of their `sockets` have a driver, to which they are left.
    """
    _set(tree.nodes[LAMPS].outputs[0], float(len(lamps)))
    _set(tree.nodes[EVEN].outputs[0], float(even))
    for number, (position, *extent) in enumerate(lamps, 1):
        for index, (socket, value) in enumerate(zip(sockets(tree, number), (*position, *extent), strict=True)):
            if (number, index) not in driven:
                _set(socket, value)


def _set(socket, value):
    if not math.isclose(socket.default_value, value, rel_tol=1e-6, abs_tol=1e-9):
        socket.default_value = value


def _create():
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    for row, name in enumerate((EVEN, LAMPS), -1):
        _add(tree, output, "ShaderNodeValue", name, "NodeSocketFloat", row)
        tree.nodes[name].outputs[0].default_value = 0
    for number in range(1, MAX_LAMPS + 1):
        for kind in ("Lamp", "Extent"):
            _add(tree, output, "ShaderNodeCombineXYZ", f"{kind}{number}", "NodeSocketVector", number)
    return tree


def _add(tree, output, kind, name, socket_type, row):
    tree.interface.new_socket(name, in_out="OUTPUT", socket_type=socket_type)
    node = tree.nodes.new(kind)
    node.name = node.label = name
    node.location = (200 if name.startswith("Extent") else 0, -150 * row)
    tree.links.new(node.outputs[0], output.inputs[name])
