"""What measured materials are compared with, and how that is shown: properties of the scene, which slices share."""

from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, PointerProperty

from . import material as materials
from .look import BALL, LIGHTINGS, SHAPES, STUDIO


class MeasuredComparison(bpy.types.PropertyGroup):
    """Stored with the scene."""

    pinned: PointerProperty(
        name="Compare With", type=bpy.types.Material, poll=lambda _, material: materials.is_shown(material),
        description="A measured material beside which the others are shown")
    divide: FloatProperty(
        name="Line", default=0.5, min=0, max=1, subtype="FACTOR",
        description="Where the line between the two materials is. Does not change the materials")
    shape: EnumProperty(name="Shape", items=SHAPES, default=BALL, description="What is rendered of the material")
    lighting: EnumProperty(name="Light", items=LIGHTINGS, default=STUDIO, description="The light that it is seen in")


def get(scene: bpy.types.Scene) -> Any:
    return scene.measured_brdf_comparison


def find_pinned(scene: bpy.types.Scene, material: bpy.types.Material) -> bpy.types.Material | None:
    """The material with which another is compared in a scene; None if there is none, or it is the same."""
    other: bpy.types.Material | None = get(scene).pinned
    return None if other is None or other == material or not materials.is_shown(other) else other


classes = (MeasuredComparison,)
pointers = ((bpy.types.Scene, "measured_brdf_comparison",
             PointerProperty(type=MeasuredComparison, name="Compare Measured BRDFs")),)
