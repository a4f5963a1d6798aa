"""What an evaluation of a scene has changed, as far as lamps are concerned.

Blender knows at once which types of data it evaluated; listing the data-blocks takes time in proportion to the scene.
"""

from itertools import islice
from typing import NamedTuple

import bpy

_MAX_UPDATES = 100


class Changed(NamedTuple):
    """What may have changed since the last evaluation."""

    structure: bool         # objects were added, removed, shown, hidden, linked to something, or given other data
    others: bool            # properties of lights, of the world, of objects, or of materials


EVERYTHING = Changed(True, True)


def changes(depsgraph: bpy.types.Depsgraph) -> Changed:
    """Read the changes from a dependency graph, in one of its handlers."""
    updated = depsgraph.id_type_updated
    # Blender marks the scene whenever it rebuilds the graph's relations; and, as a scene may have nodes, where only
    # nodes were edited, which the updates tell apart
    structure = updated("SCENE") and (
        not updated("NODETREE") or any(update.id.id_type == "SCENE" for update in depsgraph.updates))
    return Changed(structure, updated("OBJECT") or updated("LIGHT") or updated("WORLD") or updated("IMAGE")
                   or updated("MATERIAL"))


def changed_objects(depsgraph: bpy.types.Depsgraph) -> list[bpy.types.Object] | None:
    """The objects that were evaluated; None if there are too many to list."""
    updates = list(islice(depsgraph.updates, _MAX_UPDATES + 1))
    if len(updates) > _MAX_UPDATES:
        return None
    return [update.id.original for update in updates if update.id.id_type == "OBJECT"]
