"""Metals of the library, rendered by Cycles: no negative light, and what the formula reflects."""

import bpy
import numpy as np
import pytest

from fitter.model import published
from support.cases import quick
from support.stage import add_sphere, background, black_scene, render

POLISHED = [each.name for each in published.list_offered() if each.name.endswith("-polished")]


@pytest.mark.parametrize("name", quick([*POLISHED, "gold-brushed", "copper-satin", "iron-rough"], "gold-polished"))
def test_an_exact_metal_has_no_dark_pixels_and_in_a_white_room_its_own_colour(blender, extension, name):
    """A sphere under an even sky shows the directional albedo, whose middle is that at normal incidence."""
    scene = black_scene(32, 32, 1024, span=2)    # of 256, a pixel of brushed gold is 1.104
    scene.cycles.max_bounces = 0
    background(scene, 1)
    add_sphere()
    bpy.ops.measured_brdf.use_published(name=name)
    item = bpy.context.object.active_material
    extension.addon.core.shading.material.use_rendering(item, "EXACT")
    even = render(scene)[..., :3]
    assert even.min() >= 0
    assert even.max() < 1.1
    model = published.find(name).model
    if max(model.alpha, model.across) < 0.1:
        assert even[13:19, 13:19].mean(axis=(0, 1)) == pytest.approx(model.fresnel(np.ones(1))[0], rel=0.03)
    background(scene, 0)
    bpy.ops.object.light_add(type="AREA", radius=1, location=(2, -2, 3))
    bpy.context.object.data.energy = 200
    bpy.context.object.rotation_euler = (0.756, 0, 0.785)
    lit = render(scene)[..., :3]
    assert lit.min() > -5e-5 * lit.max()        # of gold, brushed, one pixel in a thousand is below zero: -2e-5
    assert lit.max() > 0.5
