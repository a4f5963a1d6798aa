"""Lamps that are instanced: by collection instances, geometry nodes, particles, or children of vertices and faces.

Only a search through all instances of a scene finds them. So the search runs only if something may instance a light,
and again only after a change of something that can. A wrong yes only costs the time of a search.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import bpy

from ..annotations import not_none
from . import drivers, lamp
from .changes import Changed, changed_objects
from .light_objects import get_light, light_objects

_Key = tuple[int, str, str]         # scene, view layer, and mode of the dependency graph
_LEADS_ON = {"OBJECT", "COLLECTION", "NODETREE", "PARTICLE"}       # to what instances lights, by one using the other


@dataclass
class _Search:
    key: _Key | None = None         # None before the first
    possible: bool = False          # whether something may instance a light,
    instancers: set[int] = field(default_factory=set)       # and what, by session_uid
    lamps: list[lamp.Lamp] = field(default_factory=list)
    moves: bool = False             # whether something that brings lamps can move by itself


_last = _Search()


def forget() -> None:
    global _last
    _last = _Search()


def lamps(depsgraph: bpy.types.Depsgraph, shining: Sequence[bpy.types.Object], changed: Changed) -> list[lamp.Lamp]:
    """The lamps that are instanced, without those in `shining`, the lights that are objects of the scene."""
    global _last
    key = depsgraph.scene.session_uid, depsgraph.view_layer.name, depsgraph.mode
    if _last.key != key or changed.structure:
        instancers = {item.session_uid for item in list_instancers()}
        has_set = not_none(depsgraph.scene).background_set is not None
        _last = _Search(key, has_set or len(instancers) > 0, instancers)
        if _last.possible:
            search(depsgraph, shining)
    elif _last.possible and changed.others:
        objects = changed_objects(depsgraph)
        if objects is None or any(item.type == "LIGHT" or item.session_uid in _last.instancers for item in objects):
            search(depsgraph, shining)
    return _last.lamps


def search(depsgraph: bpy.types.Depsgraph, shining: Sequence[bpy.types.Object]) -> None:
    """Search all instances for lights that are not in `shining`."""
    known = {item.session_uid for item in shining}
    instanced: list[lamp.Lamp] = []
    parents: set[Any] = set()
    for instance in depsgraph.object_instances:
        item = not_none(instance.object)
        if item.type != "LIGHT" or (not instance.is_instance and item.original.session_uid in known):
            continue
        light = get_light(item)
        if light.energy > 0:
            instanced.append(lamp.from_light(light, instance.matrix_world))
        parents.add(instance.parent.original if instance.is_instance else item.original)
    _last.lamps, _last.moves = instanced, any(map(drivers.can_move, parents))


def can_move() -> bool:
    """Whether the last search found lamps that can move by themselves."""
    return _last.moves


def list_instancers() -> Iterator[bpy.types.Object]:
    """The objects that may instance lights: what uses a light object, or uses what does, and makes instances; and
    those below which a light is."""
    lights: list[bpy.types.ID] = [*light_objects()]
    users = bpy.data.user_map(key_types=_LEADS_ON, value_types=_LEADS_ON) if lights else {}
    waiting, passed = [*lights], set(lights)
    while waiting:
        further = users.get(waiting.pop(), set()) - passed
        passed |= further
        waiting += further
    for item in passed:
        if isinstance(item, bpy.types.Object) and (
                item.instance_type == "COLLECTION" or len(item.particle_systems) > 0
                or any(modifier.type == "NODES" for modifier in item.modifiers)):
            yield item
    for light in light_objects():
        above = light.parent
        while above is not None:
            if above.instance_type in {"VERTS", "FACES"}:
                yield above
            above = above.parent
