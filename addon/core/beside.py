"""The material beside which another is shown: the slice `compare` chooses it, and without it there is none."""

from collections.abc import Callable

import bpy

chosen_by: list[Callable[[bpy.types.Scene, bpy.types.Material], bpy.types.Material | None]] = []


def beside(scene: bpy.types.Scene, material: bpy.types.Material) -> bpy.types.Material | None:
    """The material that is shown beside another in a scene, or None."""
    return next((other for choose in chosen_by if (other := choose(scene, material)) is not None), None)
