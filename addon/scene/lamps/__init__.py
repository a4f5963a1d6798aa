"""The scene's lamps, handed to the shaders: a node group of values that the measured materials share.

Appending or linking materials brings groups of other files along; all of them are kept up to date, in memory too where
they are linked.

The shader puts a lobe at each lamp (`osl/lamps.h`). The lobes, the mixture and the drawn directions sum to the measured
reflectance wherever the lobes stand, so a lamp that is missing here, or stands here and is not seen, costs noise; only
a lamp without any size, which nothing drawn can hit, is seen as the mixture shows it until it is known.

Which lamps there are is written by handlers. Lamps that move by themselves have drivers (`drivers`), so that a render
job follows them without anything being written. A handler that a render job calls, in a thread of its own, does
nothing unless the interface is locked: Blender may be reading what it would write. docs/rendering.md has the table of
what holds where.
"""

import threading
from collections import Counter

import bpy
from bpy.app.handlers import persistent

from ..world_lights import bright_spots
from . import changes, drivers, even, group, instances, lamp, light_objects
from .group import NAME, node_tree

__all__ = ["NAME", "in_scene", "light_is_even", "node_tree", "sky_moves", "store", "update"]

_AGAIN = 0.5                # seconds until a job that holds an update up is asked for again
_order = {}                 # by group: the session_uid of the objects its lamps are, None for others
_behind = threading.Event()         # an update was held up, or the data are others than they were


def in_scene(depsgraph):
    """The lamps of an evaluated scene that give light, as the shader takes them: a sorted list of `lamp.Lamp`.

    At most as many as the shader of this version takes. Bright places of the world are suns.
    """
    _forget()
    found = [known for known, _ in _lamps(depsgraph, changes.EVERYTHING) if known.strength > 0]
    return sorted(found, key=lambda known: known.rank)[:group.MAX_LAMPS]


def light_is_even(depsgraph):
    """Whether there is light besides that of the lamps, and it is even."""
    even.forget()
    return even.light_is_even(depsgraph.scene_eval.world)


def store(tree, lamps, is_even=False):
    """Write lamps into a group, as `in_scene` has them, and whether other light is even. They are not followed."""
    drivers.wire(tree, {})
    group.store(tree, lamps, is_even)
    _order.pop(tree.session_uid, None)


def update(depsgraph):
    """Hand the lamps of an evaluated scene to the measured materials, where there are any; after the render job, where
    one runs."""
    if not _may_write(depsgraph.scene):
        _hold_up()
        return
    _behind.clear()
    _forget()
    _hand_over(depsgraph, changes.EVERYTHING)


def sky_moves(world):
    """Whether a world has bright places and something in it is animated."""
    return (world is not None and world.node_tree is not None and drivers.is_animated(world.node_tree)
            and len(bright_spots(world)) > 0)


def _hand_over(depsgraph, changed):
    if changed.structure:
        light_objects.forget_layers()
        instances.forget_collections()
    if changed.materials:
        even.forget()
    trees = group.trees() if any(changed) else []
    if not trees:
        return
    is_even = even.light_is_even(depsgraph.scene_eval.world)
    found = sorted(_lamps(depsgraph, changed), key=lambda pair: pair[0].rank)
    for tree in trees:
        _write(tree, found[:group.capacity(tree)], is_even, depsgraph.view_layer)


def _lamps(depsgraph, changed):
    """The lamps of a scene, each with its object, evaluated, where it is one: a list of (Lamp, object or None)."""
    shining = light_objects.shining(depsgraph.view_layer)
    lights = [item.evaluated_get(depsgraph) for item in shining]
    # one that is dark now, and may be lit at another frame, stays known
    found = [(lamp.of(item.data, item.matrix_world), item) for item in lights
             if item.data.energy > 0 or drivers.is_animated(item.data.original)]
    found += [(known, None) for known in instances.lamps(depsgraph, shining, changed)]
    found += [(lamp.Lamp(direction, -radius, light), None)
              for direction, radius, light in bright_spots(depsgraph.scene_eval.world) if light > 0]
    return found


def _write(tree, found, is_even, layer):
    """Write lamps into a group, with drivers for those that want them."""
    names = Counter(item.name for _, item in found if item is not None)
    # a local and a linked object of one name cannot be told apart by drivers
    wants = {_identity(item): drivers.wanted(item.original, layer) for _, item in found
             if item is not None and names[item.name] == 1}
    if any(wants.values()):
        found = _in_place(found, _order.get(tree.session_uid, []))
    _order[tree.session_uid] = [_identity(item) for _, item in found]
    sources = {(number, index): (told, item) for number, (_, item) in enumerate(found, 1)
               for index, told in wants.get(_identity(item), {}).items()}
    had = drivers.wire(tree, sources)
    group.store(tree, [known for known, _ in found], is_even, had)


def _in_place(found, before):
    """The same lamps in the order that they had: one that becomes brighter than another is no reason to exchange their
    drivers, after which Blender works out anew what depends on what."""
    if Counter(before) != Counter(_identity(item) for _, item in found):
        return found
    others = iter([pair for pair in found if pair[1] is None])
    objects = {_identity(pair[1]): pair for pair in found}
    return [next(others) if identity is None else objects[identity] for identity in before]


def _identity(item):
    return None if item is None else item.original.session_uid


def _forget():
    light_objects.forget()
    instances.forget()
    even.forget()


def _may_write(scene):
    """Whether no render reads what is written now."""
    if scene.render.use_lock_interface:
        return True
    return threading.current_thread() is threading.main_thread() and not bpy.app.is_job_running("RENDER")


@persistent
def _on_evaluation(scene, depsgraph):
    if not _may_write(scene):
        _hold_up()
        return
    if _behind.is_set():
        update(depsgraph)
    else:
        exact = instances.are_looked_for() or light_objects.is_layer_known()
        _hand_over(depsgraph, changes.changes(depsgraph, exact))


def _hold_up():
    _behind.set()
    if threading.current_thread() is threading.main_thread() and not bpy.app.timers.is_registered(_catch_up):
        bpy.app.timers.register(_catch_up, first_interval=_AGAIN, persistent=True)


def _catch_up():
    """Do what was held up, once no render runs."""
    scene = bpy.context.scene
    if not _may_write(scene):
        return _AGAIN
    if _behind.is_set():
        update(bpy.context.evaluated_depsgraph_get())
    return None


@persistent
def _on_other_data(*_):
    """After undo, redo and loading nothing that was known of Blender's data holds."""
    _forget()
    _order.clear()
    _behind.set()


_HANDLERS = {"depsgraph_update_post": _on_evaluation, "frame_change_post": _on_evaluation,
             "undo_pre": _on_other_data, "undo_post": _on_other_data, "redo_pre": _on_other_data,
             "redo_post": _on_other_data, "load_pre": _on_other_data, "load_post": _on_other_data}


def register():
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    if bpy.app.timers.is_registered(_catch_up):
        bpy.app.timers.unregister(_catch_up)
    for name, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
    _on_other_data()
