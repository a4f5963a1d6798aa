"""Whole pictures of anisotropic fits, through the add-on, against numerical integration of `Fit.evaluate`."""

import math
from dataclasses import fields

import bpy
import numpy as np
import pytest

from fitter.model.fit import Fit
from support.anisotropic import brushed_fit, ggx, vectors
from support.cases import quick, release
from support.made_fits import MADE_FITS
from support.spheres import normals, radial, reflected_on, turned_tangents
from support.stage import (
    add_lamp,
    add_sphere,
    background,
    black_scene,
    blank_material,
    osl_material_for,
    render,
    rotation_toward,
    set_input,
)

SIZE = 96
FROM_THE_LEFT = math.radians(60)
TOWARD = np.array([-math.sin(FROM_THE_LEFT), 0, math.cos(FROM_THE_LEFT)])
LAMP = np.array([-3.0, 0.0, 2.0])
POWER = 100.0
AREA_SIDE = 2.0
SAMPLES = {"world": 256, "area lamp": 192}
FITS = {"brushed": brushed_fit(), "half a turn changes it": MADE_FITS["anisotropic Rusinkiewicz"]}


def picture_mean(values, resolution):
    return values.sum(axis=0) / resolution**2


def mean_under_sun(fit, turn):
    n = normals(400)
    return picture_mean(reflected_on(fit, n, radial(n), np.broadcast_to(TOWARD, n.shape), turn), 400)


def mean_under_point(fit, turn):
    n = normals(400)
    away = LAMP - n
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    light = reflected_on(fit, n, radial(n), away / distance, turn) * POWER / (4 * math.pi * distance**2)
    return picture_mean(light, 400)


def mean_under_area(fit, turn):
    facing, across = -LAMP / np.linalg.norm(LAMP), np.array([0.0, 1, 0])
    up, n = np.cross(facing, across), normals(100)
    steps = ((np.arange(12) + 0.5) / 12 - 0.5) * AREA_SIDE
    total = 0
    for s in steps:
        for t in steps:
            away = LAMP + s * across + t * up - n
            distance = np.linalg.norm(away, axis=1, keepdims=True)
            toward = away / distance
            form = (-toward @ facing)[:, None].clip(0) / distance**2
            total = total + reflected_on(fit, n, radial(n), toward, turn) * form / len(steps) ** 2
    return picture_mean(total * POWER / math.pi, 100)


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


def sun():
    add_lamp("SUN", 1, rotation=(0, -FROM_THE_LEFT, 0), angle=math.radians(0.526))


LIGHTS = {
    "world": (lambda: background(bpy.context.scene, 1), mean_under_world),
    "sun": (sun, mean_under_sun),
    "point lamp": (lambda: add_lamp("POINT", POWER, LAMP, shadow_soft_size=0.1), mean_under_point),
    "point lamp without a size": (lambda: add_lamp("POINT", POWER, LAMP, shadow_soft_size=0), mean_under_point),
    "area lamp": (lambda: add_lamp("AREA", POWER, LAMP, (0, -math.atan2(3, 2), 0), shape="SQUARE", size=AREA_SIDE),
                  mean_under_area)}


def sphere_scene(fit, samples, rotation=0.0):
    scene = black_scene(SIZE, SIZE, samples, span=2)
    scene.cycles.max_bounces = 0
    material = osl_material_for(fit)
    set_input(material, "Rotation", rotation)
    add_sphere().data.materials.append(material)
    return scene


@pytest.mark.parametrize(("light", "name", "rotation"), quick(
    [(light, *case) for light in LIGHTS
     for case in (("brushed", 0.0), ("brushed", 0.2), ("half a turn changes it", 0.2))],
    ("sun", "brushed", 0.2), ("point lamp", "half a turn changes it", 0.2)))
def test_the_mean_of_a_sphere_is_that_of_numerical_integration(blender, light, name, rotation):
    set_up, integrate = LIGHTS[light]
    fit = FITS[name]
    scene = sphere_scene(fit, SAMPLES.get(light, 16), rotation)
    set_up()
    ratio = render(scene)[..., :3].mean(axis=(0, 1)) / integrate(fit, 2 * math.pi * rotation)
    print(f"{name}, {light}, rotation {rotation}: rendered / integrated = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=0.01)


def on_the_sphere():
    """Pixels well inside of a sphere, and its normals there: (height, width) bool, (pixels, 3)."""
    x = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(x, -x)
    inside = x**2 + y**2 < 0.9
    # where the tangent turns within a pixel, about the pole, a pixel is a mean of many directions
    inside &= x**2 + y**2 > 0.01
    return inside, np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)[inside]


def agree(picture, expected, n):
    lit = n @ TOWARD > 0.1
    error = np.abs(picture - expected)[lit] / (expected[lit] + 0.02 * expected.max())
    assert np.median(error) < 0.01
    assert np.quantile(error, 0.99) < 0.1


@pytest.mark.parametrize("rotation", quick([0.0, 0.1], 0.1))
def test_a_sphere_under_the_sun_is_right_pixel_by_pixel(blender, rotation):
    fit = brushed_fit()
    scene = sphere_scene(fit, 64, rotation)
    add_lamp("SUN", 1, rotation=(0, -FROM_THE_LEFT, 0), angle=0)
    inside, n = on_the_sphere()
    expected = reflected_on(fit, n, radial(n), np.broadcast_to(TOWARD, n.shape), 2 * math.pi * rotation)
    agree(render(scene)[..., :3][inside], expected, n)


class Glossy:
    """What Blender's Glossy BSDF renders with a roughness of 0.5 and an anisotropy of 0.6."""

    def evaluate(self, *directions):
        return ggx(*vectors(*np.broadcast_arrays(*directions)), 0.25 * 0.4, 0.25 / 0.4)[:, None]


@pytest.mark.parametrize("rotation", quick([0.0, 0.1], 0.1))
def test_highlights_lie_where_blenders_own_node_has_them(blender, rotation):
    """The same function draws the expected picture of the node and, in the test above, that of a fit."""
    scene = black_scene(SIZE, SIZE, 64, span=2)
    scene.cycles.max_bounces = 0
    material, node, surface = blank_material("Glossy", "ShaderNodeBsdfAnisotropic")
    node.distribution = "GGX"
    for name, value in (("Color", (1, 1, 1, 1)), ("Roughness", 0.5), ("Anisotropy", 0.6), ("Rotation", rotation)):
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], surface)
    add_sphere().data.materials.append(material)
    add_lamp("SUN", 1, rotation=(0, -FROM_THE_LEFT, 0), angle=0)
    inside, n = on_the_sphere()
    expected = reflected_on(Glossy(), n, radial(n), np.broadcast_to(TOWARD, n.shape), 2 * math.pi * rotation)
    agree(render(scene)[..., :1][inside], expected, n)


def plane(fit, tangent=None, rotation=0.0, samples=64, size=8):
    """A plane that faces the viewer; what `tangent` makes in its node tree is its tangent."""
    scene = black_scene(size, size, samples, span=1)
    scene.cycles.max_bounces = 0
    bpy.ops.mesh.primitive_plane_add(size=4)
    material = osl_material_for(fit)
    set_input(material, "Rotation", rotation)
    bpy.context.object.data.materials.append(material)
    if tangent is not None:
        group = next(node for node in material.node_tree.nodes if node.type == "GROUP")
        material.node_tree.links.new(tangent(material.node_tree.nodes), group.inputs["Tangent"])
    return scene


def along(vector):
    """A tangent that is the same everywhere."""
    def make(nodes):
        node = nodes.new("ShaderNodeCombineXYZ")
        for socket, value in zip(node.inputs, vector, strict=True):
            socket.default_value = value
        return node.outputs[0]
    return make


def of_uv(nodes):
    node = nodes.new("ShaderNodeTangent")
    node.direction_type, node.uv_map = "UV_MAP", "UVMap"
    return node.outputs[0]


@pytest.mark.parametrize(("tangent", "rotation", "azimuth"), [
    (along((1, 0, 0)), 0.0, 0.0), (along((0, 3, 0)), 0.0, 90.0), (along((1, 1, 5)), 0.0, 45.0),
    (along((1, 0, 0)), 0.1, 36.0), (of_uv, 0.0, 0.0)])
def test_a_plane_is_turned_as_its_tangent_and_its_rotation_say(blender, tangent, rotation, azimuth):
    """Seen from its normal, under a sun."""
    fit = brushed_fit()
    scene = plane(fit, tangent, rotation)
    theta, phi = math.radians(35), math.radians(20)
    toward = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])
    add_lamp("SUN", 1, rotation=rotation_toward(toward), angle=0)
    expected = fit.evaluate(theta, phi - math.radians(azimuth), 0.0, 0.0) * math.cos(theta)
    assert render(scene)[..., :3].mean(axis=(0, 1)) == pytest.approx(expected, rel=0.003)


def test_a_tangent_along_the_normal_is_like_any_other(blender):
    """It has no direction; the surface is lit nevertheless."""
    scene = plane(brushed_fit(), along((0, 0, 1)))
    add_lamp("SUN", 1, rotation=(0, -0.3, 0), angle=0)
    picture = render(scene)[..., :3]
    assert np.isfinite(picture).all()
    assert picture.mean() > 0.01


@release
@pytest.mark.parametrize("light", quick(["sun", "area lamp"], "sun"))
def test_a_quarter_turn_exchanges_the_widths(blender, light):
    pictures = []
    for widths, rotation in (((0.12, 0.4), 0.25), ((0.4, 0.12), 0.0), ((0.12, 0.4), 0.0)):
        scene = sphere_scene(brushed_fit(*widths, 0.0), SAMPLES.get(light, 16), rotation)
        LIGHTS[light][0]()
        pictures.append(render(scene)[..., :3])

    def off(i, j):
        return np.abs(pictures[i] - pictures[j]).mean() / pictures[0].mean()

    assert pictures[0].mean(axis=(0, 1)) == pytest.approx(pictures[1].mean(axis=(0, 1)), rel=0.005)
    assert off(0, 1) < 0.01
    assert off(0, 2) > 0.3


class TakenForAnisotropic(Fit):
    """An isotropic fit that is rendered as an anisotropic one is."""

    isotropic = False


@pytest.mark.parametrize("light", quick(["world", "sun", "area lamp"], "sun"))
def test_an_isotropic_reflectance_gives_the_same_picture_as_an_anisotropic_fit(blender, light):
    pictures = []
    fit = brushed_fit(0.2, 0.2)
    for shown in (fit, TakenForAnisotropic(**{field.name: getattr(fit, field.name) for field in fields(fit)})):
        scene = black_scene(SIZE, SIZE, SAMPLES.get(light, 16), span=2)
        scene.cycles.max_bounces = 0
        material = osl_material_for(shown)
        group = next(node for node in material.node_tree.nodes if node.type == "GROUP")
        assert shown.isotropic == ("Rotation" not in group.inputs) == ("Tangent" not in group.inputs)
        add_sphere().data.materials.append(material)
        LIGHTS[light][0]()
        pictures.append(render(scene)[..., :3])
    assert pictures[1].mean(axis=(0, 1)) == pytest.approx(pictures[0].mean(axis=(0, 1)), rel=0.005)
    blocks = [picture.reshape(12, 8, 12, 8, 3).mean(axis=(1, 3)) for picture in pictures]
    assert np.abs(blocks[1] - blocks[0]).mean() < 0.01 * blocks[0].mean()
