"""Exact has no black pixels where lights that the shader does not know, area lamps and bump maps make them likely."""

import bpy
import numpy as np
import pytest

from benchmarks import black_pixels
from support import stage
from support.cases import quick

# of 16,000 pixels: where a lobe at a lamp takes a part of another lamp's, or a peak is narrower than its lamp
MOST = {"foil, 100 lamps": 60, "cayman, three lamps": 4}


@pytest.mark.parametrize("name", quick([*black_pixels.SCENES], "foil, lit mesh", "krylon, bump map"))
def test_no_pixel_is_far_below_zero(extension, openimageio, name):
    if not black_pixels.is_there(name):
        pytest.skip("no measurements")
    fit, nodes = black_pixels.fitted(black_pixels.SCENES[name][1])
    picture = stage.render(black_pixels.scene(name, lambda: stage.material_for(fit, nodes)))[..., :3]
    assert black_pixels.below(picture) <= MOST.get(name, 0)


def test_pixels_below_zero_are_counted():
    picture = np.ones((10, 10, 3))
    picture[1, 1, 0], picture[2, 2], picture[3, 3, 2] = -1, -0.5, -1e-3
    assert black_pixels.below(picture) == 2


def test_a_bump_map_turns_the_normals_of_the_ball(extension):
    """Of a Diffuse BSDF, whose picture it changes."""
    def matte():
        material, shader, surface = stage.blank_material("Matte", "ShaderNodeBsdfDiffuse")
        material.node_tree.links.new(shader.outputs[0], surface)
        return material

    pictures = []
    for name in ("krylon, area lamp", "krylon, bump map"):
        made = black_pixels.scene(name, matte)
        made.cycles.samples = 4
        pictures.append(stage.render(made)[..., :3])
    assert np.abs(pictures[0] - pictures[1]).mean() > 0.02 * pictures[0].mean()
    assert len(bpy.data.lights) == 1
