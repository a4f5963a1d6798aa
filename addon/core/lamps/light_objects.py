"""The light objects of the file and of a view layer, found without looking at other objects.

The list of lights is made anew when objects are added or removed. For a light that is not hidden, Blender says in
constant time whether it is visible. So an edit costs time in proportion to the lights, in a scene of any size.
"""

from collections.abc import Iterator
from typing import cast

import bpy

_objects: list[bpy.types.Object] | None = None      # the light objects; None: not looked for
_rendered: dict[tuple[int, str], set[int]] = {}     # by view layer: session_uid of the lights that are rendered


def forget() -> None:
    """Forget all objects: references to Blender's data are not valid after undo, redo, and loading a file."""
    global _objects
    _objects = None
    _rendered.clear()


def light_objects() -> list[bpy.types.Object]:
    global _objects
    try:
        for item in _objects or ():
            item.session_uid            # noqa: B018  raises where the object has been removed
    except ReferenceError:
        forget()
    if _objects is None:
        _objects = [item for item in bpy.data.objects if item.type == "LIGHT"] if len(bpy.data.lights) > 0 else []
    return _objects


def get_light(item: bpy.types.Object) -> bpy.types.Light:
    return cast(bpy.types.Light, item.data)


def is_animated(data: bpy.types.ID) -> bool:
    """Whether a data-block itself has an action, drivers or strips."""
    animation = data.animation_data
    return animation is not None and (animation.action is not None or len(animation.drivers) > 0
                                      or len(animation.nla_tracks) > 0)


def shining(layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The lights of a view layer that are visible in the viewport or rendered, now or maybe at another frame."""
    return [item for item in light_objects() if item.visible_get(view_layer=layer) or is_rendered(item, layer)]


def is_rendered(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> bool:
    if item.hide_render and not is_animated(item):
        return False
    key = layer.id_data.session_uid, layer.name
    if key not in _rendered:
        _rendered[key] = set(_rendered_lights(layer.layer_collection))
    return item.session_uid in _rendered[key]


def _rendered_lights(layer_collection: bpy.types.LayerCollection) -> Iterator[int]:
    if layer_collection.exclude or layer_collection.collection.hide_render:
        return
    for item in layer_collection.collection.objects:
        if item.type == "LIGHT":
            yield item.session_uid
    for child in layer_collection.children:
        yield from _rendered_lights(child)
