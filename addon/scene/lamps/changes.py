"""What an evaluation of a scene has changed, as far as lamps are concerned.

Blender knows at once which types of data it has evaluated; to list the data it looks at all that the scene has.
"""

from itertools import islice
from typing import NamedTuple

_LISTED = 100
_OF_INTEREST = "OBJECT", "LIGHT", "WORLD", "IMAGE"


class Changed(NamedTuple):
    """What may have changed since the last evaluation.

    Attributes
    ----------
    structure : bool
        Objects may have come, gone, been shown, hidden, linked to something, or given other data. Blender marks the
        scene whenever it finds out anew what depends on what.
    materials : bool
    others : bool
        Lights, the world, or objects, in themselves.
    """

    structure: bool
    materials: bool
    others: bool


EVERYTHING = Changed(True, True, True)


def changes(depsgraph, exact):
    """Read them off a dependency graph in one of its handlers.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    exact : bool
        Whether it is worth a list to know that nothing but nodes was edited: with them Blender marks all types of data
        that may have nodes, and a scene is one.
    """
    updated = depsgraph.id_type_updated
    structure = updated("SCENE")
    if structure and exact and updated("NODETREE"):
        structure = any(update.id.id_type == "SCENE" for update in depsgraph.updates)
    return Changed(structure, updated("MATERIAL"), any(map(updated, _OF_INTEREST)))


def changed_objects(depsgraph):
    """The objects that were evaluated, and whether their geometry was: a list of pairs; None for too many to list."""
    updates = list(islice(depsgraph.updates, _LISTED + 1))
    if len(updates) > _LISTED:
        return None
    return [(update.id.original, update.is_updated_geometry) for update in updates if update.id.id_type == "OBJECT"]
