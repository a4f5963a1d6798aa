"""Keeps what is exported of measured materials as they are set, and says at an export what is lost.

No exporter asks before it begins, so the exported surface follows each change: at once in scripts, in a window when the
change rests, since a write makes renderers look at the material again.
"""

from collections.abc import Iterator
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import lamps
from ..annotations import not_none
from ..blender.transaction import find_by_session_uid
from . import export_surface
from . import material as materials

_REST = 0.5                     # s, for which materials and images have not changed when the surface follows
_changed: dict[int, bool] = {}  # by session_uid of a material: whether its images have changed


@persistent
def _on_edit(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if not (depsgraph.id_type_updated("MATERIAL") or depsgraph.id_type_updated("IMAGE")):
        return
    # of other types the handler of lamps may have removed some, and asking for the original of one crashes Blender
    updated = [update.id.original for update in depsgraph.updates if update.id.id_type in ("MATERIAL", "IMAGE")]
    images = [item for item in updated if isinstance(item, bpy.types.Image)]
    for item in updated:
        if isinstance(item, bpy.types.Material) and _is_followed(item):
            _changed.setdefault(item.session_uid, False)
    if images:
        for item in bpy.data.materials:
            if _is_followed(item) and export_surface.uses_images(not_none(materials.surface_node(item)), images):
                _changed[item.session_uid] = True
    if _changed:
        _stop_waiting()
        if not bpy.app.background or not lamps.is_main_thread_free():
            bpy.app.timers.register(_follow_all, first_interval=_REST, persistent=True)
        else:
            _follow_all()


def _follow_all() -> float | None:
    """Have the exported surfaces follow all changes, once no render runs."""
    if not lamps.is_main_thread_free():
        return _REST
    waiting = dict(_changed)
    _changed.clear()
    for uid, again in waiting.items():
        item = find_by_session_uid(bpy.data.materials, uid)
        if item is not None and _is_followed(item):
            export_surface.follow(item, not_none(materials.surface_node(item)), again)
    return None


def _is_followed(material: bpy.types.Material) -> bool:
    return material.is_editable and materials.is_shown(material)


def lost_in(exported: bpy.types.Material) -> Iterator[str]:
    """What of a material is not exported, if it is a measured one, as lines of a report."""
    if materials.is_shown(exported):
        for line in export_surface.losses(exported):
            yield f"{exported.name}: {line}"


class GltfHook:
    """What the exporter of glTF calls: its warnings are shown when it has finished."""

    def gather_material_hook(self, _made: Any, material: bpy.types.Material, settings: Any) -> None:
        for line in lost_in(material):
            if not line.startswith(f"{material.name}: {export_surface.NOT_EVERYWHERE}"):
                settings["log"].warning(line, popup=True)


def _stop_waiting() -> None:
    if bpy.app.timers.is_registered(_follow_all):
        bpy.app.timers.unregister(_follow_all)


@persistent
def _on_save(*_: object) -> None:
    if _changed:
        _follow_all()


def unregister() -> None:
    _stop_waiting()
    _changed.clear()


handlers = {"depsgraph_update_post": _on_edit, "save_pre": _on_save}
