"""Bakes placeholders of the starter library when they are used: in a window, shortly after one was put on an object.

A placeholder that was there when the file was opened or the extension enabled, or that has been tried before in this
session, is left to the Fit button: so undo, and Esc, are the user's last word.
"""

import bpy
from bpy.app.handlers import persistent

from ..work import modal
from . import placeholder

_DELAY = 0.3                # s, until the drop has become an undo step
_AGAIN = 1.0                # s, while another fit is running
_tried: set[int] = set()    # session_uid of materials


def bake_next() -> bool:
    """Start the ordinary fit of a placeholder that an object has begun to use: whether others may wait."""
    waiting = [item for item in bpy.data.materials if item.session_uid not in _tried
               and placeholder.is_placeholder(item) and _is_used(item)]
    window = next(iter(bpy.context.window_manager.windows), None)
    if not waiting or window is None:
        return False
    if modal.running is None:
        _tried.add(waiting[0].session_uid)
        with bpy.context.temp_override(window=window, material=waiting[0]):
            bpy.ops.measured_brdf.fit("INVOKE_DEFAULT")
    return True


def _is_used(material: bpy.types.Material) -> bool:
    """Whether an object shows a material."""
    return any(slot.material == material for item in bpy.context.scene.objects for slot in item.material_slots)


def _tick() -> float | None:
    try:
        return _AGAIN if bake_next() else None
    except RuntimeError:            # of an operator that was refused; the Fit button says why
        return None


@persistent
def _on_change(_scene: object, depsgraph: bpy.types.Depsgraph) -> None:
    if bpy.app.background or not (depsgraph.id_type_updated("OBJECT") or depsgraph.id_type_updated("MATERIAL")):
        return
    if len(bpy.data.materials) and not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_DELAY, persistent=True)


@persistent
def _on_load(_file: object) -> None:
    _leave_all()


def _leave_all() -> None:
    """Leave the placeholders that are there to the Fit button."""
    _tried.clear()
    _tried.update(item.session_uid for item in bpy.data.materials)


classes = ()


def register() -> None:
    bpy.app.handlers.depsgraph_update_post.append(_on_change)
    bpy.app.handlers.load_post.append(_on_load)
    bpy.app.timers.register(_leave_all, first_interval=0)       # `bpy.data` cannot be read here


def unregister() -> None:
    bpy.app.handlers.load_post.remove(_on_load)
    bpy.app.handlers.depsgraph_update_post.remove(_on_change)
    for timer in (_tick, _leave_all):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
    _tried.clear()
