"""Changes to the open file that are either whole or not there."""

from contextlib import contextmanager, suppress

import bpy

_KINDS = ("materials", "node_groups", "texts", "images", "meshes", "objects", "lights", "cameras", "worlds", "scenes")


@contextmanager
def new_data_removed_on_error():
    """Remove the data-blocks that the block made if it raises; what was there before is not touched."""
    before = {item.session_uid for item in _all()}
    try:
        yield
    except BaseException:
        bpy.data.batch_remove([item for item in _all() if item.session_uid not in before])
        raise


def _all():
    for kind in _KINDS:
        yield from getattr(bpy.data, kind)


@contextmanager
def restored_on_error(material, names):
    """Give a material its nodes, links, looks and the settings of these names back if the block raises.

    Data-blocks that it refers to must not be removed inside the block.
    """
    before = {name: _plain(getattr(material, name)) for name in _LOOKS}
    bump, settings = material.cycles.use_bump_map_correction, material.measured_brdf
    stored = {name: getattr(settings, name) for name in names}
    tree = material.node_tree
    nodes = {node.name: _state(node) for node in tree.nodes} if tree is not None else {}
    links = [_ends(link) for link in tree.links] if tree is not None else []
    try:
        yield
    except BaseException:
        _set_changed(material, before)
        _set_changed(settings, stored)
        material.cycles.use_bump_map_correction = bump
        if material.node_tree is not None:
            _restore(material.node_tree, nodes, links)
        raise


_LOOKS = ("diffuse_color", "roughness", "metallic")
_NODE_PROPERTIES = ("label", "location", "node_tree", "target", "is_active_output")


def _plain(value):
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _state(node):
    """Properties of a node, and the values of its inputs."""
    return ({name: _plain(getattr(node, name)) for name in _NODE_PROPERTIES if hasattr(node, name)},
            [_plain(socket.default_value) if hasattr(socket, "default_value") else None for socket in node.inputs])


def _restore(tree, nodes, links):
    for node in [node for node in tree.nodes if node.name not in nodes]:
        tree.nodes.remove(node)
    for name, (properties, inputs) in nodes.items():
        node = tree.nodes[name]
        _set_changed(node, properties)
        for socket, value in zip(node.inputs, inputs, strict=False):
            if value is not None:
                _set_changed(socket, {"default_value": value})
    present = {_ends(link) for link in tree.links}
    for ends in links:
        if ends not in present:
            from_node, from_socket, to_node, to_socket = ends
            tree.links.new(_socket(tree.nodes[from_node].outputs, from_socket),
                           _socket(tree.nodes[to_node].inputs, to_socket))


def _ends(link):
    return link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier


def _socket(sockets, identifier):
    return next(socket for socket in sockets if socket.identifier == identifier)


def _set_changed(owner, values):
    """Assign what differs: an assignment makes Blender and Cycles take up anew what it is part of."""
    for name, value in values.items():
        if _plain(getattr(owner, name)) != value:
            with suppress(TypeError):           # a damaged file's choice, which cannot be made again
                setattr(owner, name, value)


def by_session_uid(collection, uid):
    """The data-block of `bpy.data.materials` or the like with this `session_uid`, or None if it is gone."""
    return next((item for item in collection if item.session_uid == uid), None)
