"""Drivers of a lamp group's sockets, by which lamps that can move or change by themselves are followed at every frame.

Blender evaluates drivers with the rest of a scene, for every dependency graph apart: in the viewport, in the thread of
a render and on a farm without this extension. Their expressions are simple ones, which need no Python and are not held
back with scripts. A driver that names an object by its pointer would take the user's lamps along wherever a material is
appended; these look for a name in the view layer that is being evaluated (`ACTIVE_VIEW_LAYER`; the active scene's
objects would be the original ones, a frame late). Where nothing has that name, the value last known stays.
"""

import re

import bpy

from . import group, lamp

_WORDS = re.compile(r"[a-z_]\w*")
_POSITION, _SIZE, _STRENGTH = range(3), 3, 4


def wanted(item, layer):
    """Which of a lamp's sockets want drivers: {index: expression}; those that can change without being edited.

    Parameters
    ----------
    item : bpy.types.Object
        A light of the view layer, not evaluated.
    layer : bpy.types.ViewLayer
    """
    # where an object is that is hidden in the viewport is not known there
    moves = can_move(item) or not item.visible_get(view_layer=layer)
    changes = is_animated(item.data)
    told = lamp.expressions(item.data)
    indices = [*(_POSITION if moves else ()), *([_STRENGTH] if changes else ())]
    if changes or (moves and item.data.type != "SUN"):
        indices.append(_SIZE)
    return {index: told[index] for index in indices}


def can_move(item):
    """Whether an object can be elsewhere at another frame, by itself or with what it is parented to."""
    while item is not None:
        if is_animated(item) or len(item.constraints) or item.rigid_body is not None:
            return True
        if item.parent is not None and item.parent_type != "OBJECT":
            return True
        item = item.parent
    return False


def is_animated(data):
    """Whether a data-block has an action, drivers or strips of its own."""
    animation = data.animation_data
    return animation is not None and (animation.action is not None or len(animation.drivers) > 0
                                      or len(animation.nla_tracks) > 0)


def wire(tree, sources):
    """Give a lamp group the drivers that it wants, and no others.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
    sources : dict
        {(number, index): (expression, evaluated object)}, as `group.store` counts.

    Returns
    -------
    set of (number, index)
        Those that had their drivers already, and so have their values.
    """
    before = _present(tree)
    after = {_path(*place): (told, {name: _target(name, item) for name in _variables(told)})
             for place, (told, item) in sources.items()}
    for path in before:
        if before[path] != after.get(path):
            tree.driver_remove(path)
    had = {place for place in sources if before.get(_path(*place)) == after[_path(*place)]}
    for place in sources.keys() - had:
        _add(group.sockets(tree, place[0])[place[1]], *sources[place])
    return had


def _variables(told):
    return sorted({word for word in _WORDS.findall(told) if word in lamp.VARIABLES})


def _path(number, index):
    kind, socket = ("Lamp", index) if index in _POSITION else ("Extent", index - len(_POSITION))
    return f'nodes["{kind}{number}"].inputs[{socket}].default_value'


def _target(name, item):
    return f'objects["{bpy.utils.escape_identifier(item.name)}"].{lamp.VARIABLES[name]}'


def _present(tree):
    """The drivers that a group has: {path: (expression, {variable: where it is})}."""
    animation = tree.animation_data
    return {} if animation is None else {
        curve.data_path: (curve.driver.expression,
                          {variable.name: variable.targets[0].data_path for variable in curve.driver.variables})
        for curve in animation.drivers}


def _add(socket, told, item):
    driver = socket.driver_add("default_value").driver
    driver.type, driver.expression = "SCRIPTED", told
    for name in _variables(told):
        variable = driver.variables.new()
        variable.name, variable.type = name, "CONTEXT_PROP"
        target = variable.targets[0]
        target.context_property = "ACTIVE_VIEW_LAYER"
        target.data_path = _target(name, item)
        target.use_fallback_value, target.fallback_value = True, lamp.value(name, item)
