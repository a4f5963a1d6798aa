"""Drivers of a lamp group's sockets: lamps that move or change by themselves are followed at every frame.

Blender evaluates drivers for every dependency graph: in the viewport, in the thread of a render, and on a farm without
this extension. Their expressions are simple ones, which need no Python and run where scripts are disabled.

A driver that refers to an object by pointer would append the user's lamps along with a material. So these drivers look
up an object's name in the view layer that is being evaluated (`ACTIVE_VIEW_LAYER`; the active scene would give the
original objects, a frame late). If no object has that name, the socket keeps the last known value.
"""

import re
from collections.abc import Mapping

import bpy

from . import group, lamp
from .light_objects import light_of

Place = tuple[int, int]
"""The number of a lamp, from 1, and the index of one of its `group.sockets`."""
_Driver = tuple[str, dict[str, str]]
"""An expression, and the data path of each variable in it."""

_WORDS = re.compile(r"[a-z_]\w*")
_POSITION, _SIZE, _STRENGTH = range(3), 3, 4


def wanted(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> dict[int, str]:
    """The sockets of a lamp that need drivers, because their values can change without an edit: {index: expression}.

    The lamp is a light of the view layer, not evaluated.
    """
    # the matrix of an object that is hidden in the viewport is not evaluated there
    moves = can_move(item) or not item.visible_get(view_layer=layer)
    light = light_of(item)
    changes = is_animated(light)
    expressions = lamp.expressions(light)
    indices = [*(_POSITION if moves else ()), *([_STRENGTH] if changes else ())]
    if changes or (moves and light.type != "SUN"):
        indices.append(_SIZE)
    return {index: expressions[index] for index in indices}


def can_move(item: bpy.types.Object | None) -> bool:
    """Whether an object can be elsewhere at another frame, by itself or with its parents."""
    while item is not None:
        if is_animated(item) or len(item.constraints) or item.rigid_body is not None:
            return True
        if item.parent is not None and item.parent_type != "OBJECT":
            return True
        item = item.parent
    return False


def is_animated(data: bpy.types.ID) -> bool:
    """Whether a data-block itself has an action, drivers or strips."""
    animation = data.animation_data
    return animation is not None and (animation.action is not None or len(animation.drivers) > 0
                                      or len(animation.nla_tracks) > 0)


def wire(tree: bpy.types.NodeTree, sources: Mapping[Place, tuple[str, bpy.types.Object]]) -> set[Place]:
    """Give a lamp group these drivers, {(number, index): (expression, evaluated object)}, and remove all others.

    Numbers and indices are those of `group.store`. Returns the places that had the right driver already, and so have
    their values.
    """
    before = _existing(tree)
    after: dict[str, _Driver] = {
        _path(*place): (expression, {name: _target(name, item) for name in _variables(expression)})
        for place, (expression, item) in sources.items()}
    for path in before:
        if before[path] != after.get(path):
            tree.driver_remove(path)
    unchanged = {place for place in sources if before.get(_path(*place)) == after[_path(*place)]}
    for place in sources.keys() - unchanged:
        _add(group.sockets(tree, place[0])[place[1]], *sources[place])
    return unchanged


def _variables(expression: str) -> list[str]:
    return sorted({word for word in _WORDS.findall(expression) if word in lamp.VARIABLES})


def _path(number: int, index: int) -> str:
    kind, socket = ("Lamp", index) if index in _POSITION else ("Extent", index - len(_POSITION))
    return f'nodes["{kind}{number}"].inputs[{socket}].default_value'


def _target(name: str, item: bpy.types.Object) -> str:
    return f'objects["{bpy.utils.escape_identifier(item.name)}"].{lamp.VARIABLES[name]}'


def _existing(tree: bpy.types.NodeTree) -> dict[str, _Driver]:
    """The drivers that a group has, by the data path of the driven property."""
    animation = tree.animation_data
    return {} if animation is None else {
        curve.data_path: (curve.driver.expression,
                          {variable.name: variable.targets[0].data_path for variable in curve.driver.variables})
        for curve in animation.drivers}


def _add(socket: bpy.types.NodeSocket, expression: str, item: bpy.types.Object) -> None:
    driver = socket.driver_add("default_value").driver
    driver.type, driver.expression = "SCRIPTED", expression
    for name in _variables(expression):
        variable = driver.variables.new()
        variable.name, variable.type = name, "CONTEXT_PROP"
        target = variable.targets[0]
        target.context_property = "ACTIVE_VIEW_LAYER"
        target.data_path = _target(name, item)
        target.use_fallback_value, target.fallback_value = True, lamp.value(name, item)
