"""Drivers of a carrier's values: lamps that move or change by themselves are followed at every frame.

Their expressions are simple ones, which need no Python and run where scripts are disabled. By a pointer to the lamp,
an object that is appended would bring the lamps of its file along. So drivers look up an object's name in the view
layer that is evaluated (`ACTIVE_VIEW_LAYER`; the active scene would give the original objects, a frame late). If no
object has that name, the last known value stays.
"""

import re
from collections.abc import Mapping

import bpy

from . import carrier, lamp
from .light_objects import get_light, is_animated

Place = tuple[int, int]
"""The number of a lamp, from 1, and the index of one of its six values."""
_Driver = tuple[str, dict[str, str]]
"""An expression, and the data path of each variable in it."""

_VARIABLE_WORDS = re.compile(r"[a-z_]\w*")
_POSITION_INDICES, _SIZE, _STRENGTH = range(3), 3, 4


def driver_expressions(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> dict[int, str]:
    """The values of a light of a view layer that can change without an edit: {index: expression}."""
    # the matrix of an object that is hidden in the viewport is not evaluated there
    moves = can_move(item) or not item.visible_get(view_layer=layer)
    light = get_light(item)
    changes = is_animated(light)
    expressions = lamp.expressions(light)
    indices = [*(_POSITION_INDICES if moves else ()), *([_STRENGTH] if changes else ())]
    if changes or (moves and light.type != "SUN"):
        indices.append(_SIZE)
    wanted = {index: expressions[index] for index in indices}
    if is_animated(item):                   # it may be shown at some frames alone
        wanted[_STRENGTH] = f"{expressions[_STRENGTH]} * {lamp.VISIBILITY}"
    return wanted


def can_move(item: bpy.types.Object | None) -> bool:
    """Whether an object can be elsewhere at another frame, by itself or with its parents."""
    while item is not None:
        if is_animated(item) or len(item.constraints) or item.rigid_body is not None:
            return True
        if item.parent is not None and item.parent_type != "OBJECT":
            return True
        item = item.parent
    return False


def wire(held: bpy.types.Texture, sources: Mapping[Place, tuple[str, bpy.types.Object]]) -> set[Place]:
    """Give a carrier these drivers, {place: (expression, evaluated object)}, and remove all others: the places that had
    the right driver already, and so have their values."""
    before = _existing(held)
    after: dict[tuple[str, int], _Driver] = {
        carrier.path(*place): (expression, {name: _target(name, item) for name in _variables(expression)})
        for place, (expression, item) in sources.items()}
    for path in before:
        if before[path] != after.get(path):
            held.driver_remove(*path)
    unchanged = {place for place in sources if before.get(carrier.path(*place)) == after[carrier.path(*place)]}
    for place in sources.keys() - unchanged:
        _add(held, carrier.path(*place), *sources[place])
    return unchanged


def _variables(expression: str) -> list[str]:
    return sorted({word for word in _VARIABLE_WORDS.findall(expression) if word in lamp.VARIABLES})


def _target(name: str, item: bpy.types.Object) -> str:
    return f'objects["{bpy.utils.escape_identifier(item.name)}"].{lamp.VARIABLES[name]}'


def _existing(held: bpy.types.Texture) -> dict[tuple[str, int], _Driver]:
    """The drivers that a carrier has, by the data path of the driven property and the index in it."""
    animation = held.animation_data
    return {} if animation is None else {
        (curve.data_path, curve.array_index): (
            curve.driver.expression, {variable.name: variable.targets[0].data_path
                                      for variable in curve.driver.variables})
        for curve in animation.drivers}


def _add(held: bpy.types.Texture, path: tuple[str, int], expression: str, item: bpy.types.Object) -> None:
    driver = held.driver_add(*path).driver
    driver.type, driver.expression = "SCRIPTED", expression
    for name in _variables(expression):
        variable = driver.variables.new()
        variable.name, variable.type = name, "CONTEXT_PROP"
        target = variable.targets[0]
        target.context_property = "ACTIVE_VIEW_LAYER"
        target.data_path = _target(name, item)
        target.use_fallback_value, target.fallback_value = True, item.path_resolve(lamp.VARIABLES[name])
