"""Edge cases of the shader: directions on an axis, on the horizon and below it, and avoidable noise.

Planes and parts of the shader, against integrals of `Fit.evaluate` and geometry in NumPy.
"""

import dataclasses
import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix

import fitter
from fitter.cycles import node_lobes
from fitter.cycles.node_mixture import Nodes, cycles_mixture
from fitter.shader_constants import KNOTS
from support import stage
from support.cases import quick
from support.made_fits import MADE_FITS
from support.spheres import reflected

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def foil(curet):
    return fitter.fit(curet("aluminum foil"))


def leaning(degrees, azimuth=180.0):
    """A unit vector at an angle to the z axis."""
    theta, phi = math.radians(degrees), math.radians(azimuth)
    return np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)])


def add_sun(direction, strength=1.0, angle=0.0):
    stage.add_lamp("SUN", strength, rotation=stage.rotation_toward(direction), angle=angle)


def plane(fit, samples, normal=None, size=8, make=stage.osl_material_for):
    """A plane that fills the picture, its normal toward the viewer; its shading normal may be given."""
    scene = stage.black_scene(size, size, samples, span=0.5)
    scene.cycles.max_bounces = 0
    bpy.ops.mesh.primitive_plane_add(size=4)
    material = make(fit)
    bpy.context.object.data.materials.append(material)
    if normal is not None:
        stage.connect_vector(material, "Normal", normal)
    return scene


def material_of_what_is_left(fit):
    """A material whose mixture shows nothing where the shader is exact: lobes and sampled directions carry the fit."""
    mixture = cycles_mixture(fit)
    below = np.zeros_like(mixture.sampling.lower_colours)
    sampling = mixture.sampling._replace(lower_colours=below, balance=np.ones_like(mixture.sampling.balance))
    mixture = mixture._replace(sampling=sampling)
    return stage.material_for(fit, Nodes(mixture, mixture))


def colours(scene):
    """(pixels, 3)"""
    return stage.render(scene)[..., :3].reshape(-1, 3).astype(float)


def over_disk(fit, normal, toward, radius, seen=lambda w: np.ones(len(w))):
    """Mean of what is reflected over a sun's disk, of which only a part may be seen: (channels,)."""
    across = np.cross(toward, leaning(37, 20))
    across /= np.linalg.norm(across)
    r = radius * np.sqrt((np.arange(60) + 0.5) / 60)[:, None]
    turn = 2 * np.pi * (np.arange(90) + 0.5) / 90
    w = toward + (np.tan(r) * np.cos(turn))[..., None] * across + (np.tan(r) * np.sin(turn))[..., None] * np.cross(
        toward, across)
    w = (w / np.linalg.norm(w, axis=-1, keepdims=True)).reshape(-1, 3)
    return (reflected(fit, np.broadcast_to(normal, w.shape), w) * seen(w)[:, None]).mean(axis=0)


@pytest.mark.parametrize("turned", [Matrix(), Matrix(((0, 0, 1, 0), (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 0, 1)))])
def test_a_viewer_on_the_normal_sees_what_was_measured(blender, foil, turned):
    """The direction to the viewer has no azimuth; the normal is along z or along x."""
    scene = plane(foil, 4)
    toward = leaning(40, 130)
    add_sun(toward)
    for item in scene.objects:
        if item.type == "MESH":
            item.data.transform(turned)     # exactly: rotations of objects are rounded
        else:
            item.matrix_world = turned @ item.matrix_basis
    expected = reflected(foil, UP[None], toward[None])
    assert colours(scene) == pytest.approx(np.broadcast_to(expected, (64, 3)), rel=2e-4)


def test_a_normal_that_is_turned_away_is_seen_at_grazing_incidence(blender, foil):
    scene = plane(foil, 4, leaning(100))
    toward = leaning(60)
    add_sun(toward)
    expected = reflected(foil, leaning(89.94)[None], toward[None])
    assert colours(scene) == pytest.approx(np.broadcast_to(expected, (64, 3)), rel=0.02)


@pytest.mark.parametrize("angle", [0.0, 0.02])
def test_below_the_horizon_of_the_shading_normal_a_lamp_gives_what_tilted_lobes_have_there(blender, foil, angle):
    """Cycles evaluates closures below it, where their own normals lean toward the lamp; nothing else is added."""
    scene = plane(foil, 64, leaning(40, 0))
    add_sun(leaning(54), angle=angle)
    mixture, seen_at = cycles_mixture(foil), math.radians(40)
    pairs = node_lobes.Pairs.make(leaning(40, 0), leaning(94, 0)[None], np.array([1.0, 0, 0]))
    expected = 0.0
    for lobe, kind in enumerate(mixture.kinds):
        *shape, colour = (np.interp(seen_at, mixture.theta, each) for each in (
            *(number[:, lobe] for number in mixture.shape), mixture.sampling.lower_colours[:, lobe, 0, 0]))
        expected += colour * node_lobes.evaluate(kind, node_lobes.Shape(*map(np.array, shape)), pairs)[0]
    assert expected < 1e-5
    assert colours(scene) == pytest.approx(np.full((64, 3), expected), rel=0.01)


@pytest.mark.parametrize("below", [-1.0, 1.0])
def test_a_lamp_that_stands_half_below_the_horizon_gives_what_is_above_it(blender, foil, below):
    normal, toward = leaning(40, 0), leaning(50 + below)
    scene = plane(foil, 256, normal, size=16)
    add_sun(toward, angle=0.1)
    expected = over_disk(foil, normal, toward, 0.05)
    assert colours(scene).mean(axis=0) == pytest.approx(np.broadcast_to(expected, 3), rel=0.05)


def test_a_lamp_on_the_normal_is_reflected_from_all_of_its_disk(blender, foil):
    scene = plane(foil, 512)
    viewer = leaning(30, 0)
    scene.camera.location, scene.camera.rotation_euler = 10 * viewer, (0, math.radians(30), 0)
    add_sun(UP, angle=0.11)
    normal = leaning(30)                # as seen from above, for `reflected`
    expected = over_disk(foil, normal, normal, 0.055)
    assert abs(expected / reflected(foil, normal[None], normal[None])[0] - 1).max() > 0.1, "its middle would do"
    assert colours(scene).mean(axis=0) == pytest.approx(np.broadcast_to(expected, 3), rel=0.01)


@pytest.mark.parametrize("radius", quick([0.95, 3.2], 3.2))
@pytest.mark.parametrize("side", quick([-1, 1], 1))
def test_a_lamp_that_is_half_hidden_is_reflected_from_the_half_that_is_seen(blender, cornell, radius, side):
    """On the flank of a highlight, where the halves differ. A far wall hides one of them."""
    fit = fitter.fit(cornell("krylon_blue_RGB"))
    normal, toward, radius = leaning(20), leaning(47), math.radians(radius)
    scene = plane(fit, 1024, normal, size=8)
    scene.camera.data.ortho_scale = 0.1
    across = np.array([toward[2], 0, -toward[0]])           # in the plane of incidence, perpendicular to `toward`

    def seen(w):
        return side * (w @ across) > 0

    half = over_disk(fit, normal, toward, radius, seen)
    whole = over_disk(fit, normal, toward, radius)
    if radius > 0.05:
        assert np.abs(half / (whole / 2) - 1).max() > 0.05, "the halves are alike"
    add_sun(toward, angle=2 * radius)
    frame = Matrix.Identity(4)
    for column, axis in enumerate((across, np.cross(toward, across), toward)):
        frame.col[column][:3] = axis
    bpy.ops.mesh.primitive_plane_add(size=2000)
    wall = bpy.context.object
    wall.matrix_world = Matrix.Translation(5000 * toward - side * 1000 * across) @ frame
    wall.visible_camera = False
    wall.data.materials.append(stage.blank_material("Wall", "ShaderNodeBsdfDiffuse")[0])
    found = colours(scene).mean(axis=0)
    assert found == pytest.approx(half, rel=0.02)


@pytest.mark.parametrize("seed", quick(range(4), 2))
def test_nothing_is_subtracted_under_even_light_and_small_lamps(blender, foil, standard, seed):
    """But where a sampled direction spreads: one in the skirt of a lobe takes its share away, and 1e-14 of the mean at
    the lamp beside it, which krylon's red hardly has more of."""
    for fit in (foil, standard("krylon_blue_RGB")):
        scene = stage.black_scene(64, 64, 4, span=2)
        scene.cycles.seed = seed
        stage.add_sphere().data.materials.append(stage.osl_material_for(fit))
        stage.background(scene, 0.2)
        add_sun(leaning(50))
        stage.add_lamp("POINT", 50, (2, -2, 2), shadow_soft_size=0)
        picture = stage.render(scene)[..., :3]
        assert picture.mean() > 0.01
        assert picture.min() > -1e-10 * picture.mean()


@pytest.mark.parametrize("apart", [0.0, 0.2])
def test_two_lamps_in_one_place_give_twice_the_light_where_the_mixture_is_not_the_fit(blender, foil, apart):
    """The lobe of the second carries only what that of the first leaves."""
    normal = leaning(70, 0)
    scene = plane(foil, 64, normal)
    lamps = [leaning(10 + apart * side, 0) for side in (-1, 1)]
    for toward in lamps:
        add_sun(toward)
    expected = sum(reflected(foil, normal[None], toward[None])[0] for toward in lamps)
    assert colours(scene).mean(axis=0) == pytest.approx(np.broadcast_to(expected, 3), rel=0.02)


@pytest.mark.parametrize("angle", quick([0.002, 0.005, 0.0093], 0.0093))
def test_a_sun_is_rendered_in_the_mean_over_its_disk(blender, foil, angle):
    """Its lobe alone renders it, and a picture has the same error everywhere."""
    scene = plane(foil, 256)
    toward = leaning(40, 130)
    add_sun(toward, angle=angle)
    expected = over_disk(foil, UP, toward, angle / 2)
    assert colours(scene).mean(axis=0) == pytest.approx(np.broadcast_to(expected, 3), rel=1e-3)


def test_lamps_are_known_as_long_as_a_part_of_them_is_above_the_horizon(probe, foil):
    """Suns and balls at elevations about their radius; a point inside a ball sees it everywhere."""
    radius = np.tile([0.0, 0.05, 0.3], 7)
    elevation = np.repeat([-0.4, -0.2, -0.03, 0.02, 0.06, 0.5, 1.5], 3)
    upright = """ShadingFrame frame;
        frame.x = vector(1.0, 0.0, 0.0); frame.y = vector(0.0, 1.0, 0.0); frame.z = vector(0.0, 0.0, 1.0);
        frame.wo = normalize(vector(0.6, 0.3, 0.8));"""
    code = """if (pixel < 21) {
        float e = ELEVATION[pixel], s = max(RADIUS[pixel], 1e-6);
        LampList suns, balls;
        suns.count = balls.count = 0;
        vector w = vector(cos(e), 0.0, sin(e));
        add_lamp(w, vector(-s, 2.0, 0.0), point(1.0), frame, suns);
        add_lamp(point(1.0) + 10.0 * w, vector(10.0 * sin(s), 2.0, 0.0), point(1.0), frame, balls);
        out = color(suns.count, balls.count, balls.count * balls.light[0]); }"""
    suns, balls, light = probe(foil, upright + code, 21, ELEVATION=elevation, RADIUS=radius).T
    above = elevation > -radius
    assert 5 < above.sum() < 20
    np.testing.assert_array_equal(suns, above)
    np.testing.assert_array_equal(balls, above)
    assert (light[above] > 0).all(), "lamps are taken by their light"
    inside = """LampList lamps;
        lamps.count = 0;
        add_lamp(point(1.3, 1.0, 0.5), vector(1.0, 2.0, 0.0), point(1.0), frame, lamps);
        out = color(lamps.count, lamps.radius[0], 0.0);"""
    np.testing.assert_allclose(probe(foil, upright + inside, 1)[0, :2], [1, np.pi / 2], rtol=1e-6)
    dark = """LampList lamps;
        lamps.count = 0;
        add_lamp(vector(0.0, 0.0, 1.0), vector(-0.3, 0.0, 0.0), point(1.0), frame, lamps);
        add_lamp(vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.0), point(0.0, 0.0, -1.0), frame, lamps);
        out = lamps.count;"""
    assert probe(foil, upright + dark, 1)[0, 0] == 0, "a lamp that does not shine, and zeros, are none"


def test_a_lamp_without_a_size_adds_no_noise(blender, foil):
    """Its lobe is exact, and sampling does not follow it instead of closures that find other light."""
    noise = []
    for strength in (0, 5):
        scene = plane(foil, 16, size=32)
        stage.background(scene, 1)
        add_sun(leaning(50, 200), strength)
        noise.append(colours(scene).std())
    assert noise[1] < 1.2 * noise[0]


def test_a_lamp_near_the_horizon_adds_no_more_noise_than_one_whose_middle_is_on_it(blender, foil):
    """Directions below the horizon carry nothing: a path that follows one is lost to the world."""
    noise = []
    for elevation in (0.0, 0.05):
        scene = plane(foil, 32, size=32)
        stage.background(scene, 1)
        add_sun(leaning(90 - math.degrees(elevation)), angle=0.2)
        noise.append(colours(scene).std())
    assert noise[1] < 1.2 * noise[0]


def test_beside_a_lamp_the_rest_of_the_world_gives_all_of_its_light(blender, foil):
    """Of the directions that carry all of the fit, most are taken about a lamp that hardly shines."""
    scene = plane(foil, 256, size=32, make=material_of_what_is_left)
    stage.background(scene, 1)
    add_sun(leaning(60), 1e-4, angle=0.6)
    r, phi = np.sqrt((np.arange(200) + 0.5) / 200)[:, None], (np.arange(100) + 0.5) / 100 * math.pi
    albedo = math.pi * foil.evaluate(np.arcsin(r), 0, 0, phi).mean(axis=(0, 1))
    assert colours(scene).mean(axis=0) == pytest.approx(np.broadcast_to(albedo, 3), rel=0.02)


def test_a_small_lamp_is_not_drawn_at_as_well(blender, foil):
    """The residual is 0 there: it would add nothing in the mean, and fireflies to a picture."""
    pictures = []
    for seed in (1, 2):
        scene = stage.black_scene(96, 96, 16, span=2)
        scene.cycles.max_bounces, scene.cycles.seed = 0, seed
        stage.add_sphere().data.materials.append(stage.osl_material_for(foil))
        add_sun(leaning(56), angle=0.0093)
        pictures.append(stage.render(scene)[..., :3])
    assert np.std(pictures[1] - pictures[0]) < 0.02 * pictures[0].mean()


def test_the_lobe_of_a_lamp_without_a_size_is_as_high_as_the_fit_in_every_pixel(blender, foil):
    """Cosines that round to more than 1 are not raised to the exponent of a lobe: on facets of a thousand normals."""
    side = 32
    scene = stage.black_scene(side, side, 4, span=side)
    scene.cycles.max_bounces, scene.cycles.pixel_filter_type = 0, "BOX"
    random = np.random.default_rng(1)
    n = random.uniform(-0.5, 0.5, (side * side, 3)) + [-0.3, 0, 1.2]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = (np.indices((side, side)).reshape(2, -1)[::-1].T + 0.5 - side / 2)[:, None]
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    height = -(corners[None] * n[:, None, :2]).sum(axis=-1) / n[:, 2:]
    vertices = np.concatenate([middle + corners, height[..., None]], axis=-1).reshape(-1, 3)
    mesh = bpy.data.meshes.new("facets")
    mesh.from_pydata(vertices.tolist(), [], np.arange(len(vertices)).reshape(-1, 4).tolist())
    mesh.materials.append(material_of_what_is_left(foil))
    scene.collection.objects.link(bpy.data.objects.new("facets", mesh))
    toward = leaning(40)
    add_sun(toward)
    next(each for each in scene.objects if each.type == "LIGHT").data.use_shadow = False    # of a facet on others
    found = stage.render(scene)[::-1, :, 0].reshape(-1)
    expected = reflected(foil, n, np.broadcast_to(toward, n.shape)).mean(axis=-1)
    assert found == pytest.approx(expected, rel=3e-4)


LAMPS = """LampList lamps;
    lamps.count = 3;
    for (int i = 0; i < 3; i++) {
      lamps.direction[i] = vector(DIRECTION[3 * i], DIRECTION[3 * i + 1], DIRECTION[3 * i + 2]);
      lamps.radius[i] = RADIUS[i];
      lamps.light[i] = 1.0;
    }
"""


def lamps_of(*lamps):
    """Tables for `LAMPS`, of three pairs of a direction and a radius."""
    return {"DIRECTION": np.array([direction for direction, _ in lamps]), "RADIUS": np.array([r for _, r in lamps])}


def test_a_lobe_stands_at_lamps_whose_middle_is_seen_and_that_are_not_wide(probe, foil):
    around = lamps_of((leaning(50), 0.5), (leaning(91), 0.5), (leaning(50), 0.9))
    found = probe(foil, LAMPS + "out = color(has_lobe(lamps, 0), has_lobe(lamps, 1), has_lobe(lamps, 2));", 1, **around)
    np.testing.assert_array_equal(found[0], [1, 0, 0])


def test_directions_are_sampled_about_lamps_only_where_one_of_them_is_large(probe, foil):
    share = """Mixture mixture;
      interpolate_mixture(MIXTURE, vector(0.6, 0.0, 0.8), 1, mixture);
      ResidualPlan all = plan_residual(mixture, lamps, 0, point(0.5));
      lamps.count = 0;
      ResidualPlan none = plan_residual(mixture, lamps, 0, point(0.5));
      out = color(all.toward_lamp, none.toward_lamp, 0.0);"""
    up = leaning(0)
    small, large = (probe(foil, LAMPS + share, 1, **lamps_of((up, 0.0), (up, radius), (leaning(50), 0.004)))[0]
                    for radius in (0.003, 0.05))
    np.testing.assert_array_equal(small, 0)
    assert large[0] > 0.1
    assert large[1] == 0


def test_the_light_of_a_lamp_on_the_horizon_is_about_its_irradiance(probe, foil):
    """By which one of several is chosen: against a sum over its disk."""
    elevation = np.array([-0.1, -0.05, 0.0, 0.1, 0.5, 1.5])
    radius = 0.3
    code = """if (pixel < 6) {
        ShadingFrame frame;
        frame.x = vector(1.0, 0.0, 0.0); frame.y = vector(0.0, 1.0, 0.0); frame.z = vector(0.0, 0.0, 1.0);
        LampList lamps;
        lamps.count = 0;
        add_lamp(vector(cos(ELEVATION[pixel]), 0.0, sin(ELEVATION[pixel])), vector(-0.3, 2.0, 0.0), point(0.0), frame,
                 lamps);
        out = lamps.light[0]; }"""
    light = probe(foil, code, 6, ELEVATION=elevation)[:, 0]
    r = radius * np.sqrt((np.arange(200) + 0.5) / 200)[:, None]
    turn = 2 * np.pi * (np.arange(200) + 0.5) / 200
    height = np.cos(r) * np.sin(elevation)[:, None, None] + np.sin(r) * np.cos(turn) * np.cos(elevation)[:, None, None]
    irradiance = 2 * np.maximum(height, 0).mean(axis=(1, 2))       # of a strength of 2
    assert np.abs(np.log(light / irradiance)).max() < np.log(5)
    assert light[-1] == pytest.approx(irradiance[-1], rel=0.05)


def test_the_lobe_of_a_small_lamp_covers_its_disk_and_not_what_is_beside_it(probe, foil):
    angles = np.array([0.0, 0.004, 0.01, 0.04, 0.1, 1.0])
    code = LAMPS + "if (pixel < 6) { out = lobe_covers(lamps, vector(sin(ANGLE[pixel]), 0.0, cos(ANGLE[pixel]))); }"
    lamps = [(leaning(0), 0.004), (leaning(0), 0.3), (leaning(100), 0.3)]
    np.testing.assert_array_equal(probe(foil, code, 6, ANGLE=angles, **lamps_of(*lamps))[:, 0], [1, 1, 1, 0, 0, 0])


def test_the_lobe_of_a_small_lamp_is_as_high_as_what_is_left_there(probe, foil):
    """Its axis is beside the lamp, which shows where the half vector leans."""
    code = LAMPS + """
      LightLobes lobes;
      Evaluated all;
      Mixture mixture;
      float times[MAX_LAMPS];
      interpolate_mixture(MIXTURE, normalize(vector(0.995, 0.0, 0.1)), 1, mixture);
      for (int i = 0; i < 3; i++) {
        all.direction[i] = lamps.direction[i]; all.needed[i] = i == 0; times[i] = 1.0; all.residual[i] = 1.0;
      }
      fit_light_lobes(FLAT_RAMP, lamps, all, mixture, times, lobes);
      vector l = lamps.direction[0];
      vector axis = lobes.axis[0], half = mixture.wo + axis;
      out = eval_lobes(FLAT_RAMP, lobes, mixture.wo, l);
      out[1] = lobes.height[0][0] * dot(half, l) / dot(half, axis);"""
    around = lamps_of((leaning(84.0, 170.0), 0.0), (leaning(10), 0.0), (leaning(20), 0.0))
    found = probe(foil, code, 1, **around)[0]
    assert found[1] == pytest.approx(1, abs=1e-4)
    assert found[0] == pytest.approx(1, abs=3e-3)


def test_a_lobe_is_as_high_beyond_its_last_knot_and_nothing_behind_it(probe, foil):
    """Cosines round to more than 1, and a ramp has no knot there: what follows it in memory is not read."""
    ramp = np.array([1.0] * KNOTS + [1e9])
    code = """
      LightLobes lobes;
      lobes.count = 1; lobes.axis[0] = vector(0.0, 0.0, 1.0); lobes.exponent[0] = 4.0; lobes.height[0] = 1.0;
      lobes.present[0] = 1;
      color ahead = eval_lobes(RAMP, lobes, vector(0.0, 0.0, 1.0), vector(0.0, 0.0, 1.000001));
      color behind = eval_lobes(RAMP, lobes, vector(0.0, 0.8, 0.6), vector(0.0, 0.6, -0.8));
      out = color(ahead[0], fabs(behind[0]), 0.0);"""
    assert probe(foil, code, 1, RAMP=ramp)[0] == pytest.approx([1, 0, 0], abs=1e-4)


def test_only_lobes_that_were_taken_are_left(probe, foil):
    """Of others the height was needed."""
    code = """LightLobes lobes;
      lobes.count = 4;
      for (int i = 0; i < 4; i++) { lobes.axis[i] = vector(0.0, 0.0, 1.0); lobes.exponent[i] = 1.0;
        lobes.height[i] = i; lobes.times[i] = 3.0 * (i % 2); }
      keep_sampled_lobes(lobes);
      out = color(lobes.present[0] + 2 * lobes.present[1] + 4 * lobes.present[2] + 8 * lobes.present[3],
                  lobes.height[1][0], lobes.height[3][0]);"""
    np.testing.assert_array_equal(probe(foil, code, 1)[0], [2 + 8, 3, 9])


def test_the_last_coordinate_is_in_the_last_cell_and_the_last_view_between_the_last_stops(probe, foil):
    """A coordinate of 1 for an odd number of cells, what rounds beyond it for an even one; a view at the horizon."""
    code = """float w[4], odd[4];
      int knot;
      float t = locate_polar_knot(vector(1.0, 0.0, 0.0), knot);
      out = color(locate_cell(1.0000001, 16, 0, w) + w[3], locate_cell(1.0, 17, 0, odd) + odd[3],
                  10 * (POLAR_KNOTS - knot) + t);"""
    np.testing.assert_allclose(probe(foil, code, 1)[0], [7 + 1 / 6, 8 + 1 / 6, 21], rtol=1e-5)


def test_a_field_that_overflows_has_the_hue_of_the_ceiling(probe):
    """Where the prior is high too, as at a mirror's peak."""
    fit = MADE_FITS["Rusinkiewicz"]
    points = fit.diffuse.control_points + np.float32(200)
    prior = dataclasses.replace(fit.transform.prior, kd=np.array([1e3, 2e3, 4e3]))
    high = dataclasses.replace(fit.transform, prior=prior)
    steep = dataclasses.replace(fit, transform=high, diffuse=dataclasses.replace(fit.diffuse, control_points=points))
    found = probe(steep, "out = eval_fit(FIT, vector(0.6, 0.0, 0.8), vector(0.0, 0.6, 0.8));", 1)[0]
    directions = (np.array([angle]) for angle in (np.arcsin(0.6), 0, np.arcsin(0.6), np.pi / 2))
    hue = high.prior.evaluate(*directions)[0] + high.offset         # times exp(40)
    assert found == pytest.approx(hue / (hue / high.ceiling).max(), rel=1e-4)
