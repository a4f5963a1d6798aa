"""The scene's lamps, of which the measured materials know.

How many there are is written into node groups that the materials have in them (`group`), which makes Cycles compile
them again; where they are, how large and how strong, into a carrier of each scene (`carrier`), which costs nothing.
Those of other files that are appended or linked are kept up to date too, linked ones in memory only. `drivers`
follow lamps that move by themselves, also in a render job; handlers write the rest, and do nothing in the thread of a
render job unless the interface is locked: Blender may be reading what they would write. docs/rendering.md says what
works when, and what a lamp that is not known costs: noise.
"""

import threading
from collections import Counter
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..annotations import not_none
from ..blender import followers, shared_groups
from ..blender.device import renders_on_gpu
from ..registration import add_handlers, remove_handlers
from . import carrier, changes, drivers, group, instances, lamp, light_objects
from .changes import Changed
from .group import node_tree
from .lamp import Lamp
from .light_objects import get_light, is_animated
from .world_lights import bright_spots

__all__ = ["is_main_thread_free", "list_lamps", "node_tree", "register", "sky_moves", "unregister", "update"]

_Listed = list[tuple[Lamp, bpy.types.Object | None]]
"""Lamps, each with its evaluated object; None for instances and bright spots."""

_RETRY_INTERVAL = 0.5       # s, between two attempts of a postponed update
_object_order: dict[int, list[int | None]] = {}     # by carrier: the session_uid of the object of each lamp
_is_due = threading.Event()                         # an update was postponed, or the data have been replaced


def list_lamps(depsgraph: bpy.types.Depsgraph) -> list[Lamp]:
    """The lamps of an evaluated scene that give light, bright places of the world too, by rank; at most `MAX_LAMPS`."""
    _forget()
    shining = [known for known, _ in _lamps(depsgraph, changes.EVERYTHING) if known.strength > 0]
    return sorted(shining, key=lambda known: known.rank)[:group.MAX_LAMPS]


def update(depsgraph: bpy.types.Depsgraph) -> None:
    """Have all measured materials know the lamps of an evaluated scene; during a render job, once it has ended."""
    if not _may_write(not_none(depsgraph.scene)):
        _postpone()
        return
    _is_due.clear()
    _forget()
    _write_changes(depsgraph, changes.EVERYTHING)


def sky_moves(world: bpy.types.World | None) -> bool:
    return (world is not None and world.node_tree is not None and is_animated(world.node_tree)
            and len(bright_spots(world)) > 0)


def _write_changes(depsgraph: bpy.types.Depsgraph, changed: Changed) -> None:
    is_free = is_main_thread_free()
    if changed.structure:
        light_objects.forget()
        if is_free:
            group.merge()
            shared_groups.merge()
    trees = group.trees() if any(changed) else []
    if not trees:
        return
    scene = not_none(depsgraph.scene)
    readers = carrier.readers(trees) if changed.structure else set()
    own = carrier.scene_carrier(scene, make=is_free and len(readers) > 0)
    listed = sorted(_lamps(depsgraph, changed), key=lambda pair: pair[0].rank)[:max(map(group.capacity, trees))]
    for each in [*([own] if own is not None else []), *carrier.linked_carriers()]:
        _write(each, listed, not_none(depsgraph.view_layer))
    if own is not None and changed.structure:
        carrier.point(scene, own, readers)
        if is_free:
            carrier.remove_unused()
    for tree in trees:
        count = len(listed) if own is None else carrier.most_lamps()
        group.store(tree, min(count, group.capacity(tree)), renders_on_gpu(scene))


def _lamps(depsgraph: bpy.types.Depsgraph, changed: Changed) -> _Listed:
    shining = light_objects.shining(not_none(depsgraph.view_layer))
    lights = [item.evaluated_get(depsgraph) for item in shining]
    # an animated lamp stays listed while it is dark: it may be lit at another frame
    listed: _Listed = [(lamp.from_light(light, item.matrix_world), item) for item in lights
                       if (light := get_light(item)).energy > 0 or is_animated(not_none(light.original))]
    listed += [(known, None) for known in instances.lamps(depsgraph, shining, changed)]
    listed += [(Lamp(spot.direction, -spot.radius, spot.irradiance), None)
               for spot in bright_spots(depsgraph.scene_eval.world) if spot.irradiance > 0]
    return listed


def _write(held: bpy.types.Texture, listed: _Listed, layer: bpy.types.ViewLayer) -> None:
    names = Counter(item.name for _, item in listed if item is not None)
    # drivers cannot tell a local object from a linked one of the same name
    wanted = {_identity(item): drivers.driver_expressions(not_none(item.original), layer) for _, item in listed
              if item is not None and names[item.name] == 1}
    if any(wanted.values()):
        listed = _keep_order(_object_order.get(held.session_uid, []), listed)
    _object_order[held.session_uid] = [_identity(item) for _, item in listed]
    sources = {(number, index): (expression, item) for number, (_, item) in enumerate(listed, 1) if item is not None
               for index, expression in wanted.get(_identity(item), {}).items()}
    carrier.reserve(held, len(listed))
    driven = drivers.wire(held, sources)
    carrier.store(held, [known for known, _ in listed], driven)


def _keep_order(before: list[int | None], listed: _Listed) -> _Listed:
    """The lamps in the order of the last write, if they are the same ones: exchanging drivers because one is now
    brighter than another would make Blender rebuild its relations."""
    if Counter(before) != Counter(_identity(item) for _, item in listed):
        return listed
    others = iter([pair for pair in listed if pair[1] is None])
    objects = {_identity(pair[1]): pair for pair in listed}
    return [next(others) if identity is None else objects[identity] for identity in before]


def _identity(item: bpy.types.Object | None) -> int | None:
    return None if item is None else item.original.session_uid


def _forget() -> None:
    light_objects.forget()
    instances.forget()


def _may_write(scene: bpy.types.Scene) -> bool:
    return bool(scene.render.use_lock_interface) or is_main_thread_free()


def is_main_thread_free() -> bool:
    """Whether this may change the file: no render job reads it."""
    return threading.current_thread() is threading.main_thread() and not bpy.app.is_job_running("RENDER")


@persistent
def _on_evaluation(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if not _may_write(scene):
        _postpone()
        return
    if _is_due.is_set():
        update(depsgraph)
    else:
        _write_changes(depsgraph, changes.changes(depsgraph))


def _postpone() -> None:
    _is_due.set()
    if threading.current_thread() is threading.main_thread() and not bpy.app.timers.is_registered(_retry):
        bpy.app.timers.register(_retry, first_interval=_RETRY_INTERVAL, persistent=True)


def _retry() -> float | None:
    """Make a postponed update, once no render runs."""
    scene = not_none(bpy.context.scene)
    if not _may_write(scene):
        return _RETRY_INTERVAL
    if _is_due.is_set():
        update(bpy.context.evaluated_depsgraph_get())
    return None


def _on_new_groups(depsgraph: bpy.types.Depsgraph) -> None:
    update(depsgraph)


@persistent
def _on_data_replaced(*_: Any) -> None:
    """After undo, redo and loading, all references to Blender's data are invalid."""
    _forget()
    _object_order.clear()
    _is_due.set()


_LAMP_HANDLERS = {"depsgraph_update_post": _on_evaluation, "frame_change_post": _on_evaluation,
                  "undo_pre": _on_data_replaced, "undo_post": _on_data_replaced, "redo_pre": _on_data_replaced,
                  "redo_post": _on_data_replaced, "load_pre": _on_data_replaced, "load_post": _on_data_replaced}


def register() -> None:
    followers.followers.append(_on_new_groups)
    add_handlers(_LAMP_HANDLERS)


def unregister() -> None:
    if bpy.app.timers.is_registered(_retry):
        bpy.app.timers.unregister(_retry)
    remove_handlers(_LAMP_HANDLERS)
    if _on_new_groups in followers.followers:
        followers.followers.remove(_on_new_groups)
    _on_data_replaced()
