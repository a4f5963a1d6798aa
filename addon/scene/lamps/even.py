"""Whether there is light besides that of the lamps, and it is even: a world of one colour, and nothing that shines."""

import bpy

_gives_light = {}           # by node tree, until one is edited


def light_is_even(world):
    """Whether it is, under a world (evaluated). Any material in use that shines counts, wherever it is used: where
    light is taken for uneven, that costs noise at most."""
    return _is_even(world) and not any(
        _shines(material.node_tree) for material in bpy.data.materials if material.users > material.use_fake_user)


def forget():
    """Look at the materials anew."""
    _gives_light.clear()


def _is_even(world):
    if world is None:
        return False
    if world.node_tree is None:
        return max(world.color) > 0
    links = world.node_tree.links
    return len(links) > 0 and all(
        link.to_node.type == "OUTPUT_WORLD" and link.to_socket.name == "Surface" and link.from_node.type == "BACKGROUND"
        and link.from_node.inputs["Strength"].default_value * max(link.from_node.inputs["Color"].default_value[:3]) > 0
        for link in links)


def _shines(tree):
    """Whether nodes may give light; None for no nodes."""
    if tree is None:
        return False
    key = tree.session_uid
    if key not in _gives_light:
        _gives_light[key] = any(map(_node_shines, tree.nodes))
    return _gives_light[key]


def _node_shines(node):
    strength = node.inputs.get("Emission Strength")
    return (node.type == "EMISSION" or (strength is not None and (strength.is_linked or strength.default_value > 0))
            or (node.type == "GROUP" and _shines(node.node_tree)))
