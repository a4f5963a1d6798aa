"""The scene's lamps, written into node groups that the measured materials read.

Appended and linked materials bring the groups of other files along. All groups of a file are kept up to date; linked
ones in memory only.

The shader puts a lobe at each lamp (`osl/lamp_lobes.h`). Lobes, mixture and sampled directions always sum to the
measured reflectance. So a lamp that is missing here, or is listed but not visible, costs noise only. The exception is a
lamp without a size, which no sampled direction can hit: until it is listed here, it shows the mixture's value.

Handlers write the list of lamps. Each write makes Cycles compile all measured materials again. So lamps that are edited
in a window are written when they rest, and before a render, another frame and a save; what is rendered meanwhile has
the former ones. Lamps that move by themselves have drivers (`drivers`), so that a render job follows them without a
write. A render job calls the handlers in a thread of its own, where they do nothing unless the interface
is locked: Blender may be reading what they would write. docs/rendering.md has a table of what works when.
"""

import threading
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy
from bpy.app.handlers import persistent

from .. import shared_groups
from ..annotations import not_none
from ..device import renders_on_gpu
from ..world_lights import bright_spots
from . import changes, drivers, group, instances, lamp, light_objects
from .changes import Changed
from .group import node_tree
from .lamp import Lamp
from .light_objects import light_of

__all__ = ["has_window", "in_scene", "is_main_thread_free", "node_tree", "register", "sky_moves", "store", "unregister",
           "update"]

_Listed = list[tuple[Lamp, bpy.types.Object | None]]
"""Lamps, each with its evaluated object; None for instances and bright spots."""

_RETRY_INTERVAL = 0.5       # s, between two attempts of a postponed update
_REST = 0.3                 # s, for which lamps have not changed when they are written
_object_order: dict[int, list[int | None]] = {}     # by group: the session_uid of the object of each lamp
_is_due = threading.Event()                         # an update was postponed, or the data have been replaced
_written: "_State | None" = None                    # of the last write


class _State(NamedTuple):
    """What was written, apart from the order of the lamps: the session_uid of each group, the driver expressions of
    each object and its name, by which drivers look it up, whether few closures fit, and the lamps."""

    trees: list[int]
    moving: dict[int | None, dict[int, str]]
    names: dict[int | None, str]
    frugal: bool
    lamps: list[Lamp]


def in_scene(depsgraph: bpy.types.Depsgraph) -> list[Lamp]:
    """The lamps of an evaluated scene that give light, as the shader takes them, by rank.

    At most as many as the shader of this version takes. Bright places of the world count as suns.
    """
    _forget()
    shining = [known for known, _ in _lamps(depsgraph, changes.EVERYTHING) if known.strength > 0]
    return sorted(shining, key=lambda known: known.rank)[:group.MAX_LAMPS]


def store(tree: bpy.types.NodeTree, lamps: Sequence[Lamp], frugal: bool = False) -> None:
    """Write lamps from `in_scene` into a group, and whether few closures fit, without drivers."""
    drivers.wire(tree, {})
    group.store(tree, lamps, frugal)
    _object_order.pop(tree.session_uid, None)


def update(depsgraph: bpy.types.Depsgraph) -> None:
    """Write the lamps of an evaluated scene into all lamp groups; during a render job, once it has ended."""
    if not _may_write(not_none(depsgraph.scene)):
        _postpone()
        return
    _is_due.clear()
    _stop_waiting()
    _forget()
    _update_groups(depsgraph, changes.EVERYTHING)


def sky_moves(world: bpy.types.World | None) -> bool:
    """Whether a world has bright places and its nodes are animated."""
    return (world is not None and world.node_tree is not None and drivers.is_animated(world.node_tree)
            and len(bright_spots(world)) > 0)


def _update_groups(depsgraph: bpy.types.Depsgraph, changed: Changed, at_rest: bool = False) -> None:
    """Write the lamps into all groups, now or, where only values have changed, when they rest."""
    global _written
    if changed.structure:
        light_objects.forget_layers()
        instances.forget_collections()
        if is_main_thread_free():
            group.merge()
            shared_groups.merge()
    trees = group.trees() if any(changed) else []
    if not trees:
        return
    layer = not_none(depsgraph.view_layer)
    ranked = sorted(_lamps(depsgraph, changed), key=lambda pair: pair[0].rank)
    moving = {_identity(item): drivers.wanted(not_none(item.original), layer) for _, item in ranked if item is not None}
    names = {_identity(item): item.name for _, item in ranked if item is not None}
    now = _State([tree.session_uid for tree in trees], moving, names, renders_on_gpu(not_none(depsgraph.scene)),
                 [known for known, _ in ranked])
    before = _written
    if at_rest and before and now[:-1] == before[:-1] and len(now.lamps) == len(before.lamps):
        if now.lamps != before.lamps or is_waiting():
            _stop_waiting()
            bpy.app.timers.register(_write_at_rest, first_interval=_REST, persistent=True)
        return
    _written = now
    for tree in trees:
        _write(tree, ranked[:group.capacity(tree)], now)


def _lamps(depsgraph: bpy.types.Depsgraph, changed: Changed) -> _Listed:
    shining = light_objects.shining(not_none(depsgraph.view_layer))
    lights = [item.evaluated_get(depsgraph) for item in shining]
    # an animated lamp stays listed while it is dark: it may be lit at another frame
    listed: _Listed = [(lamp.of(light, item.matrix_world), item) for item in lights
                       if (light := light_of(item)).energy > 0 or drivers.is_animated(not_none(light.original))]
    listed += [(known, None) for known in instances.lamps(depsgraph, shining, changed)]
    listed += [(Lamp(spot.direction, -spot.radius, spot.irradiance), None)
               for spot in bright_spots(depsgraph.scene_eval.world) if spot.irradiance > 0]
    return listed


def _write(tree: bpy.types.NodeTree, listed: _Listed, now: _State) -> None:
    """Write lamps into a group, with drivers for those that need them."""
    count = Counter(now.names.values())
    # drivers cannot tell a local object from a linked one of the same name
    wanted = {_identity(item): now.moving[_identity(item)] for _, item in listed
              if item is not None and count[item.name] == 1}
    if any(wanted.values()):
        listed = _in_order_of(_object_order.get(tree.session_uid, []), listed)
    _object_order[tree.session_uid] = [_identity(item) for _, item in listed]
    sources = {(number, index): (expression, item) for number, (_, item) in enumerate(listed, 1) if item is not None
               for index, expression in wanted.get(_identity(item), {}).items()}
    driven = drivers.wire(tree, sources)
    group.store(tree, [known for known, _ in listed], now.frugal, driven)


def _in_order_of(before: list[int | None], listed: _Listed) -> _Listed:
    """The lamps in the order of the last write, if they are the same ones.

    Exchanging drivers because one lamp is now brighter than another would make Blender rebuild its relations.
    """
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
    """Whether no render can be reading what would be written now."""
    if scene.render.use_lock_interface:
        return True
    return is_main_thread_free()


def is_main_thread_free() -> bool:
    """Whether this may change the file: no render job reads it."""
    return threading.current_thread() is threading.main_thread() and not bpy.app.is_job_running("RENDER")


@persistent
def _on_edit(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _on_evaluation(scene, depsgraph, at_rest=has_window())


@persistent
def _on_frame(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    _on_evaluation(scene, depsgraph, at_rest=False)


def _on_evaluation(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, at_rest: bool) -> None:
    if not _may_write(scene):
        _postpone()
        return
    if _is_due.is_set() or (is_waiting() and not at_rest):
        update(depsgraph)
    else:
        exact = instances.are_possible() or light_objects.is_layer_known()
        _update_groups(depsgraph, changes.changes(depsgraph, exact), at_rest)


def has_window() -> bool:
    """Whether somebody may be dragging a lamp."""
    return not bpy.app.background


def is_waiting() -> bool:
    """Whether lamps have changed and are not written yet."""
    return bpy.app.timers.is_registered(_write_at_rest)


def _stop_waiting() -> None:
    if is_waiting():
        bpy.app.timers.unregister(_write_at_rest)


def _write_at_rest() -> None:
    update(bpy.context.evaluated_depsgraph_get())


@persistent
def _before_use(*_: Any) -> None:
    """Before a render and a save the lamps are those of the scene."""
    if is_waiting() and threading.current_thread() is threading.main_thread():
        _write_at_rest()


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


@persistent
def _on_data_replaced(*_: Any) -> None:
    """After undo, redo and loading, all references to Blender's data are invalid."""
    global _written
    _forget()
    _object_order.clear()
    _written = None
    _is_due.set()


_HANDLERS = {"depsgraph_update_post": _on_edit, "frame_change_post": _on_frame, "render_init": _before_use,
             "save_pre": _before_use,
             "undo_pre": _on_data_replaced, "undo_post": _on_data_replaced, "redo_pre": _on_data_replaced,
             "redo_post": _on_data_replaced, "load_pre": _on_data_replaced, "load_post": _on_data_replaced}


def register() -> None:
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for timer in (_retry, _write_at_rest):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    for name, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    _on_data_replaced()
