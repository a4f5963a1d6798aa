"""The lights of the file and those of a view layer, without looking at its other objects.

Which objects are lights is found out anew when the lights or their users change; whether one shines, Blender answers in
constant time, unless it is hidden. So an edit costs time in proportion to the lights, in a scene of any size.
"""

import bpy

_known = {}                 # the signature, and the light objects that were found under it
_rendered = {}              # by view layer: the session_uid of the lights that are rendered


def forget():
    """Look at everything anew: nothing of Blender's is kept over undo, redo, and the loading of files."""
    _known.clear()
    _rendered.clear()


def forget_layers():
    """Look anew at which collections are rendered."""
    _rendered.clear()


def is_layer_known():
    """Whether collections have been looked through for lights that are rendered and not visible."""
    return len(_rendered) > 0


def light_objects():
    """All objects of the file that are lights."""
    signature = tuple((light.session_uid, light.users) for light in bpy.data.lights)
    if _known.get("signature") != signature or not _are_alive(_known["objects"]):
        forget()
        _known["objects"] = [item for item in bpy.data.objects if item.type == "LIGHT"] if signature else []
        _known["signature"] = signature
    return _known["objects"]


def shining(layer):
    """The lights that shine in a view layer, in the viewport or when it is rendered."""
    return [item for item in light_objects() if item.visible_get(view_layer=layer) or is_rendered(item, layer)]


def is_rendered(item, layer):
    """Whether a light of the file is rendered with a view layer."""
    if item.hide_render:
        return False
    key = layer.id_data.session_uid, layer.name
    if key not in _rendered:
        _rendered[key] = set(_in_render(layer.layer_collection))
    return item.session_uid in _rendered[key]


def _in_render(layer_collection):
    if layer_collection.exclude or layer_collection.collection.hide_render:
        return
    for item in layer_collection.collection.objects:
        if item.type == "LIGHT":
            yield item.session_uid
    for child in layer_collection.children:
        yield from _in_render(child)


def _are_alive(objects):
    try:
        for item in objects:
            item.session_uid            # noqa: B018  raises where the object has been removed
    except ReferenceError:
        return False
    return True
