"""Lamps that are instanced: by collection instances, geometry nodes, particles, or children of vertices and faces.

Only a search through all instances of a scene finds them. So the search runs only if something may instance a light,
and again only after a change of something that can. A wrong yes only costs the time of a search.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import bpy

from ..annotations import not_none
from . import drivers, lamp
from .changes import Changed, changed_objects
from .light_objects import get_light, light_objects

_Key = tuple[int, str, str]         # scene, view layer, and mode of the dependency graph


@dataclass
class _Search:
    """The last search: where it was made (None before the first), whether something may instance a light, and the lamps
    found.
    """

    key: _Key | None = None
    possible: bool = False
    lamps: list[lamp.Lamp] = field(default_factory=list)
    parents: dict[int, bool] = field(default_factory=dict)  # by session_uid of what brings lamps: whether it can move
    holders: dict[int, bool] = field(default_factory=dict)  # by session_uid of a collection: whether it holds lights


_last = _Search()


def forget() -> None:
    """Forget everything, so that the next call searches again."""
    global _last
    _last = _Search()


def lamps(depsgraph: bpy.types.Depsgraph, shining: Sequence[bpy.types.Object], changed: Changed) -> list[lamp.Lamp]:
    """The lamps that are instanced, without those in `shining`, the lights that are objects of the scene."""
    global _last
    key = depsgraph.scene.session_uid, depsgraph.view_layer.name, depsgraph.mode
    if _last.key != key or changed.structure:
        _last = _Search(key)
        _last.possible = may_be_instanced(not_none(depsgraph.scene), shining)
        if _last.possible:
            search(depsgraph, shining)
    elif _last.possible and changed.others:
        objects = changed_objects(depsgraph)
        if objects is None or any(_may_move_a_lamp(*change) for change in objects):
            search(depsgraph, shining)
    return _last.lamps


def search(depsgraph: bpy.types.Depsgraph, shining: Sequence[bpy.types.Object]) -> None:
    """Search all instances for lights that are not in `shining`."""
    known = {item.session_uid for item in shining}
    instanced: list[lamp.Lamp] = []
    parents: dict[int, bool] = {}
    for instance in depsgraph.object_instances:
        item = not_none(instance.object)
        if item.type != "LIGHT" or (not instance.is_instance and item.original.session_uid in known):
            continue
        light = get_light(item)
        if light.energy > 0:
            instanced.append(lamp.from_light(light, instance.matrix_world))
        parent = instance.parent.original if instance.is_instance else item.original
        parents[parent.session_uid] = parents.get(parent.session_uid) or drivers.can_move(parent)
    _last.lamps, _last.parents = instanced, parents


def are_possible() -> bool:
    """Whether something may instance a light, as of the last search."""
    return _last.possible


def can_move() -> bool:
    """Whether the last search found lamps that can move by themselves."""
    return any(_last.parents.values())


def may_be_instanced(scene: bpy.types.Scene, shining: Sequence[bpy.types.Object]) -> bool:
    """Whether something may instance a light; `shining` are the lights that are objects of the scene."""
    if scene.background_set is not None or any(
            settings.render_type in {"OBJECT", "COLLECTION"} for settings in bpy.data.particles):
        return True
    lights = light_objects()
    # nodes are users of an object, and so is each collection that holds it
    if _has_geometry_nodes() and (len(lights) > len(shining) or any(item.users > 1 for item in lights)):
        return True
    return any(map(_is_child_of_instancer, lights)) or any(map(holds_lights, _instanced_collections()))


def holds_lights(collection: bpy.types.Collection) -> bool:
    """Whether instances of a collection may contain lights."""
    key, known = collection.session_uid, _last.holders
    if key not in known:
        known[key] = False                  # ends the recursion where collections instance one another
        nodes = _has_geometry_nodes()
        known[key] = any(item.type == "LIGHT" or _instances_lights(item) or (nodes and _makes_instances(item))
                         for item in collection.all_objects)
    return known[key]


def _instances_lights(item: bpy.types.Object) -> bool:
    return (item.instance_type == "COLLECTION" and item.instance_collection is not None
            and holds_lights(item.instance_collection))


def _may_move_a_lamp(item: bpy.types.Object, is_geometry: bool) -> bool:
    """Whether the change of an object, or of its geometry, can have moved an instanced lamp."""
    if item.type == "LIGHT" or _instances_lights(item) or item.instance_type in {"VERTS", "FACES"}:
        return True
    return _makes_instances(item) and (is_geometry or item.session_uid in _last.parents)


def _makes_instances(item: bpy.types.Object) -> bool:
    return len(item.particle_systems) > 0 or any(modifier.type == "NODES" for modifier in item.modifiers)


def _is_child_of_instancer(item: bpy.types.Object) -> bool:
    while item.parent is not None:
        item = item.parent
        if item.instance_type in {"VERTS", "FACES"}:
            return True
    return False


def _instanced_collections() -> list[bpy.types.Collection]:
    """Collections with other users than the collections that contain them."""
    holders = [*bpy.data.collections, *(scene.collection for scene in bpy.data.scenes)]
    parents = Counter(child.session_uid for holder in holders for child in holder.children)
    return [item for item in bpy.data.collections if item.users - item.use_fake_user > parents[item.session_uid]]


def _has_geometry_nodes() -> bool:
    return any(tree.bl_idname == "GeometryNodeTree" for tree in bpy.data.node_groups)
