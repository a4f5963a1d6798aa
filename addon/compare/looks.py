"""Renders of materials that were asked for in this session, kept for as long as material and choice stay the same."""

import hashlib
from typing import Any, NamedTuple

import bpy

from ...fitter.arrays import SingleArray
from ..core import look, node_group
from ..core.annotations import present
from ..work import icons
from ..work.recent import Recent
from . import settings as comparison

_pictures: "Recent[Key, SingleArray]" = Recent(12)


class Key(NamedTuple):
    """What a render shows.

    Attributes
    ----------
    material : int
        `session_uid`.
    state : str
        Identifies what the material looks like.
    shape, lighting : str
        Of `comparison.SHAPES` and `comparison.LIGHTINGS`.
    world : str
        Identifies the world that gives the light; empty where it is not the scene's.
    size : int
        Pixels on a side.
    """

    material: int
    state: str
    shape: str
    lighting: str
    world: str
    size: int


def key(scene: bpy.types.Scene, material: bpy.types.Material, size: int) -> Key:
    """What a render of a material shows with the present choices of a scene."""
    chosen = comparison.of(scene)
    shape, lighting = chosen.shape or look.BALL, chosen.lighting or look.STUDIO    # empty where damaged
    world = scene.world if lighting == look.WORLD else None
    view = scene.view_settings
    seen = "" if world is None else f"{_digest(world.node_tree)} {view.view_transform} {view.exposure:g}"
    return Key(material.session_uid, _digest(material.node_tree), shape, lighting, seen, size)


def store(found: Key, picture: SingleArray) -> None:
    """Keep a picture: (size, size, 4)."""
    _pictures[found] = picture


def known(found: Key) -> SingleArray | None:
    """The picture, if it has been rendered and is kept."""
    return _pictures.get(found)


def icon(name: str, found: tuple[Key, ...], picture: SingleArray) -> int:
    """The icon of a kept picture, or of one that was made of several."""
    return icons.at_once((name, *found), lambda: picture)


def _digest(tree: bpy.types.NodeTree | None) -> str:
    """Identifies what a node tree computes; empty for none."""
    return hashlib.blake2b(repr(_state(tree)).encode(), digest_size=16).hexdigest() if tree is not None else ""


def _state(tree: bpy.types.NodeTree) -> Any:
    if node_group.script_node(tree) is not None:
        return hash((node_group.version(tree), node_group.kept_fit(tree) or node_group.source(tree)))
    nodes = [(node.name, node.bl_idname, node.mute, _settings(node), _values(node)) for node in tree.nodes]
    links = sorted((present(link.from_node).name, link.from_socket.identifier, present(link.to_node).name,
                    link.to_socket.identifier) for link in tree.links)
    return nodes, links


def _settings(node: bpy.types.Node) -> Any:
    """The properties of a node that are its own, not those that every node has."""
    common = bpy.types.Node.bl_rna.properties.keys()
    own = [each.identifier for each in node.bl_rna.properties if each.identifier not in common]
    return [(name, _plain(getattr(node, name))) for name in own]


def _values(node: bpy.types.Node) -> list[Any]:
    return [_plain(getattr(socket, "default_value", None)) for socket in (*node.inputs, *node.outputs)]


def _plain(value: Any) -> Any:
    """A property as plain values: of node groups what they compute, of other data-blocks which it is."""
    if isinstance(value, bpy.types.NodeTree):
        return _state(value)
    if isinstance(value, bpy.types.ID):
        return value.session_uid
    if isinstance(value, bpy.types.Node):
        return value.name
    if isinstance(value, bpy.types.bpy_struct):         # a colour ramp, a curve
        names = [each.identifier for each in value.bl_rna.properties if each.identifier != "rna_type"]
        return [(name, _plain(getattr(value, name))) for name in names]
    if hasattr(value, "__len__") and not isinstance(value, str):
        return [_plain(each) for each in value]
    return value


def unregister() -> None:
    """Forget all pictures."""
    _pictures.clear()
