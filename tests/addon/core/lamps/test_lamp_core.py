"""How much of the disk about an area lamp the lamp fills."""

import math

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.lamps import lamp


@pytest.mark.parametrize(("shape", "width", "height"), [
    ("SQUARE", 2.0, 2.0), ("RECTANGLE", 3.0, 0.5), ("DISK", 2.0, 2.0), ("ELLIPSE", 2.0, 0.6)])
def test_the_core_of_a_lamp_has_its_area(blender, extension, shape, width, height):
    """By counting points of a grid that are in the lamp and in the disk about it."""
    light = bpy.data.lights.new("Light", "AREA")
    light.shape, light.size, light.size_y = shape, width, height
    bpy.ops.object.empty_add(scale=(1.5, 0.7, 1))
    item = bpy.context.object
    item.scale = 1.5, 0.7, 1
    bpy.context.view_layer.update()
    made = lamp.from_light(light, item.matrix_world)
    steps = np.linspace(-1, 1, 801) * made.size
    x, y = np.meshgrid(steps, steps)
    u, v = x / (1.5 * width / 2), y / (0.7 * height / 2)
    inside = u * u + v * v <= 1 if shape in {"DISK", "ELLIPSE"} else np.maximum(abs(u), abs(v)) <= 1
    disk = np.hypot(x, y) <= made.size
    assert not (inside & ~disk).any()
    assert made.core == pytest.approx(math.sqrt(inside.sum() / disk.sum()), rel=0.01)
