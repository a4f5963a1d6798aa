"""Whole pictures of anisotropic fits, through the add-on, against numerical integration of `Fit.evaluate`."""

import math

import bpy
import numpy as np
import pytest

from support import stage
from support.anisotropic import brushed_fit, ggx_lobe, vectors
from support.cases import quick
from support.made_fits import MADE_FITS
from support.spheres import normals, radial, turned_tangents

from . import test_rendering
from .test_rendering import SIZE, TOWARD, agree, mean_colour, on_the_sphere, reflected_by_sphere, sphere_scene
from .test_shader_guards import leaning, plane

SAMPLES = {"world": 256, "area lamp": 192}
FITS = {"brushed": brushed_fit(), "half a turn changes it": MADE_FITS["anisotropic Rusinkiewicz"]}


def mean_under_world(fit, turn):
    """Incident directions evenly in the square of the sine, and in azimuth."""
    n = normals(40)
    along, across = turned_tangents(n, radial(n), turn)
    squared, azimuth = np.meshgrid((np.arange(40) + 0.5) / 40, (np.arange(80) + 0.5) / 80 * 2 * math.pi)
    theta_o, phi_o = np.arccos(n[:, 2]), np.arctan2(across[:, 2], along[:, 2])
    albedo = [math.pi * np.maximum(fit.evaluate(np.arcsin(np.sqrt(squared)), azimuth, *at), 0).mean(axis=(0, 1))
              for at in zip(theta_o, phi_o, strict=True)]
    # so few pixels do not fill the disk's area
    return np.mean(albedo, axis=0) * math.pi / 4


LIGHTS = {name: (set_up, integrate) for name, (set_up, integrate, *_) in test_rendering.LIGHTS.items()
          if name != "sun without a size"}
LIGHTS["world"] = LIGHTS["world"][0], mean_under_world


def rotated_scene(fit, samples, rotation):
    scene = sphere_scene(fit, samples)
    stage.set_input(bpy.context.object.data.materials[0], "Rotation", rotation)
    return scene


@pytest.mark.parametrize(("light", "name", "rotation"), quick(
    [(light, *case) for light in LIGHTS
     for case in (("brushed", 0.0), ("brushed", 0.2), ("half a turn changes it", 0.2))],
    ("sun", "brushed", 0.2), ("point lamp", "half a turn changes it", 0.2)))
def test_the_mean_of_a_sphere_is_that_of_numerical_integration(blender, light, name, rotation):
    set_up, integrate = LIGHTS[light]
    fit = FITS[name]
    scene = rotated_scene(fit, SAMPLES.get(light, 16), rotation)
    set_up()
    ratio = mean_colour(scene) / integrate(fit, 2 * math.pi * rotation)
    print(f"{name}, {light}, rotation {rotation}: rendered / integrated = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=0.01)


def lit_by_a_sun(scene, function, rotation, channels):
    """Whether a sphere under a sun is right pixel by pixel. Where the tangent turns within a pixel, about the pole, a
    pixel is a mean of many directions."""
    test_rendering.sun(angle=0)
    inside, n = on_the_sphere(hole=0.01)
    agree(stage.render(scene)[..., :channels][inside],
          reflected_by_sphere(function, n, TOWARD, 2 * math.pi * rotation), n)


@pytest.mark.parametrize("rotation", quick([0.0, 0.1], 0.1))
def test_a_sphere_under_the_sun_is_right_pixel_by_pixel(blender, rotation):
    fit = brushed_fit()
    lit_by_a_sun(rotated_scene(fit, 64, rotation), fit, rotation, 3)


class Glossy:
    """What Blender's Glossy BSDF renders with a roughness of 0.5 and an anisotropy of 0.6."""

    def evaluate(self, *directions):
        return ggx_lobe(*vectors(*np.broadcast_arrays(*directions)), 0.25 * 0.4, 0.25 / 0.4)[:, None]


@pytest.mark.parametrize("rotation", quick([0.0, 0.1], 0.1))
def test_highlights_lie_where_blenders_own_node_has_them(blender, rotation):
    """The same function draws the expected picture of the node and, in the test above, that of a fit."""
    scene = stage.black_scene(SIZE, SIZE, 64, span=2)
    scene.cycles.max_bounces = 0
    material, node, surface = stage.blank_material("Glossy", "ShaderNodeBsdfAnisotropic")
    node.distribution = "GGX"
    for name, value in (("Color", (1, 1, 1, 1)), ("Roughness", 0.5), ("Anisotropy", 0.6), ("Rotation", rotation)):
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], surface)
    stage.add_sphere().data.materials.append(material)
    lit_by_a_sun(scene, Glossy(), rotation, 1)


def tangent_plane(fit, tangent, rotation=0.0):
    """A plane that faces the viewer, whose tangent is a vector or that of its UV map."""
    scene = plane(fit, 64)
    material = bpy.context.object.data.materials[0]
    stage.set_input(material, "Rotation", rotation)
    if tangent != "UV":
        stage.connect_vector(material, "Tangent", tangent)
        return scene
    node = material.node_tree.nodes.new("ShaderNodeTangent")
    node.direction_type, node.uv_map = "UV_MAP", "UVMap"
    material.node_tree.links.new(node.outputs[0], stage.group_node(material).inputs["Tangent"])
    return scene


@pytest.mark.parametrize(("tangent", "rotation", "azimuth"), [
    ((1, 0, 0), 0.0, 0.0), ((0, 3, 0), 0.0, 90.0), ((1, 1, 5), 0.0, 45.0), ((1, 0, 0), 0.1, 36.0), ("UV", 0.0, 0.0)])
def test_a_plane_is_turned_as_its_tangent_and_its_rotation_say(blender, tangent, rotation, azimuth):
    """Seen from its normal, under a sun."""
    fit = brushed_fit()
    scene = tangent_plane(fit, tangent, rotation)
    theta, phi = math.radians(35), math.radians(20)
    stage.add_lamp("SUN", 1, rotation=stage.rotation_toward(leaning(35, 20)), angle=0)
    expected = fit.evaluate(theta, phi - math.radians(azimuth), 0.0, 0.0) * math.cos(theta)
    assert mean_colour(scene) == pytest.approx(expected, rel=0.003)


def test_a_tangent_along_the_normal_is_like_any_other(blender):
    """It has no direction; the surface is lit nevertheless."""
    scene = tangent_plane(brushed_fit(), (0, 0, 1))
    stage.add_lamp("SUN", 1, rotation=(0, -0.3, 0), angle=0)
    picture = stage.render(scene)[..., :3]
    assert np.isfinite(picture).all()
    assert picture.mean() > 0.01
