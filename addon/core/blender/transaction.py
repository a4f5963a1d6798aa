"""Changes to the open file that either succeed as a whole or leave it as it was."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

import bpy

from ..annotations import not_none

_Data = TypeVar("_Data", bound=bpy.types.ID)
_Ends = tuple[str, str, str, str]       # a link: node and identifier of the socket it comes from, and goes to
# a node: its properties, its custom properties, and the values of its sockets
_State = tuple[dict[str, Any], dict[str, Any], list[Any]]

_ID_KINDS = ("materials", "node_groups", "texts", "images", "meshes", "objects", "lights", "cameras", "worlds", "masks",
             "scenes")
_VIEWPORT_PROPERTIES = ("diffuse_color", "roughness", "metallic")
_NODE_PROPERTIES = ("name", "label", "location", "node_tree", "target", "is_active_output")


@contextmanager
def new_data_removed_on_error() -> Iterator[None]:
    """Remove the data-blocks that the block created if it raises. Older data-blocks are not touched."""
    before = {item.session_uid for item in _all()}
    try:
        yield
    except BaseException:
        bpy.data.batch_remove([item for item in _all() if item.session_uid not in before])
        raise


def _all() -> Iterator[bpy.types.ID]:
    for kind in _ID_KINDS:
        yield from getattr(bpy.data, kind)


@contextmanager
def restored_on_error(material: bpy.types.Material, names: Iterable[str]) -> Iterator[None]:
    """If the block raises, which must remove nothing that the material refers to, restore its nodes, links, viewport
    properties, and these of its settings."""
    viewport = {name: _plain(getattr(material, name)) for name in _VIEWPORT_PROPERTIES}
    bump, settings = material.cycles.use_bump_map_correction, material.measured_brdf
    stored = {name: getattr(settings, name) for name in names}
    tree = material.node_tree
    nodes = {node.as_pointer(): _state(node) for node in tree.nodes} if tree is not None else {}
    links = [_ends(link) for link in tree.links] if tree is not None else []
    try:
        yield
    except BaseException:
        _set_changed(material, viewport)
        _set_changed(settings, stored)
        material.cycles.use_bump_map_correction = bump
        if material.node_tree is not None:
            _restore(material.node_tree, nodes, links)
        raise


def _plain(value: Any) -> Any:
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _state(node: bpy.types.Node) -> _State:
    return ({name: _plain(getattr(node, name)) for name in _NODE_PROPERTIES if hasattr(node, name)},
            {key: value.to_dict() if hasattr(value, "to_dict") else value for key, value in node.items()},
            [_plain(socket.default_value) if hasattr(socket, "default_value") else None
             for socket in (*node.inputs, *node.outputs)])


def _restore(tree: bpy.types.NodeTree, nodes: Mapping[int, _State], links: Iterable[_Ends]) -> None:
    """Restore nodes, by their place in memory: the block may have given them other names."""
    for node in [node for node in tree.nodes if node.as_pointer() not in nodes]:
        tree.nodes.remove(node)
    for node in tree.nodes:
        properties, custom, values = nodes[node.as_pointer()]
        _set_changed(node, properties)
        for key in [*node.keys()]:
            del node[key]
        for key, value in custom.items():
            node[key] = value
        for socket, value in zip((*node.inputs, *node.outputs), values, strict=False):
            if value is not None:
                _set_changed(socket, {"default_value": value})
    existing = {_ends(link) for link in tree.links}
    for ends in links:
        if ends not in existing:
            from_node, from_socket, to_node, to_socket = ends
            tree.links.new(_socket(tree.nodes[from_node].outputs, from_socket),
                           _socket(tree.nodes[to_node].inputs, to_socket))


def _ends(link: bpy.types.NodeLink) -> _Ends:
    from_node, to_node = not_none(link.from_node), not_none(link.to_node)
    return from_node.name, link.from_socket.identifier, to_node.name, link.to_socket.identifier


def _socket(sockets: Iterable[bpy.types.NodeSocket], identifier: str) -> bpy.types.NodeSocket:
    return next(socket for socket in sockets if socket.identifier == identifier)


def _set_changed(owner: Any, values: Mapping[str, Any]) -> None:
    """Assign the values that differ: every assignment makes Blender and Cycles update the owner's users."""
    for name, value in values.items():
        if _plain(getattr(owner, name)) != value:
            with suppress(TypeError):           # an enum value of a damaged file cannot be assigned
                setattr(owner, name, value)


def find_by_session_uid(collection: Iterable[_Data], uid: int | None) -> _Data | None:
    """The data-block of a collection such as `bpy.data.materials` with this `session_uid`; None if it is gone."""
    return next((item for item in collection if item.session_uid == uid), None)
