"""Whether the light besides that of the lamps is even: a world of one colour or none, and no material that emits."""

import bpy

_emits_by_tree: dict[int, bool] = {}        # by session_uid of a node tree; cleared when materials are edited


def light_is_even(world: bpy.types.World | None) -> bool:
    """Whether no light but that of the lamps is uneven, with a world (evaluated).

    Any emitting material in use counts, wherever it is used. Light that is wrongly taken for uneven only adds noise.
    """
    return _is_even(world) and not any(
        _emits(material.node_tree) for material in bpy.data.materials if material.users > material.use_fake_user)


def forget() -> None:
    """Forget which materials emit."""
    _emits_by_tree.clear()


def _is_even(world: bpy.types.World | None) -> bool:
    if world is None or world.node_tree is None:
        return True
    return all(link.to_node.type == "OUTPUT_WORLD" and link.to_socket.name == "Surface"
               and link.from_node.type == "BACKGROUND" for link in world.node_tree.links)


def _emits(tree: bpy.types.NodeTree | None) -> bool:
    """Whether nodes may emit light."""
    if tree is None:
        return False
    key = tree.session_uid
    if key not in _emits_by_tree:
        _emits_by_tree[key] = any(map(_node_emits, tree.nodes))
    return _emits_by_tree[key]


def _node_emits(node: bpy.types.Node) -> bool:
    strength = node.inputs.get("Emission Strength")
    return (node.type == "EMISSION" or (strength is not None and (strength.is_linked or strength.default_value > 0))
            or (node.type == "GROUP" and _emits(node.node_tree)))
