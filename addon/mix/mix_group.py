"""The node group of a mix of two measured materials, which holds the groups of both.

Both have their share. Where Cycles renders with OSL and has no room for the closures of both (osl/mix.osl), one of them
renders each sample, as often as its share is: the other is given a strength of 0, and returns at once. The materials
that are mixed may be mixes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple, cast

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...fitter.cycles.bake import mix_source
from ..core import lamps
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.blender.node_trees import add_input
from ..core.blender.transaction import new_data_removed_on_error
from ..core.shading import node_group

FACTOR_INPUT = "Factor"
MOST = 8                                # measured BRDFs in a mix: Cycles takes seconds to prepare the shaders of 32
_SCRIPT = "Measured BRDF Mix Shader"
_HALVES = "First", "Second"         # nodes; and custom properties of the group, which hold the materials
_MIXED_COUNT = "mixed"                  # custom property of the group: how many measured BRDFs it holds
_LOOKS = "Tint", "Strength", "Rotation", node_group.SCALE_INPUT  # inputs that change the look by their values
_ERROR_PROPERTIES = node_group.NODES_ERROR, node_group.NODES_WORST, node_group.EEVEE_ERROR, node_group.EEVEE_WORST


def create(first: bpy.types.Material, first_node: bpy.types.Node, second: bpy.types.Material,
           second_node: bpy.types.Node, factor: float) -> bpy.types.NodeTree:
    """Make a node group that mixes what two materials show: the nodes of their measured groups, or of mixes.

    Of the nodes' inputs it takes the factor of a mix, or its mask; the others are inputs of the new group. Raises
    ValueError if the mix would hold more than `MOST` measured BRDFs, CompileError if this Blender cannot compile its
    shader; the file then stays as it was.
    """
    first_tree, second_tree = not_none(first_node.node_tree), not_none(second_node.node_tree)
    held = count(first_tree) + count(second_tree)
    if held > MOST:
        raise ValueError(f"A mix of {first.name} and {second.name} would hold {held} measured materials, expected at "
                         f"most {MOST}: the time of a render grows with them")
    with new_data_removed_on_error():
        tree = bpy.data.node_groups.new(f"{first.name} + {second.name}", "ShaderNodeTree")
        for name, material in zip(_HALVES, (first, second), strict=True):
            tree[name] = material
        tree[_MIXED_COUNT] = held
        _fill(tree, first_tree, second_tree, factor)
        for name, node in zip(_HALVES, (first_node, second_node), strict=True):
            if FACTOR_INPUT in node.inputs:
                tree.nodes[name].inputs[FACTOR_INPUT].default_value = node.inputs[FACTOR_INPUT].default_value
                _copy_mask(node, tree.nodes[name])
        _remember_errors(tree)
    return tree


def is_mix(tree: bpy.types.NodeTree | None) -> bool:
    return tree is not None and tree.get(_MIXED_COUNT) is not None and all(name in tree.nodes for name in _HALVES)


def count(tree: bpy.types.NodeTree) -> int:
    """How many measured BRDFs a group holds."""
    return int(tree.get(_MIXED_COUNT, 1))


def left_behind(node: bpy.types.Node) -> list[str]:
    """The inputs of a material's node that a mix does not take over, and that were connected or changed."""
    tree = not_none(node.node_tree)
    defaults = {item.name: item.default_value for item in _sockets(tree)
                if item.in_out == "INPUT" and item.name in _LOOKS}
    return [socket.name for socket in node.inputs if (socket.is_linked and not _mask(socket))
            or (socket.name in defaults and not np.array_equal(socket.default_value, defaults[socket.name]))]


def _mask(socket: bpy.types.NodeSocket) -> bpy.types.NodeLink | None:
    """The link from an image to the factor of a mix, if the UV map that is rendered places it; else None."""
    link = not_none(socket.links)[0] if socket.name == FACTOR_INPUT and socket.is_linked else None
    return link if link is not None and link.from_node.type == "TEX_IMAGE" and not link.from_node.inputs[0].is_linked \
        else None


def _copy_mask(source: bpy.types.Node, node: bpy.types.Node) -> None:
    """Connect to a mix's node inside of a group what is the mask of another, outside of it."""
    link = _mask(source.inputs[FACTOR_INPUT])
    if link is not None:
        tree = cast(bpy.types.NodeTree, node.id_data)
        image, copied = link.from_node, tree.nodes.new("ShaderNodeTexImage")
        copied.location = node.location.x - 300, node.location.y - 300
        for name in ("image", "interpolation", "extension", "projection"):
            setattr(copied, name, getattr(image, name))
        tree.links.new(copied.outputs[link.from_socket.name], node.inputs[FACTOR_INPUT])


def parts(tree: bpy.types.NodeTree) -> tuple[bpy.types.Material | None, bpy.types.Material | None]:
    """The materials that a group mixes; None for one that has been deleted."""
    first, second = (tree.get(name) for name in _HALVES)
    return first, second


def nodes(node: bpy.types.Node) -> tuple[bpy.types.Node, bpy.types.Node]:
    """The nodes inside of a mix's that show its first and its second material."""
    first, second = (not_none(node.node_tree).nodes[name] for name in _HALVES)
    return first, second


class Layer(NamedTuple):
    """A material of a mix; None if it has been deleted. The share is a socket of a node, None of the undermost."""

    material: bpy.types.Material | None
    share: bpy.types.NodeSocket | None


def layers(node: bpy.types.Node) -> list[Layer]:
    """The materials that the node of a mix lays upon one another, the uppermost first. A mix on top is one layer."""
    tree, (base, _) = not_none(node.node_tree), nodes(node)
    first, second = parts(tree)
    below = layers(base) if is_mix(base.node_tree) else [Layer(first, None)]
    return [Layer(second, node.inputs[FACTOR_INPUT]), *below]


def keep(*followed: bpy.types.Material) -> None:
    """Have materials that mixes follow saved with the file, though nothing else uses them.

    Windows of Blender (5.2) forget the user that a group's custom property is, after a second or so, and a material
    without users is not saved.
    """
    for material in followed:
        if material.library is None:
            material.use_fake_user = True


@persistent
def _keep_all(*_: object) -> None:
    """Before a file is saved: Blender appends materials without their fake users."""
    for tree in bpy.data.node_groups:
        if is_mix(tree) and tree.library is None:
            keep(*(material for material in parts(tree) if material is not None))


handlers = {"save_pre": _keep_all}


@contextmanager
def following(material: bpy.types.Material, before: bpy.types.NodeTree | None,
              after: bpy.types.NodeTree) -> Iterator[None]:
    """Give mixes of a material its new group in the place of the former one; if the block raises, the former again."""
    changed: list[bpy.types.Node] = []
    try:
        for tree in bpy.data.node_groups:
            if before is None or before == after or not is_mix(tree) or not tree.is_editable:
                continue
            for name in _HALVES:
                if tree.get(name) == material and tree.nodes[name].node_tree == before:
                    changed.append(tree.nodes[name])
                    tree.nodes[name].node_tree = after
        _renew(changed)
        yield
        waiting = [cast(bpy.types.NodeTree, node.id_data) for node in changed]
        for mix in waiting:             # and mixes of mixes
            _update_inputs(mix)
            holders = [cast(bpy.types.NodeTree, node.id_data) for node in _group_users(mix)]
            waiting += filter(is_mix, holders)
    except BaseException:
        for node in changed:
            node.node_tree = before
        _renew(changed)
        raise


def _renew(changed: list[bpy.types.Node]) -> None:
    for node in changed:
        mix = cast(bpy.types.NodeTree, node.id_data)
        _connect(mix)
        _remember_errors(mix)


def _update_inputs(mix: bpy.types.NodeTree) -> None:
    """Give a mix the inputs that only its new groups have."""
    sockets = not_none(mix.interface)
    own = {item.name: item for item in _sockets(mix) if item.in_out == "INPUT"}
    offered = {item.name: item for name in reversed(_HALVES) for item in _sockets(not_none(mix.nodes[name].node_tree))
               if item.in_out == "INPUT"}
    for name in offered.keys() - own.keys() - {FACTOR_INPUT}:
        _copy_socket(sockets, offered[name])
    _connect(mix)


def _group_users(tree: bpy.types.NodeTree) -> Iterator[bpy.types.Node]:
    """The nodes of this file's materials and groups that hold a group."""
    trees = [*(item.node_tree for item in bpy.data.materials), *bpy.data.node_groups]
    for each in trees:
        if each is not None and each.is_editable:
            yield from (node for node in each.nodes if node.type == "GROUP" and node.node_tree == tree)


def _fill(tree: bpy.types.NodeTree, first: bpy.types.NodeTree, second: bpy.types.NodeTree, factor: float) -> None:
    sockets = not_none(tree.interface)
    sockets.new_socket(node_group.CYCLES_OUTPUT, in_out="OUTPUT", socket_type="NodeSocketShader").description = (
        "The surface for Cycles")
    sockets.new_socket(node_group.EEVEE_OUTPUT, in_out="OUTPUT", socket_type="NodeSocketShader").description = (
        "The surface for EEVEE")
    add_input(tree, FACTOR_INPUT, "Float", f"Share of {second.name}; connect a mask to it", subtype="FACTOR",
              default_value=factor, min_value=0, max_value=1)
    seen = {FACTOR_INPUT}
    for part in (first, second):
        for item in _sockets(part):
            if item.in_out == "INPUT" and item.name not in seen:
                seen.add(item.name)
                _copy_socket(sockets, item)
    script, source, output = (tree.nodes.new(f"{kind}") for kind in ("ShaderNodeScript", "NodeGroupInput",
                                                                     "NodeGroupOutput"))
    script.name = script.label = _SCRIPT
    source.location, script.location, output.location = (-900, 0), (-600, 250), (900, 0)
    script.mode = "INTERNAL"
    if not osl_support.reason_unavailable():               # else it stays empty
        node_group.compile_node(script, mix_source())
    share, rest = tree.nodes.new("ShaderNodeClamp"), _math(tree, "SUBTRACT", -600, -20)
    share.location, rest.inputs[0].default_value = (-600, -300), 1
    tree.links.new(source.outputs[FACTOR_INPUT], share.inputs["Value"])
    tree.links.new(share.outputs[0], rest.inputs[1])
    for number, (name, part, share_of) in enumerate(((_HALVES[0], first, rest.outputs[0]),
                                                     (_HALVES[1], second, share.outputs[0]))):
        y = -300 * number
        picked = tree.nodes.new("ShaderNodeMix")        # of floats: 0, the share, without the script node
        picked.location, picked.inputs[0].default_value = (-350, y), 0
        strength = _math(tree, "MULTIPLY", -150, y)
        node = tree.nodes.new("ShaderNodeGroup")
        node.name, node.node_tree, node.location, node.width = name, part, (50, y), 200
        tree.links.new(share_of, picked.inputs[2])
        tree.links.new(picked.outputs[0], strength.inputs[1])
        tree.links.new(source.outputs["Strength"], strength.inputs[0])
        if script.outputs:
            tree.links.new(script.outputs["Active"], picked.inputs[0])
            tree.links.new(script.outputs[name], picked.inputs[3])
        strength.name = f"{name} Strength"
    if script.outputs:
        tree.links.new(source.outputs[FACTOR_INPUT], script.inputs["Factor"])
        script.inputs["Mixed"].default_value = tree[_MIXED_COUNT]
        scene_lamps = tree.nodes.new("ShaderNodeGroup")
        scene_lamps.node_tree = lamps.node_tree()
        scene_lamps.location, scene_lamps.hide = (-900, 250), True
        tree.links.new(scene_lamps.outputs["Frugal"], script.inputs["Frugal"])
    for number, name in enumerate((node_group.CYCLES_OUTPUT, node_group.EEVEE_OUTPUT)):
        both = tree.nodes.new("ShaderNodeAddShader")
        both.name, both.location = name, (500, -200 * number)
        tree.links.new(both.outputs[0], output.inputs[name])
    _connect(tree)


def _connect(tree: bpy.types.NodeTree) -> None:
    """Connect the groups of both materials: links to sockets that a new group has not are gone with the former one."""
    source = next(node for node in tree.nodes if node.type == "GROUP_INPUT")
    for number, name in enumerate(_HALVES):
        node = tree.nodes[name]
        for socket in node.inputs:
            given = (tree.nodes[f"{name} Strength"].outputs[0] if socket.name == "Strength"
                     else source.outputs.get(socket.name) if socket.name != FACTOR_INPUT else None)
            if given is not None and not socket.is_linked:
                tree.links.new(given, socket)
        for output in (node_group.CYCLES_OUTPUT, node_group.EEVEE_OUTPUT):
            if output in node.outputs and not tree.nodes[output].inputs[number].is_linked:
                tree.links.new(node.outputs[output], tree.nodes[output].inputs[number])


def _sockets(tree: bpy.types.NodeTree) -> list[bpy.types.NodeTreeInterfaceSocket]:
    return [cast(bpy.types.NodeTreeInterfaceSocket, item) for item in not_none(tree.interface).items_tree
            if item.item_type == "SOCKET"]


def _copy_socket(sockets: bpy.types.NodeTreeInterface, item: bpy.types.NodeTreeInterfaceSocket) -> None:
    new = sockets.new_socket(item.name, in_out="INPUT", socket_type=item.socket_type)
    new.description = item.description
    for name in ("subtype", "default_value", "min_value", "max_value", "hide_value"):
        if hasattr(item, name):
            setattr(new, name, getattr(item, name))


def _math(tree: bpy.types.NodeTree, operation: str, x: float, y: float) -> bpy.types.Node:
    node = tree.nodes.new("ShaderNodeMath")
    node.operation, node.location = operation, (x, y)
    return node


def _remember_errors(tree: bpy.types.NodeTree) -> None:
    trees = [not_none(tree.nodes[name].node_tree) for name in _HALVES]
    for name in _ERROR_PROPERTIES:
        tree[name] = max(each.get(name, 0.0) for each in trees)         # a group whose file is lost has none
