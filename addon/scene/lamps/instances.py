"""Lamps that are instanced: by collection instances, geometry nodes, particles, or children of vertices and faces.

Only a look at all instances of a scene finds them, so it is taken only where something instances a light, and again
only when something that can do so has changed. What is asked here may be answered yes in error, which costs that time.
"""

from collections import Counter

import bpy

from . import drivers, lamp
from .changes import changed_objects
from .light_objects import light_objects

_holds = {}                 # by collection: whether it holds lights
_found = {}                 # what `look` found, and where


def forget():
    """Take the next look at everything."""
    _holds.clear()
    _found.clear()


def forget_collections():
    """Find out anew which collections hold lights."""
    _holds.clear()


def lamps(depsgraph, shining, changed):
    """The lamps that are instanced: a list of `Lamp`, none of which is one of the objects in `shining`.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    shining : list of bpy.types.Object
    changed : changes.Changed
    """
    key = depsgraph.scene.session_uid, depsgraph.view_layer.name, depsgraph.mode
    if _found.get("key") != key or changed.structure:
        _found.clear()
        _found["key"] = key
        _found["may"] = may_be_instanced(depsgraph.scene, shining)
        if _found["may"]:
            look(depsgraph, shining)
    elif _found["may"] and changed.others:
        objects = changed_objects(depsgraph)
        if objects is None or any(_may_carry(*change) for change in objects):
            look(depsgraph, shining)
    return _found.get("lamps", [])


def look(depsgraph, shining):
    """Look at all instances for the lights that are none of `shining`."""
    known = {item.session_uid for item in shining}
    lights, parents = [], {}
    for instance in depsgraph.object_instances:
        item = instance.object
        if item.type != "LIGHT" or (not instance.is_instance and item.original.session_uid in known):
            continue
        if item.data.energy > 0:
            lights.append(lamp.of(item.data, instance.matrix_world))
        parent = instance.parent.original if instance.is_instance else item.original
        parents[parent.session_uid] = parents.get(parent.session_uid) or drivers.can_move(parent)
    _found["lamps"], _found["parents"] = lights, parents


def are_looked_for():
    """Whether something may instance a light, by the last answer."""
    return _found.get("may", False)


def move():
    """Whether lamps were found whose instances are animated."""
    return any(_found.get("parents", {}).values())


def may_be_instanced(scene, shining):
    """Whether something may instance a light; `shining` are those that stand in the scene."""
    if scene.background_set is not None or any(
            settings.render_type in {"OBJECT", "COLLECTION"} for settings in bpy.data.particles):
        return True
    lights = light_objects()
    # nodes are users of an object, and so is each collection that holds it
    if _has_geometry_nodes() and (len(lights) > len(shining) or any(item.users > 1 for item in lights)):
        return True
    return any(map(_is_child_of_instancer, lights)) or any(map(holds_lights, _instanced_collections()))


def holds_lights(collection):
    """Whether a collection that is instanced may bring lights along."""
    key = collection.session_uid
    if key not in _holds:
        _holds[key] = False             # ends where collections instance one another
        nodes = _has_geometry_nodes()
        _holds[key] = any(item.type == "LIGHT" or _instances_lights(item) or (nodes and _generates(item))
                          for item in collection.all_objects)
    return _holds[key]


def _instances_lights(item):
    return (item.instance_type == "COLLECTION" and item.instance_collection is not None
            and holds_lights(item.instance_collection))


def _may_carry(item, of_geometry):
    """Whether an object that has changed, perhaps its geometry, can have moved a lamp that is an instance."""
    if item.type == "LIGHT" or _instances_lights(item) or item.instance_type in {"VERTS", "FACES"}:
        return True
    return _generates(item) and (of_geometry or item.session_uid in _found.get("parents", ()))


def _generates(item):
    return len(item.particle_systems) > 0 or any(modifier.type == "NODES" for modifier in item.modifiers)


def _is_child_of_instancer(item):
    while item.parent is not None:
        item = item.parent
        if item.instance_type in {"VERTS", "FACES"}:
            return True
    return False


def _instanced_collections():
    """Collections with users besides the collections that they are in."""
    holders = [*bpy.data.collections, *(scene.collection for scene in bpy.data.scenes)]
    parents = Counter(child.session_uid for holder in holders for child in holder.children)
    return [item for item in bpy.data.collections if item.users - item.use_fake_user > parents[item.session_uid]]


def _has_geometry_nodes():
    return any(tree.bl_idname == "GeometryNodeTree" for tree in bpy.data.node_groups)
