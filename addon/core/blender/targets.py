"""What an imported material is for: the object, and the slot of it, that a file was dropped on; else the active object
and all that are selected."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from ..annotations import not_none
from .transaction import find_by_session_uid

ACTIVE_SLOT = -1
_NOTHING = -1               # as an object: nothing was active; 0 is an operator's default
_WITHOUT_SURFACE = {"VOLUME", "GREASEPENCIL", "GPENCIL"}     # unless modifiers make meshes of them
_SOLID = {"TEXTURED", "SOLID"}
_MOST_SEEN_THROUGH = 16     # objects in front of the one that is hit
_STEP = 1e-4                # beyond an object that is seen through, relative to its distance


class Target(NamedTuple):
    """An object and its slot."""

    item: int                   # its `session_uid`: users may undo and delete meanwhile
    slot: int = ACTIVE_SLOT     # or from 0


def active(context: bpy.types.Context) -> Target:
    item = context.object
    return Target(_NOTHING) if item is None else Target(item.session_uid, not_none(item.active_material_index))


def list_selected(context: bpy.types.Context) -> list[Target]:
    """The active object, and where it can have materials, those that are selected beside it and can; active slots."""
    items = [item for item in (context.object, *getattr(context, "selected_objects", ()))
             if item is not None and has_surface(item)]
    others = [item for item in items if item != context.object] if context.object in items else []
    return [active(context), *(Target(item.session_uid) for item in others)]


def find_under_mouse(context: bpy.types.Context, event: bpy.types.Event) -> Target | None:
    """The object under the mouse in a 3-D viewport, of an instance that which is instanced, and its face's slot."""
    for area in context.window.screen.areas if context.window is not None else ():
        if area.type == "VIEW_3D" and (region := region_under_mouse(area, event)) is not None:
            space: Any = area.spaces.active
            return _hit(context, space, region, event)
    return None


def region_under_mouse(area: bpy.types.Area, event: bpy.types.Event) -> bpy.types.Region | None:
    """The region of a view under the mouse; None where a sidebar or a header is over it, and beside the area."""
    under = [region for region in area.regions if min(region.width, region.height) > 1
             and 0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height]
    return under[0] if under and all(region.type == "WINDOW" for region in under) else None


def has_surface(item: bpy.types.Object) -> bool:
    """Whether an object may show the surface of a material."""
    return hasattr(item.data, "materials") and (item.type not in _WITHOUT_SURFACE or len(item.modifiers) > 0)


def assign_all(chosen: Sequence[Target], material: bpy.types.Material) -> str:
    """Assign a material to the objects that can have it: why the first cannot where none can; else empty."""
    refused = [assign(target, material) for target in chosen]
    return "" if "" in refused else refused[0]


def assign(target: Target, material: bpy.types.Material) -> str:
    """Assign a material to the slot of an object: why that was not possible, as a sentence; else empty."""
    item = find_by_session_uid(bpy.data.objects, target.item)
    if target.item == _NOTHING:
        return "no object was active"
    if item is None:
        return "its object has been removed meanwhile"
    if not has_surface(item):
        return f"{item.name} has no surface"
    slots = item.material_slots
    wanted = not_none(item.active_material_index) if target.slot == ACTIVE_SLOT else target.slot
    slot = slots[min(wanted, len(slots) - 1)] if slots else None
    if not item.is_editable or (not item.data.is_editable and (slot is None or slot.link == "DATA")):
        return (f"{item.name} belongs to another file. Make it local (Object > Relations > Make Local), and choose the "
                "material in its Material tab")
    if slot is None:
        item.data.materials.append(material)
    else:
        slot.material = material
    return ""


def _hit(context: bpy.types.Context, space: bpy.types.SpaceView3D, region: bpy.types.Region,
         event: bpy.types.Event) -> Target | None:
    view: Any = region.data
    at = event.mouse_x - region.x, event.mouse_y - region.y
    direction = view3d_utils.region_2d_to_vector_3d(region, view, at)
    origin = view3d_utils.region_2d_to_origin_3d(region, view, at)
    if not view.is_perspective:             # there it is in the middle of what is seen
        camera = view.view_matrix.inverted().translation
        origin -= direction * ((origin - camera).dot(direction) if view.view_perspective == "CAMERA"
                               else space.clip_end)
    for item, face in _ray_hits(context, origin, direction):
        if item.display_type in _SOLID and (space.local_view is None or item.local_view_get(space)):
            return Target(item.session_uid, _face_slot(item, face, context))
    return None


def _ray_hits(context: bpy.types.Context, origin: Vector, direction: Vector) -> Iterator[tuple[bpy.types.Object, int]]:
    """The objects, and their faces, that a ray hits one after the other."""
    start = origin.copy()
    for _ in range(_MOST_SEEN_THROUGH):
        is_hit, place, _, face, item, _ = not_none(context.scene).ray_cast(context.evaluated_depsgraph_get(), start,
                                                                           direction)
        if not is_hit:
            return
        yield item.original, face
        start = place + direction * (_STEP * (place - origin).length)


def _face_slot(item: bpy.types.Object, face: int, context: bpy.types.Context) -> int:
    """The slot of a face of an evaluated object; its active one where the object has no such face."""
    evaluated = item.evaluated_get(context.evaluated_depsgraph_get())
    mesh = evaluated.data if item.type == "MESH" else evaluated.to_mesh()
    slot = mesh.polygons[face].material_index if 0 <= face < len(mesh.polygons) else ACTIVE_SLOT
    evaluated.to_mesh_clear()
    return slot
