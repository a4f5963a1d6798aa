"""What an evaluation of a scene has changed, as far as lamps are concerned.

Blender knows at once which types of data it evaluated; listing the data-blocks takes time in proportion to the scene.
"""

from itertools import islice
from typing import NamedTuple

import bpy

_MAX_UPDATES = 100


class Changed(NamedTuple):
    """What may have changed since the last evaluation.

    Structure: objects may have been added, removed, shown, hidden, linked to something, or given other data; Blender
    marks the scene whenever it rebuilds the relations of the dependency graph. Others: properties of lights, of the
    world, or of objects.
    """

    structure: bool
    materials: bool
    others: bool


EVERYTHING = Changed(True, True, True)


def changes(depsgraph: bpy.types.Depsgraph, exact: bool) -> Changed:
    """Read the changes from a dependency graph, in one of its handlers.

    If they are to be exact, the updates are listed to find out that only nodes were edited: Blender then marks every
    type of data that may have nodes, and a scene is one.
    """
    updated = depsgraph.id_type_updated
    structure = updated("SCENE")
    if structure and exact and updated("NODETREE"):
        structure = any(update.id.id_type == "SCENE" for update in depsgraph.updates)
    return Changed(structure, updated("MATERIAL"),
                   updated("OBJECT") or updated("LIGHT") or updated("WORLD") or updated("IMAGE"))


def changed_objects(depsgraph: bpy.types.Depsgraph) -> list[tuple[bpy.types.Object, bool]] | None:
    """The objects that were evaluated, each with whether its geometry was; None if there are too many to list."""
    updates = list(islice(depsgraph.updates, _MAX_UPDATES + 1))
    if len(updates) > _MAX_UPDATES:
        return None
    return [(update.id.original, update.is_updated_geometry) for update in updates if update.id.id_type == "OBJECT"]
