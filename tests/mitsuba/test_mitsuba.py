"""Pictures of measured materials beside those of Mitsuba 3, which evaluates the same fits: `make test-mitsuba`.

Both renderers make two pictures of each scene. Their difference in blocks of 8 x 8 pixels, less the noise that the two
pictures of each show, is what is wrong.
"""

import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

import fitter
from support import checkout, stage

pytest.importorskip("mitsuba", reason="Mitsuba is absent; `make test-mitsuba` installs it")
SIZE, BLOCK, SEEDS = 64, 8, (1, 2)


@pytest.fixture(scope="module")
def fits(curet, cornell):
    """Three fits by the paper's method, (4,6,95), and the albedo of a Lambertian surface."""
    return {"krylon": fitter.fit(cornell("krylon_blue_RGB")), "cayman": fitter.fit(cornell("cayman")),
            "foil": fitter.fit(curet("aluminum foil"), 4, 6, 95), "white": 0.8}


def material(fits, name):
    if name in bpy.data.materials:
        return bpy.data.materials[name]
    if name == "white":
        return stage.simple_material(name, "ShaderNodeBsdfDiffuse", {"Color": (fits[name],) * 3 + (1,)})
    made = stage.material_for(fits[name])
    made.name = name
    return made


def scene_of(samples=256, bounces=0, span=2.2):
    scene = stage.black_scene(SIZE, SIZE, samples, span)
    cycles = scene.cycles
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.pixel_filter_type = "BOX"
    return scene


def point_lamp(energy, location, radius):
    lamp = stage.add_lamp("POINT", energy, location, shadow_soft_size=radius)
    lamp.data.use_soft_falloff = False          # a ball, as in Mitsuba
    return lamp


def image(*windows):
    """A dim world with windows: (longitude, latitude, width, height, radiance), degrees."""
    longitude, latitude = np.meshgrid((np.arange(1024) + 0.5) / 1024 * 360 - 180,
                                      (np.arange(512) + 0.5) / 512 * 180 - 90)
    radiance = np.full(longitude.shape, 0.05)
    for at, up, width, height, strength in windows:
        radiance[(np.abs(longitude - at) < width / 2) & (np.abs(latitude - up) < height / 2)] = strength
    stage.sky_image(radiance)


def sphere(fits, name):
    stage.add_sphere().data.materials.append(material(fits, name))


def suzanne(fits, name):
    """Flat faces: where interpolated normals and faces disagree, renderers differ."""
    bpy.ops.mesh.primitive_monkey_add(size=1.5, rotation=(-1.2, 0, 0.3))
    modifier = bpy.context.object.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 2
    bpy.context.object.data.materials.append(material(fits, name))


def plane(fits, name, size=8, location=(0, 0, 0), rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    bpy.context.object.data.materials.append(material(fits, name))


def even_world(fits, name):
    scene_of()
    sphere(fits, name)
    stage.background(bpy.context.scene, 1, (1, 0.7, 0.4))


def ball_light():
    point_lamp(100, (3, 2, 4), 0.3)


def area_light():
    stage.add_lamp("AREA", 100, (3, 1, 4), stage.rotation_toward((3, 1, 4)), shape="RECTANGLE", size=2, size_y=1)


def sun(fits, name):
    scene_of()
    suzanne(fits, name)
    stage.add_lamp("SUN", 2, rotation=(0.5, 0.7, 0))


def ball_lamp(fits, name):
    scene_of()
    suzanne(fits, name)
    ball_light()


def area_lamp(fits, name):
    scene_of()
    suzanne(fits, name)
    area_light()


def window_in_an_image(fits, name):
    """Of 1.2 x 5.2 degrees."""
    scene_of(1024)
    sphere(fits, name)
    image((-60, 40, 1.2, 5.2, 300))


def grazing_under_a_spot(fits, name):
    """Seen at about 80 degrees, under an image with a spot of 3 degrees."""
    scene_of()
    plane(fits, name)
    image((90, 12, 3, 3, 300))
    stage.look((0, -6, 1.05), (0, 0, 0), 150)


def strip_lamp(fits, name):
    """Of .34 x .01 m, at 3 m."""
    scene_of()
    sphere(fits, name)
    at = Vector((1.5, 1, 2.4))
    stage.add_lamp("AREA", 30, at, stage.rotation_toward(at), shape="RECTANGLE", size=0.34, size_y=0.01)


def half_hidden_lamp(fits, name):
    """Of 1.9 degrees, reflected, and half behind a black board."""
    scene_of(1024)
    plane(fits, name)
    stage.look((-4, 0, 6), lens=200)
    at = Vector((2, 0, 3))
    point_lamp(50, at, at.length * math.sin(math.radians(1.9)))
    board, _, _ = stage.blank_material("black", "ShaderNodeEmission")
    bpy.ops.mesh.primitive_plane_add(size=1, rotation=stage.rotation_toward(at))
    bpy.context.object.location = at * 0.9 + Vector((0, 0.5, 0))
    bpy.context.object.data.materials.append(board)


def grazing_under_an_area_lamp(fits, name):
    """Seen at about 80 degrees, under a lamp of 2 m."""
    scene_of(512)
    plane(fits, name)
    stage.add_lamp("AREA", 300, (0, 4, 3), stage.rotation_toward((0, 4, 3)), shape="SQUARE", size=2)
    stage.look((0, -6, 1.05), (0, 0, 0), 150)


def exact_room(fits, name):
    """The room, exact after rough bounces too."""
    room(fits, name)
    stage.set_input(bpy.data.materials[name], "Exact Everywhere", True)


def room(fits, name):
    """Measured floor and walls, a white ceiling, light from where the fourth wall is missing, and six bounces."""
    scene_of(256, 6)
    plane(fits, name, 4)
    plane(fits, "white", 4, (0, 0, 4), (math.pi, 0, 0))
    for angle in (-math.pi / 2, 0, math.pi / 2):
        plane(fits, name, 4, (2 * math.sin(angle), 2 * math.cos(angle), 2), (math.pi / 2, 0, -angle))
    stage.background(bpy.context.scene, 1, (0.7, 0.85, 1))
    stage.add_lamp("SUN", 3, rotation=stage.rotation_toward((0.5, -1, 0.9)))
    stage.look((0, -5, 2), (0, 0, 2), 40)


CASES = [(even_world, "krylon"), (even_world, "foil"), (sun, "krylon"), (ball_lamp, "krylon"), (area_lamp, "krylon"),
         (area_lamp, "foil"), (window_in_an_image, "krylon"), (window_in_an_image, "cayman"),
         (grazing_under_a_spot, "krylon"), (grazing_under_a_spot, "cayman"), (strip_lamp, "krylon"),
         (strip_lamp, "cayman"), (half_hidden_lamp, "krylon"), (half_hidden_lamp, "cayman"),
         (grazing_under_an_area_lamp, "krylon"), (grazing_under_an_area_lamp, "cayman"), (room, "krylon"),
         (room, "foil"), (exact_room, "krylon"), (exact_room, "foil")]


def blocks(picture):
    """Means over blocks of pixels: (rows, columns, 3)."""
    count = SIZE // BLOCK
    return picture[..., :3].astype(float).reshape(count, BLOCK, count, BLOCK, 3).mean(axis=(1, 3))


def compared(shown, capsys, label):
    """The relative difference of the means, its standard error, that of blocks beyond the noise, and the noise."""
    from support import mitsuba_scene

    scene = bpy.context.scene
    bounces = scene.cycles.max_bounces
    ours, theirs = [], []
    for seed in SEEDS:
        scene.cycles.seed = seed
        ours.append(blocks(stage.render(scene)))
        samples = min(4 * scene.cycles.samples, 1024)
        theirs.append(blocks(mitsuba_scene.render(scene, shown | {"black": 0.0}, samples, bounces, seed)))
    ours, theirs = np.array(ours), np.array(theirs)
    mean = theirs.mean()
    wrong = ours.mean(axis=0) - theirs.mean(axis=0)
    between = np.diff(ours, axis=0)[0], np.diff(theirs, axis=0)[0]
    variance = sum(each**2 for each in between) / 4
    excess = math.sqrt(max((wrong**2).mean() - variance.mean(), 0)) / mean
    noise = math.sqrt(variance.mean()) / mean
    bias = wrong.mean() / mean
    grey = sum(each.mean(axis=-1) ** 2 for each in between) / 4         # channels have their noise in common
    error = math.sqrt(grey.sum()) / grey.size / mean
    with capsys.disabled():
        print(f"\n{label:36s} mean {100 * bias:+6.2f} % +- {100 * error:.2f}   "
              f"blocks {100 * excess:5.2f} %, noise {100 * noise:5.2f} %", end=" ", flush=True)
    return bias, error, excess, noise


@pytest.mark.parametrize(("build", "name"), CASES, ids=lambda item: getattr(item, "__name__", item))
def test_pictures_are_those_of_another_renderer(blender, fits, capsys, build, name):
    build(fits, name)
    bias, error, excess, noise = compared(fits, capsys, f"{build.__name__:28s}{name:8s}")
    assert abs(bias) < 0.002 + 3 * error
    assert excess < 0.01 + noise


def heights(waves=4, steep=0.15):
    """Waves over the UV map of a unit sphere, (rows, columns), metres: at the equator slopes up to `steep`."""
    u, v = np.meshgrid((np.arange(1024) + 0.5) / 1024, (np.arange(512) + 0.5) / 512)
    return (steep / waves * np.cos(2 * np.pi * waves * u) * np.cos(2 * np.pi * waves * v)).astype(np.float32)


@pytest.mark.parametrize("light", [ball_light, area_light])
@pytest.mark.parametrize("name", ["krylon", "foil"])
def test_a_bumpy_ball_is_that_of_another_renderer(blender, fits, capsys, name, light):
    """Cycles softens the edge of shadows on bumps, which Mitsuba does not do: that is off. It also keeps normals from
    reflecting into the ball, near its rim, where slopes are steep: these are not."""
    from support import mitsuba_scene

    scene_of()
    raised = heights()
    image = bpy.data.images.new("heights", raised.shape[1], raised.shape[0], float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.repeat(raised[..., None], 4, axis=2).ravel())
    made = stage.material_for(fits[name])
    made.name, made.cycles.use_bump_map_correction = "bumpy", False
    tree = made.node_tree
    texture, bump = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBump")
    texture.image = image
    bump.inputs["Distance"].default_value = 1
    tree.links.new(texture.outputs["Color"], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], stage.group_node(made).inputs["Normal"])
    turned_sphere().data.materials.append(made)
    light()
    bias, error, excess, noise = compared({"bumpy": mitsuba_scene.Bumpy(fits[name], raised)}, capsys,
                                          f"bumpy ball, {light.__name__:16s}{name:8s}")
    assert abs(bias) < 0.003 + 3 * error
    assert excess < 0.02 + noise


def turned_sphere():
    """Its axis is turned away from the camera, so that the tangent takes every direction in the picture."""
    made = stage.add_sphere()
    made.rotation_euler = (1.2, 0.3, 0.5)
    return made


def under_a_sun():
    stage.add_lamp("SUN", 2, rotation=(0.5, 0.7, 0))


def under_an_even_world():
    stage.background(bpy.context.scene, 1, (1, 0.7, 0.4))


@pytest.fixture(scope="module")
def brushed():
    """An anisotropic RGL file, and its fit of the preset Reference."""
    path = checkout.measurements() / "rgl" / "synthetic_aniso_rgb.bsdf"
    if not path.is_file():
        pytest.skip(f"{path} is absent")
    return path, fitter.fit(fitter.load(path), **fitter.PRESETS["Reference"])


@pytest.mark.parametrize("light", [under_a_sun, area_light, under_an_even_world])
def test_an_anisotropic_file_is_rendered_as_mitsuba_renders_it(blender, brushed, capsys, light):
    """Mitsuba reads the file itself: the fit's own error is in the difference."""
    path, fit = brushed
    scene_of()
    turned_sphere().data.materials.append(material({"brushed": fit}, "brushed"))
    light()
    bias, error, excess, noise = compared({"brushed": path}, capsys, f"{light.__name__}, brushed")
    assert abs(bias) < 0.005 + 3 * error
    assert excess < 0.03 + noise
