"""The carrier of a scene's lamps: a data-block whose custom properties hold their numbers, and pointers to it.

The lamp group (`group`) reads them by Attribute nodes, as attributes of each object that points to the carrier, without
the extension: Cycles compiles nothing when they change.

A carrier is a texture that nothing shows. Of an object Blender would evaluate drivers only where it is visible; and it
puts an object into the scene of those who append what points to it. Pointers to local data do not outlive a save where
an object is linked or overridden: such objects keep the carrier of their own file, which gets the lamps of this one.
"""

from collections.abc import Collection, Iterable, Sequence

import bpy

from ..blender.active_material import can_change
from .lamp import Lamp

CARRIER_NAME = "Measured BRDF Lamps"
POINTER = "measured_brdf_lamps"     # custom property of objects with measured materials, and of scenes: their carrier
LAMP_COUNT = "Lamps"                # custom property of a carrier: how many lamps it holds
PROPERTY_KINDS = "Lamp", "Extent"   # and with a number from 1, three numbers each: (position), (size, strength, core)
_PASSED_ON = {"NODETREE", "MATERIAL", "MESH", "CURVE", "CURVES", "META", "POINTCLOUD", "VOLUME"}


def attribute(kind: str, number: int) -> str:
    return f"{_path(POINTER)}{_path(f'{kind}{number}')}"


def path(number: int, index: int) -> tuple[str, int]:
    """The data path of one of the six values of a lamp in its carrier, and the index there."""
    row, column = divmod(index, 3)
    return _path(f"{PROPERTY_KINDS[row]}{number}"), column


def _path(name: str) -> str:
    return f'["{name}"]'


def scene_carrier(scene: bpy.types.Scene, make: bool) -> bpy.types.Texture | None:
    """The carrier of a scene of this file; where it has none, a new one or None."""
    carrier = scene.get(POINTER)
    # a copy of a scene has the carrier of the original, and needs one of its own
    if is_local(carrier) and scene == next(each for each in bpy.data.scenes if each.get(POINTER) == carrier):
        return carrier
    if not make or not can_change(scene):
        return None
    carrier = bpy.data.textures.new(CARRIER_NAME, "NONE")
    carrier[LAMP_COUNT] = 0
    # users that are custom properties may be forgotten: see `mix_group.keep`
    carrier.use_fake_user = True
    scene[POINTER] = carrier
    carrier.animation_data_create()         # has Blender find out that the scene depends on it
    return carrier


def linked_carriers() -> list[bpy.types.Texture]:
    """The carriers of other files, and overrides of them."""
    return [item for item in bpy.data.textures if item.get(LAMP_COUNT) is not None and not is_local(item)]


def is_local(carrier: object) -> bool:
    return isinstance(carrier, bpy.types.Texture) and carrier.get(LAMP_COUNT) is not None and can_change(carrier)


def most_lamps() -> int:
    """How many lamps a scene of this file has at most."""
    carriers = filter(None, (scene.get(POINTER) for scene in bpy.data.scenes))
    return max((each.get(LAMP_COUNT, 0) for each in carriers), default=0)


def reserve(carrier: bpy.types.Texture, count: int) -> None:
    """Have a carrier hold so many lamps: those that it held remain, new ones have no strength."""
    if carrier[LAMP_COUNT] == count:
        return
    for number in range(carrier[LAMP_COUNT] + 1, count + 1):
        for kind in PROPERTY_KINDS:
            carrier[f"{kind}{number}"] = 0.0, 0.0, 0.0
    for number in range(count + 1, carrier[LAMP_COUNT] + 1):
        for name in (f"{kind}{number}" for kind in PROPERTY_KINDS):
            carrier.driver_remove(_path(name))
            del carrier[name]
    carrier[LAMP_COUNT] = count
    carrier.update_tag()


def store(carrier: bpy.types.Texture, lamps: Sequence[Lamp], driven: Collection[tuple[int, int]] = frozenset()) -> None:
    """Write the values of as many lamps as a carrier holds, but for those that are driven: lamps from 1 and indices."""
    changed = False
    for number, (position, *rest) in enumerate(lamps, 1):
        values = *position, *rest
        for row, kind in enumerate(PROPERTY_KINDS):
            before = [*carrier[f"{kind}{number}"]]
            after = [before[column] if (number, 3 * row + column) in driven else value
                     for column, value in enumerate(values[3 * row:3 * row + 3])]
            if before != after:
                carrier[f"{kind}{number}"] = after
                changed = True
    if changed:
        carrier.update_tag()


def point(scene: bpy.types.Scene, carrier: bpy.types.Texture, readers: Collection[bpy.types.Object]) -> None:
    """Point objects that read lamps, and belong to the scene or to none, to its carrier; no other keeps a pointer."""
    here = _scene_objects(scene)
    carriers = [each[POINTER] for each in bpy.data.scenes if each.get(POINTER) is not None]
    for item in bpy.data.objects:
        if not can_change(item):
            continue
        before = item.get(POINTER)
        if item not in readers:
            item.pop(POINTER, None)
        elif before != carrier and (item in here or before not in carriers):
            item[POINTER] = carrier
            # else Cycles keeps the attributes that it has of an object
            item.update_tag(refresh={"OBJECT"})


def _scene_objects(scene: bpy.types.Scene) -> set[bpy.types.Object]:
    """The objects of a scene and of the collections that they are instances of."""
    # `Depsgraph.ids` has those of geometry nodes too; Blender crashes where some were just removed, as by `group.merge`
    found: set[bpy.types.Object] = set()
    waiting = [*scene.objects]
    while waiting:
        item = waiting.pop()
        if item not in found:
            found.add(item)
            waiting += [] if item.instance_collection is None else item.instance_collection.all_objects
    return found


def readers(trees: Iterable[bpy.types.NodeTree]) -> set[bpy.types.Object]:
    """The objects with materials that have these node groups in them, also by nodes or a view layer."""
    users = bpy.data.user_map(key_types=_PASSED_ON)
    waiting: list[bpy.types.ID] = list(trees)
    passed: set[bpy.types.ID] = set(waiting)
    while waiting:
        further = {user for user in users.get(waiting.pop(), ()) if user not in passed}
        passed |= further
        waiting += further
    overridden = (item for scene in bpy.data.scenes for layer in scene.view_layers if layer.material_override in passed
                  for item in layer.objects)
    return {item for item in passed if isinstance(item, bpy.types.Object)}.union(overridden)


def remove_unused() -> None:
    """Remove the carriers that appended objects and removed scenes have left."""
    for item in [*bpy.data.textures]:
        if is_local(item) and item.users == item.use_fake_user:
            bpy.data.textures.remove(item)
