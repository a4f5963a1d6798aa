"""Whole pictures of spheres, through the add-on, against numerical integration of `Fit.evaluate`."""

import itertools
import math

import bpy
import numpy as np
import pytest

import fitter
from fitter.cycles.node_mixture import Nodes
from support import stage
from support.cases import quick, release
from support.known_lamps import POINTER, known
from support.mixtures import made_mixture
from support.spheres import normals, radial, reflected, reflected_on

from .test_shader_guards import plane

SIZE = 96
FROM_THE_LEFT = math.radians(60)
TOWARD = np.array([-math.sin(FROM_THE_LEFT), 0, math.cos(FROM_THE_LEFT)])
LAMP = np.array([-3.0, 0.0, 2.0])
POWER = 100.0
AREA_SIDE = 2.0


def sphere_scene(fit, samples, make=stage.osl_material_for):
    scene = stage.black_scene(SIZE, SIZE, samples, span=2)
    scene.cycles.max_bounces = 0
    stage.add_sphere().data.materials.append(make(fit))
    return scene


def mean_colour(scene):
    return stage.render(scene)[..., :3].mean(axis=(0, 1))


def picture_mean(values, resolution):
    return np.broadcast_to(values.sum(axis=0) / resolution**2, 3)


def reflected_by_sphere(fit, n, toward, turn):
    """As `reflected`, of a sphere with its own tangents, turned by an angle."""
    return reflected_on(fit, n, radial(n), np.broadcast_to(toward, n.shape), turn)


def mean_under_sun(fit, turn=0.0, angle=FROM_THE_LEFT):
    toward = np.array([-math.sin(angle), 0, math.cos(angle)])
    return picture_mean(reflected_by_sphere(fit, normals(400), toward, turn), 400)


def mean_under_point(fit, turn=0.0, resolution=400, at=LAMP):
    n = normals(resolution)
    away = at - n
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    light = reflected_by_sphere(fit, n, away / distance, turn) * POWER / (4 * math.pi * distance**2)
    return picture_mean(light, resolution)


def mean_under_area(fit, turn=0.0):
    facing = -LAMP / np.linalg.norm(LAMP)
    across = np.array([0.0, 1, 0])
    up = np.cross(facing, across)
    n = normals(100)
    steps = ((np.arange(12) + 0.5) / 12 - 0.5) * AREA_SIDE
    total = 0
    for s in steps:
        for t in steps:
            away = LAMP + s * across + t * up - n
            distance = np.linalg.norm(away, axis=1, keepdims=True)
            toward = away / distance
            form = (-toward @ facing)[:, None].clip(0) / distance**2
            total = total + reflected_by_sphere(fit, n, toward, turn) * form / len(steps) ** 2
    return picture_mean(total * POWER / math.pi, 100)


def mean_under_world(fit):
    theta_o = np.linspace(0, math.pi / 2, 91)[:, None, None]
    r = np.sqrt((np.arange(100) + 0.5) / 100)[:, None]
    phi = (np.arange(100) + 0.5) / 100 * math.pi
    albedo = math.pi * np.maximum(fit.evaluate(np.arcsin(r), 0, theta_o, phi), 0).mean(axis=(1, 2))
    at = np.arccos(normals(400)[:, 2])
    return picture_mean(np.stack([np.interp(at, theta_o.ravel(), column) for column in albedo.T], axis=1), 400)


def sun(**settings):
    stage.add_lamp("SUN", 1, rotation=(0, -FROM_THE_LEFT, 0), **settings)


def point(radius):
    stage.add_lamp("POINT", POWER, LAMP, shadow_soft_size=radius)


def area():
    stage.add_lamp("AREA", POWER, LAMP, (0, -math.atan2(3, 2), 0), shape="SQUARE", size=AREA_SIDE)


LIGHTS = {
    "world": (lambda: stage.background(bpy.context.scene, 1), mean_under_world, 48, 0.01),
    "sun": (lambda: sun(angle=math.radians(0.526)), mean_under_sun, 16, 0.01),
    "sun without a size": (lambda: sun(angle=0), mean_under_sun, 16, 0.01),
    "point lamp": (lambda: point(0.1), mean_under_point, 16, 0.01),
    "point lamp without a size": (lambda: point(0), mean_under_point, 16, 0.01),
    "area lamp": (area, mean_under_area, 192, 0.012),
}


@pytest.fixture(scope="module")
def fits(curet, cornell):
    return {"foil": fitter.fit(curet("aluminum foil")), "krylon": fitter.fit(cornell("krylon_blue_RGB"))}


@pytest.mark.parametrize(("material", "light"), quick(
    itertools.product(["foil", "krylon"], LIGHTS), ("foil", "world"), ("krylon", "sun"), ("krylon", "area lamp"),
    ("foil", "point lamp without a size")))
def test_the_mean_of_a_sphere_is_that_of_numerical_integration(blender, fits, material, light):
    set_up, integrate, samples, tolerance = LIGHTS[light]
    fit = fits[material]
    scene = sphere_scene(fit, samples)
    set_up()
    ratio = mean_colour(scene) / integrate(fit)
    print(f"{material}, {light}: rendered / integrated = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=tolerance)


def on_the_sphere(hole=0.0):
    """Pixels well inside of a sphere, and its normals there: (height, width) bool, (pixels, 3)."""
    x = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(x, -x)
    inside = (x**2 + y**2 < 0.9) & (x**2 + y**2 > hole)
    return inside, np.stack([x, y, np.sqrt(np.maximum(1 - x**2 - y**2, 0))], axis=-1)[inside]


def agree(picture, expected, n):
    lit = n @ TOWARD > 0.1
    error = np.abs(picture - expected)[lit] / (expected[lit] + 0.02 * expected.max())
    assert np.median(error) < 0.01
    assert np.quantile(error, 0.99) < 0.1


def test_a_sphere_under_the_sun_is_right_pixel_by_pixel(blender, fits):
    fit = fits["krylon"]
    scene = sphere_scene(fit, 16)
    sun(angle=0)
    inside, n = on_the_sphere()
    agree(stage.render(scene)[..., :3][inside], reflected(fit, n, np.broadcast_to(TOWARD, n.shape)), n)


def test_what_lies_beside_a_lobe_does_not_reach_its_lamp(blender, cornell):
    """A plane under a sun of a degree, where the fit is five times the mixture and a lobe has the rest: a sampled
    direction spreads by .08 degrees over the edge of the lobe."""
    fit = fitter.fit(cornell("cayman"))
    theta, radius = math.radians(33.7), math.radians(1.06)
    lamp = np.array([-math.sin(theta + 0.052), 0, math.cos(theta + 0.052)])
    scene = stage.black_scene(64, 64, 256, span=2)
    scene.cycles.max_bounces = 0
    scene.camera.location = 10 * math.sin(theta), 0, 10 * math.cos(theta)
    scene.camera.rotation_euler = stage.rotation_toward(scene.camera.location)
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.data.materials.append(stage.osl_material_for(fit))
    stage.add_lamp("SUN", 1, rotation=stage.rotation_toward(lamp), angle=2 * radius)
    r = radius * np.sqrt((np.arange(100) + 0.5) / 100)[:, None]
    turn = (np.arange(100) + 0.5) / 100 * 2 * math.pi
    across, up = np.array([0, 1.0, 0]), np.cross(lamp, [0, 1.0, 0])
    toward = (np.cos(r)[..., None] * lamp + np.sin(r)[..., None] * (
        np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * up)).reshape(-1, 3)
    f = fit.evaluate(np.arccos(toward[:, 2]), np.arctan2(toward[:, 1], toward[:, 0]), theta, 0)
    expected = (np.maximum(f, 0) * toward[:, 2:]).mean(axis=0)
    assert stage.render(scene)[..., 2].mean() == pytest.approx(expected[2], rel=0.004)


STALE = [((-0.5, 0.3, 0.8), -0.05, 1), ((1.0, 2.0, 3.0), 0.2, 5), ((2.0, 2.0, 1.0), 1.0, 5)]


def test_a_stale_lamp_costs_noise_and_not_correctness(blender, extension, fits):
    """Lobes remain where no lamp is any more: the sampled residual corrects them."""
    lamps = extension.addon.core.lamps
    means = []
    for stale in ([], STALE):
        scene = sphere_scene(fits["krylon"], 96)
        stage.background(scene, 1)
        blender.context.view_layer.update()
        lamps.unregister()
        try:
            lamps.carrier.reserve(scene[POINTER], len(stale))
            lamps.carrier.store(scene[POINTER], stale)
            lamps.group.store(lamps.node_tree(), len(stale), False)
            means.append(mean_colour(scene))
        finally:
            lamps.register()
        expected = np.array([[*position, *others] for position, *others in stale]).reshape(-1, 5)
        np.testing.assert_allclose(known(), expected, err_msg="not the stale lamps were rendered")
    np.testing.assert_allclose(means[1], means[0], rtol=0.005)


@pytest.mark.parametrize("material", quick(["foil", "krylon"], "krylon"))
@pytest.mark.parametrize(("light", "samples"), quick([("sun", 64), ("area lamp", 256)], ("sun", 64)))
def test_a_sphere_in_a_mirror_is_as_bright_as_the_sphere(blender, fits, material, light, samples):
    """Through what is sharp it is seen as from the camera."""
    fit = fits[material]
    scene = stage.black_scene(SIZE, SIZE, samples, span=2)
    scene.cycles.max_bounces = scene.cycles.glossy_bounces = 1
    mirror = stage.simple_material("Mirror", "ShaderNodeBsdfAnisotropic", {"Color": (1, 1, 1, 1), "Roughness": 0})
    blender.ops.mesh.primitive_plane_add(size=4, rotation=(0, math.pi / 4, 0))      # shows what is at +x
    blender.context.object.data.materials.append(mirror)
    sphere = stage.add_sphere()
    sphere.location = 10, 0, 0
    sphere.data.materials.append(stage.osl_material_for(fit))
    # as seen in the mirror, the lamp stands where it stands for the sphere that is seen directly
    _, integrate, _, tolerance = LIGHTS[light]
    if light == "sun":
        toward = (-math.cos(FROM_THE_LEFT), math.sin(FROM_THE_LEFT), 0)
        stage.add_lamp("SUN", 1, rotation=stage.rotation_toward(toward), angle=0)
    else:
        place = (10 - LAMP[2], 0.0, LAMP[0])
        stage.add_lamp("AREA", POWER, place, stage.rotation_toward(place, (10, 0, 0)), shape="SQUARE", size=AREA_SIDE)
    assert mean_colour(scene) / integrate(fit) == pytest.approx([1, 1, 1], abs=tolerance)


def seen_after_a_rough_bounce(fit, everywhere, samples):
    """The light that a measured sphere under a lamp throws on a white wall: the camera sees that wall alone."""
    scene = stage.black_scene(8, 8, samples, span=0.5)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 1
    bpy.ops.mesh.primitive_plane_add(size=1, location=(0, 0, -3))
    wall = stage.simple_material("Wall", "ShaderNodeBsdfDiffuse", {"Color": (1, 1, 1, 1)})
    bpy.context.object.data.materials.append(wall)
    sphere = stage.add_sphere()
    sphere.visible_camera = False
    sphere.data.materials.append(stage.osl_material_for(fit))
    stage.set_input(sphere.data.materials[0], "Exact Everywhere", everywhere)
    # from below, so that the wall has no light from it
    stage.add_lamp("AREA", 1000, (0.6, 0, -3.2), (math.pi, 0, 0), shape="SQUARE", size=0.5)
    stage.add_lamp("SUN", 3, rotation=stage.rotation_toward((-1, 0.3, -0.2)), angle=0.02)
    return stage.render(scene)[..., :3].astype(float)


def test_after_a_rough_bounce_the_mixture_has_the_light_of_the_fit(blender, fits):
    """Of foil. A wall that is lit from one side sees what the mixture misplaces, of krylon up to 5 % in a channel."""
    mixture, exact = (seen_after_a_rough_bounce(fits["foil"], everywhere, 1024) for everywhere in (False, True))
    ratio = mixture.mean(axis=(0, 1)) / exact.mean(axis=(0, 1))
    print(f"default / everywhere = {ratio}, least {mixture.min():.3g} {exact.min():.3g}")
    assert not np.array_equal(mixture, exact), "exact everywhere"
    assert ratio == pytest.approx([1, 1, 1], abs=0.01)


@pytest.mark.parametrize("material", quick(["foil", "krylon"], "foil"))
def test_in_a_room_of_it_the_mixture_has_the_light_of_the_fit(blender, fits, material):
    """The first surface is exact, and six bounces light it."""
    means = []
    for everywhere in (False, True):
        scene = stage.black_scene(16, 16, 400, span=2)
        scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 6
        scene.camera.location = 0, 0, 2.9
        bpy.ops.mesh.primitive_cube_add(size=6)
        walls = bpy.context.object.data
        walls.flip_normals()
        walls.materials.append(stage.osl_material_for(fits[material]))
        stage.set_input(walls.materials[0], "Exact Everywhere", everywhere)
        place = -2, 0, 1.5
        stage.add_lamp("AREA", 200, place, stage.rotation_toward(place, (3, 0, 0)), shape="SQUARE", size=1)
        means.append(mean_colour(scene))
    print(f"{material}: default / everywhere = {means[0] / means[1]}")
    assert means[0] == pytest.approx(means[1], rel=0.01)


def radiance_of_lamp(fit, seen_at, polar, half_side, is_inside, power):
    """What is seen at an angle of a flat lamp at a polar angle on the other side, 5 away and facing the point, by a sum
    over 400 x 400 places of the square about it."""
    steps = ((np.arange(400) + 0.5) / 200 - 1) * half_side
    across, up = (each.ravel() for each in np.meshgrid(steps, steps))
    middle, upward = np.array([math.sin(polar), 0, math.cos(polar)]), np.array([-math.cos(polar), 0, math.sin(polar)])
    toward = 5 * middle + across[:, None] * [0, 1, 0] + up[:, None] * upward
    toward = toward[is_inside(across, up)]
    distance = np.linalg.norm(toward, axis=1)
    toward /= distance[:, None]
    value = fit.evaluate(np.arccos(toward[:, 2]), np.arctan2(toward[:, 1], toward[:, 0]), seen_at, math.pi)
    form = toward[:, 2] * (toward @ middle) / distance**2
    return (np.maximum(value, 0) * form[:, None]).mean(axis=0) * power / math.pi


def seen_plane(fit, seen_at, samples):
    """A scene of a point of a plane that is seen at an angle."""
    scene = stage.black_scene(32, 32, samples, span=0.01)
    scene.cycles.max_bounces = 0
    scene.camera.location = -10 * math.sin(seen_at), 0, 10 * math.cos(seen_at)
    scene.camera.rotation_euler = stage.rotation_toward(scene.camera.location, (0, 0, 0))
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.data.materials.append(stage.osl_material_for(fit))
    return scene


@pytest.mark.parametrize(("preset", "shape", "seen_at", "polar"), quick(
    [("Standard", "SQUARE", 45, 45), ("Standard", "DISK", 45, 45), ("Standard", "SQUARE", 70, 70),
     ("Paper", "SQUARE", 75, 60)], ("Standard", "SQUARE", 45, 45), ("Paper", "SQUARE", 75, 60)))
def test_an_area_lamp_has_the_light_of_numerical_integration(blender, fits, standard, preset, shape, seen_at, polar):
    """Within .4 % in each channel, 3 % at grazing angles.

    Corrections that were left out where they are small took 2 % of krylon's green in the highlight; what a sampled
    direction may not take away was 11 % too much blue at grazing angles.
    """
    fit = standard("krylon_blue_RGB") if preset == "Standard" else fits["krylon"]
    seen_at, polar = math.radians(seen_at), math.radians(polar)
    scene = seen_plane(fit, seen_at, 256)
    at = 5 * np.array([math.sin(polar), 0, math.cos(polar)])
    stage.add_lamp("AREA", 300, at, stage.rotation_toward(at, (0, 0, 0)), shape=shape, size=2)
    inside = {"SQUARE": lambda x, y: x == x, "DISK": lambda x, y: x * x + y * y < 1}[shape]
    ratio = mean_colour(scene) / radiance_of_lamp(fit, seen_at, polar, 1, inside, 300)
    print(f"{shape}, lamp at {polar:.2f}, seen at {seen_at:.2f}: rendered / integrated = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=0.004 if preset == "Standard" else 0.03)


def test_two_area_lamps_have_the_light_of_numerical_integration(blender, standard):
    """Of which some samples have no light lobes and no directions, and the others more: within .4 % in each channel."""
    fit, seen_at = standard("krylon_blue_RGB"), math.radians(45)
    scene = seen_plane(fit, seen_at, 512)
    expected = 0
    for polar in np.radians([45, 10]):
        at = 5 * np.array([math.sin(polar), 0, math.cos(polar)])
        stage.add_lamp("AREA", 300, at, stage.rotation_toward(at, (0, 0, 0)), shape="SQUARE", size=2)
        expected = expected + radiance_of_lamp(fit, seen_at, polar, 1, lambda x, y: x == x, 300)
    ratio = mean_colour(scene) / expected
    print(f"two lamps: rendered / integrated = {ratio}")
    assert ratio == pytest.approx([1, 1, 1], abs=0.004)


@pytest.mark.parametrize("material", quick(["foil", "krylon"], "krylon"))
def test_what_is_taken_away_under_an_area_lamp_leaves_no_dark_pixel(blender, fits, material):
    """Krylon's red is 0 in two thirds of all pairs of directions: there a sum of what the mixture shows and of what
    sampled directions take away has a mean of 0, and its noise is on both sides."""
    scene = sphere_scene(fits[material], 64)
    area()
    picture = stage.render(scene)[..., :3]
    below = -np.minimum(picture, 0)
    most, all_of_it = below.max() / picture.mean(), below.sum() / picture.sum()
    print(f"{material}: {most:.3g} of the mean at most, {all_of_it:.3g} in all")
    assert most < 0.02
    assert all_of_it < 5e-6


def matte(albedo):
    """A fit of a Lambertian surface."""
    theta = np.linspace(0, 1.5, 12)
    theta_i, theta_o, phi_o = (grid.ravel() for grid in np.meshgrid(theta, theta, np.linspace(0, math.pi, 12)))
    values = np.tile(albedo / math.pi, (len(theta_i), 1))
    return fitter.fit(fitter.Samples(theta_i, np.zeros_like(theta_i), theta_o, phi_o, values, ("R", "G", "B")), 3, None)


def test_a_mixture_above_the_fit_is_not_seen_where_the_shader_is_exact(blender):
    """A matte plane whose red is four times as much in the mixture as in the fit, of which the colours below it have
    most: right, and nowhere below 0."""
    albedo = np.array([0.01, 0.5, 0.5])
    fit = matte(albedo)
    mixture = made_mixture()
    colour = np.zeros_like(mixture.colour)
    colour[:, 0] = albedo * [4, 1, 1]
    less = np.zeros_like(colour)
    less[:, 0] = 0.8 * albedo
    mixture = mixture._replace(colour=colour, sampling=mixture.sampling._replace(lower_colours=less))
    scene = stage.black_scene(16, 16, 16, span=0.1)
    scene.cycles.max_bounces = 0
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.data.materials.append(stage.material_for(fit, Nodes(mixture, mixture)))
    stage.add_lamp("SUN", 1, rotation=(0, -FROM_THE_LEFT, 0), angle=0.1)
    picture = stage.render(scene)[..., :3]
    assert picture.mean(axis=(0, 1)) == pytest.approx(albedo / math.pi * math.cos(FROM_THE_LEFT), rel=0.02)
    assert picture.min() >= 0


@pytest.mark.parametrize("apart", quick([0.0, 0.005, 0.03], 0.005))
def test_lamps_close_together_are_not_counted_twice(blender, fits, apart):
    fit = fits["foil"]
    scene = sphere_scene(fit, 16)
    for side in (-1, 1):
        stage.add_lamp("SUN", 0.5, rotation=(0, -FROM_THE_LEFT + side * apart / 2, 0), angle=0)
    assert mean_colour(scene) == pytest.approx(mean_under_sun(fit), rel=0.01)


def test_the_normal_input_turns_the_surface(blender, fits):
    """A plane whose shading normal leans toward the lamp is lit as a plane that leans."""
    fit = fits["krylon"]
    lean = math.radians(30)
    normal = np.array([-math.sin(lean), 0, math.cos(lean)])
    scene = plane(fit, 64, normal)
    sun(angle=0)
    assert mean_colour(scene) == pytest.approx(reflected(fit, normal[None], TOWARD[None])[0], rel=0.01)


def test_a_white_surface_neither_loses_nor_gains_light(blender):
    """A fit of albedo 1 returns the light of a white world, to about a percent."""
    fit = matte(np.ones(3))
    scene = sphere_scene(fit, 64)
    stage.background(scene, 1)
    expected = mean_under_world(fit).mean()
    assert expected == pytest.approx(math.pi / 4, rel=0.02)
    assert stage.render(scene)[..., :3].mean() == pytest.approx(expected, rel=0.005)


@release
def test_more_lamps_without_a_size_than_lobes_still_give_all_their_light(blender, fits):
    """The shader then chooses lamps at random; the expectation is their sum."""
    fit = fits["foil"]
    angles = np.radians(np.linspace(-50, 60, 12))
    scene = sphere_scene(fit, 128)
    for number, angle in enumerate(angles):
        stage.add_lamp("SUN", 1 + number % 3, rotation=(0, -angle, 0), angle=0)
    expected = sum((1 + number % 3) * mean_under_sun(fit, angle=angle) for number, angle in enumerate(angles))
    assert mean_colour(scene) == pytest.approx(expected, rel=0.005)


def test_tint_and_strength_multiply_what_is_rendered(blender, fits):
    scene = sphere_scene(fits["foil"], 16)
    sun(angle=0)
    before = mean_colour(scene)
    material = blender.context.object.data.materials[0]
    stage.set_input(material, "Tint", (0.5, 0.25, 1, 1))
    stage.set_input(material, "Strength", 0.5)
    np.testing.assert_allclose(mean_colour(scene) / before, [0.25, 0.125, 0.5], rtol=2e-3)


def test_back_faces_and_uneven_scales_are_lit_as_the_surface_they_show(blender, fits):
    means = []
    for turn, scale in ((0, (1, 1, 1)), (math.pi, (1, 1, 1)), (0, (3, 0.5, 2))):
        scene = stage.black_scene(8, 8, samples=64, span=0.5)
        sun(angle=0)
        blender.ops.mesh.primitive_plane_add(size=4, rotation=(turn, 0, 0))
        blender.context.object.scale = scale
        blender.context.object.data.materials.append(stage.osl_material_for(fits["krylon"]))
        means.append(stage.render(scene)[..., :3].mean())
    assert means[1] == pytest.approx(means[0], rel=2e-3)
    assert means[2] == pytest.approx(means[0], rel=2e-3)


def test_light_from_below_the_horizon_does_not_leak(blender, fits):
    """Lobes extend below the horizon; light from there must not shine through a plane."""
    scene = stage.black_scene(8, 8, samples=64, span=0.5)
    scene.camera.rotation_euler, scene.camera.location = (1.3, 0, 0), (0, -9, 2.5)
    blender.ops.mesh.primitive_plane_add(size=4)
    blender.context.object.data.materials.append(stage.osl_material_for(fits["foil"]))
    stage.add_lamp("SUN", 1, rotation=(-math.radians(95), 0, 0), angle=0.1)
    assert stage.render(scene)[..., :3].mean() < 1e-3


def sphere_far_away(fit, distance):
    """The mean of a sphere in an even world, (channels,), `distance` from the origin."""
    scene = stage.black_scene(SIZE, SIZE, 64, span=2)
    scene.camera.data.type, scene.camera.data.lens, scene.camera.location = "PERSP", 100, (distance, 0, 8)
    stage.background(scene, 1)
    sphere = stage.add_sphere()
    sphere.location = distance, 0, 0
    sphere.data.materials.append(stage.osl_material_for(fit))
    return mean_colour(scene)


@release
def test_ten_kilometres_from_the_origin_a_sphere_is_what_it_is_there(blender, fits):
    assert sphere_far_away(fits["foil"], 1e4) == pytest.approx(sphere_far_away(fits["foil"], 0), rel=3e-3)
