"""Closure nodes as Cycles renders them without OSL, against integrals of `node_mixture.evaluate` in NumPy.

That function is compared with fits in `tests/fitter/cycles/test_node_mixture.py`. Here it is the truth for the nodes:
what they compute from the view and the inputs, and what Cycles makes of each closure.
"""

import math

import numpy as np
import pytest

from fitter.cycles import node_mixture
from support import stage
from support.anisotropic import brushed_fit
from support.cases import quick, release
from support.spheres import normals, radial, turned_tangents

SIZE, BLOCK = 48, 6
NARROW = {"cayman"}             # highlights smaller than half a pixel
ANGLE = math.radians(50)
TOWARD = np.array([-math.sin(ANGLE), 0, math.cos(ANGLE)])
MATERIALS = ("velvet", "aluminum foil", "felt", "krylon_blue_RGB", "cayman")


def sphere(fit, osl=False, samples=64):
    """A sphere of a fit, lit by a sun from the left: (scene, material)."""
    scene = stage.black_scene(SIZE, SIZE, samples, span=2)
    scene.cycles.max_bounces = 0
    scene.cycles.shading_system = osl
    material = stage.material_for(fit)
    stage.add_sphere().data.materials.append(material)
    stage.add_lamp("SUN", math.pi, rotation=(0, -ANGLE, 0), angle=math.radians(0.2))
    return scene, material


def blocks(picture):
    """Means of a picture over blocks of pixels."""
    return picture.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, -1).mean(axis=(1, 3))


def integral(mixture, turn=None, finer=2):
    """The picture of a unit sphere under the sun: means over blocks of pixels, each of which has finer^2 points."""
    resolution = finer * SIZE
    n = normals(resolution)
    up = np.array([0.0, 0, 1])
    values = np.zeros((len(n), mixture.colour.shape[-1]))
    along, across = turned_tangents(n, radial(n), 0.0 if turn is None else turn)
    for number, (normal, x, y) in enumerate(zip(n, along, across, strict=True)):
        if normal @ TOWARD > 0:
            frame = np.stack([x, y, normal])
            values[number] = node_mixture.evaluate(mixture, frame @ up, (frame @ TOWARD)[None])[0]
    picture = np.zeros((resolution, resolution, values.shape[1]))
    x = (np.arange(resolution) + 0.5) / resolution * 2 - 1
    on_it = x[None] ** 2 + x[:, None] ** 2 < 1
    picture[on_it] = values
    picture = picture[::-1].reshape(SIZE, finer, SIZE, finer, -1).mean(axis=(1, 3))
    # a sun of pi W / m2 has an irradiance of pi
    return np.broadcast_to(math.pi * blocks(picture), (SIZE // BLOCK, SIZE // BLOCK, 3))


def assert_close(found, expected, within=0.03):
    """Alike in the mean, and in each block up to a share of the mean: narrow peaks lie on edges of blocks."""
    mean = expected.mean(axis=(0, 1))
    np.testing.assert_allclose(found.mean(axis=(0, 1)), mean, rtol=0.01, atol=0.01 * mean.max())
    difference = np.abs(found - expected).mean(axis=(0, 1))
    assert (difference <= within * mean.max()).all(), difference / mean


@pytest.mark.parametrize("name", quick(MATERIALS, "velvet", "krylon_blue_RGB"))
def test_cycles_without_osl_shows_the_sum_of_closures(blender, standard, name):
    fit = standard(name)
    expected = integral(node_mixture.node_mixtures(fit).cycles, finer=4 if name in NARROW else 2)
    scene, _ = sphere(fit)
    assert_close(blocks(stage.render(scene)[..., :3]), expected)


def test_with_osl_the_input_nodes_shows_the_same(blender, standard):
    fit = standard("velvet")
    scene, _ = sphere(fit)
    without = stage.render(scene)[..., :3]
    scene, material = sphere(fit, osl=True)
    stage.set_input(material, "Nodes", True)
    np.testing.assert_allclose(stage.render(scene)[..., :3], without, atol=2e-3 * without.max())


def test_tint_and_strength_multiply(blender, standard):
    fit = standard("aluminum foil")
    scene, material = sphere(fit)
    plain = stage.render(scene)[..., :3]
    stage.set_input(material, "Tint", (0.5, 0.2, 1.0, 1.0))
    stage.set_input(material, "Strength", 0.5)
    np.testing.assert_allclose(stage.render(scene)[..., :3], plain * [0.25, 0.1, 0.5], atol=1e-3 * plain.max())


@pytest.mark.parametrize("osl", [False, True])
def test_a_tint_below_zero_is_black(blender, standard, osl):
    """Sockets do not bound what nodes compute and connect."""
    scene, material = sphere(standard("aluminum foil"), osl)
    plain = stage.render(scene)[..., :3]
    stage.connect_vector(material, "Tint", (-1.0, 0.5, 1.0))
    tinted = stage.render(scene)[..., :3]
    assert (tinted[..., 0] == 0).all()
    np.testing.assert_allclose(tinted.mean(axis=(0, 1)), plain.mean(axis=(0, 1)) * [0, 0.5, 1], rtol=2e-3)


def test_a_normal_that_is_connected_is_the_one_that_is_seen(blender, standard):
    """A surface whose shading normal always looks up shows the same everywhere, that of a plate."""
    fit = standard("velvet")
    mixture = node_mixture.node_mixtures(fit).cycles
    scene, material = sphere(fit)
    stage.connect_vector(material, "Normal", (0, 0, 2))
    expected = math.pi * node_mixture.evaluate(mixture, np.array([0.0, 0, 1]), TOWARD[None])[0]
    picture = stage.render(scene)[..., :3]
    middle = picture[SIZE // 2 - 4:SIZE // 2 + 4, SIZE // 2 - 8:SIZE // 2]
    np.testing.assert_allclose(middle, np.broadcast_to(expected, middle.shape), rtol=0.01)


@release
@pytest.mark.parametrize("rotation", quick([0.0, 0.25, 0.6], 0.6))
def test_an_anisotropic_highlight_follows_tangent_and_rotation(blender, rotation):
    fit = brushed_fit()
    expected = integral(node_mixture.node_mixtures(fit).cycles, turn=2 * math.pi * rotation)
    scene, material = sphere(fit)
    stage.set_input(material, "Rotation", rotation)
    assert_close(blocks(stage.render(scene)[..., :3]), expected, within=0.05)


def test_a_plate_that_faces_the_viewer_has_no_undefined_pixel(blender, standard):
    """There, the plane of incidence and the tangent of lobes in it are undefined."""
    import bpy

    for fit in (standard("krylon_blue_RGB"), brushed_fit()):
        scene = stage.black_scene(16, 16, 4, span=1)
        scene.cycles.shading_system = False
        stage.background(scene, 1)
        bpy.ops.mesh.primitive_plane_add(size=4)
        bpy.context.object.data.materials.append(stage.material_for(fit))
        picture = stage.render(scene)[..., :3]
        assert np.isfinite(picture).all()
        assert (picture.max(axis=2) > 0).all()


def test_a_group_that_was_made_without_osl_renders_nodes_and_can_be_completed(blender, standard, monkeypatch):
    from measured_brdf.addon.core.blender import osl_support
    from measured_brdf.addon.core.shading import node_group

    fit = standard("velvet")
    with monkeypatch.context() as patched:
        patched.setattr(osl_support, "reason_unavailable", lambda: osl_support.NO_OSL)
        scene, material = sphere(fit, osl=True)
        tree = stage.group_node(material).node_tree
        assert node_group.version(tree) > 0
    assert node_group.version(tree) == 0, "a Blender that has OSL can compile it"
    assert_close(blocks(stage.render(scene)[..., :3]), integral(node_mixture.node_mixtures(fit).cycles))
