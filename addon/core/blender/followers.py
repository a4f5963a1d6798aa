"""What follows when materials have got other node groups, without their makers knowing what that is."""

from collections.abc import Callable

import bpy

followers: list[Callable[[bpy.types.Depsgraph], None]] = []
"""Functions of the evaluated scene, which are called in their order. Where one raises, the change is taken back."""


def tell(context: bpy.types.Context) -> None:
    """Tell all followers that materials of the open file have got other groups."""
    depsgraph = context.evaluated_depsgraph_get()
    for follower in followers:
        follower(depsgraph)
