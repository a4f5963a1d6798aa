"""Translucent materials as Cycles renders them, against photons: an even light, and a sharp edge of light."""

import math

import bpy
import numpy as np
import pytest

from fitter.library import ready
from fitter.model import published
from fitter.optics.fresnel import fresnel
from fitter.optics.subsurface import color_to_single_scattering
from fitter.quality.physics import directional_albedo
from support import photons, stage

SIDE = 400.0                    # of a slab, in units of the scene, which are millimetres


@pytest.fixture(scope="module")
def skin(extension):
    return ready.make("skin-1")


def slab(scene, made, scale=1e-3):
    """A thick slab under the camera: its material."""
    bpy.ops.mesh.primitive_cube_add(size=SIDE, location=(0, 0, -SIDE / 2))
    return covered(made, scale)


def covered(made, scale):
    """Give the active object the material, which is returned."""
    item = stage.material_for(made.fit, made.nodes)
    bpy.context.object.data.materials.append(item)
    stage.set_input(item, "Scale", scale)
    return item


def mean(scene):
    return stage.render(scene)[..., :3].mean(axis=(0, 1))


@pytest.mark.parametrize("osl", [True, False])
def test_an_even_light_is_reflected_as_the_albedo_says(skin, osl):
    """Pixels of a sphere that is large for the light in it see all directions as an even light comes from them."""
    scene = stage.black_scene(48, 48, 128, span=2)
    scene.cycles.shading_system = osl
    stage.background(scene, 1)
    stage.add_sphere(64, 32)
    covered(skin, 0.2)
    picture, cosine = stage.render(scene), np.sqrt((np.arange(20) + 0.5) / 20)
    expected = directional_albedo(skin.fit, np.arccos(cosine)).mean(axis=0)
    assert picture[..., :3].sum(axis=(0, 1)) / picture[..., 3].sum() == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("scale", [1e-3, 5e-4])
def test_light_goes_beyond_a_sharp_edge_as_far_as_photons_do(skin, scale):
    """Half of the slab is in the shadow of a sheet, close above it, which the camera does not see. Where the camera
    looks at, walks begin straight down; they bring light where they end on the other side."""
    width, height = 48, 16
    scene = stage.black_scene(width, height, 512, span=12)
    scene.cycles.max_bounces = 12
    slab(scene, skin, scale)
    tilt = math.radians(45)
    stage.add_lamp("SUN", math.pi / math.cos(tilt), rotation=(tilt, 0, 0), angle=0.0)
    mesh = bpy.data.meshes.new("Sheet")
    mesh.from_pydata([(0, -SIDE, 0), (SIDE, -SIDE, 0), (SIDE, SIDE, 0), (0, SIDE, 0)], [], [(0, 1, 2, 3)])
    sheet = stage.add(mesh, location=(0, 0, 1e-3))
    sheet.visible_camera = False
    mesh.materials.append(stage.blank_material("Black", "ShaderNodeEmission")[0])
    found = stage.render(scene)[..., :3].mean(axis=0)
    x = ((np.arange(width) + 0.5) / width - 0.5) * 12
    walk, through = skin.nodes.walk, 1 - fresnel(skin.fit.subsurface.index, np.ones(1))[0]
    for channel in range(3):
        scattered = color_to_single_scattering(walk.color[channel])
        distance, weight = photons.straight_radii(scattered, 200_000)
        length = walk.radius[channel] / (4 * math.pi) * 1e-3 / scale
        beyond = np.array([(weight * photons.share_beyond(distance * length, each)).sum() for each in x])
        shadow = (x > 0.4) & (x < 4)
        assert found[shadow, channel].sum() == pytest.approx((through * beyond)[shadow].sum(), rel=0.06)
        near = (x > 0.4) & (x < 1.4)
        assert found[near, channel] == pytest.approx((through * beyond)[near], rel=0.15)


def test_tint_and_strength_work_on_what_comes_from_below(skin):
    scene = stage.black_scene(12, 12, 128, span=20)
    stage.background(scene, 1)
    item = slab(scene, skin)
    whole = mean(scene)
    stage.set_input(item, "Strength", 0.5)
    assert mean(scene) == pytest.approx(whole / 2, rel=0.03)
    stage.set_input(item, "Strength", 1.0)
    stage.set_input(item, "Tint", (1, 0, 1, 1))
    red, green, _ = mean(scene)
    assert red == pytest.approx(whole[0], rel=0.03)
    assert green < 0.01


def test_the_library_has_what_the_papers_measured():
    assert len([*published.translucent()]) == 25
