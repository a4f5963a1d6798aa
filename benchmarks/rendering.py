"""Mean, noise, time and largest pixels of rendered materials, beside a Principled BSDF of like appearance.

``python -m benchmarks rendering`` prints the table of docs/rendering.md. Every scene is rendered with the Principled
BSDF, with Exact and with Nodes, and compared with `reference`. Noise is half the mean squared difference of two
pictures of 64 samples with different seeds, in the pixels that the object fills; time is the processor's, for the
samples alone: the difference between two sample counts. Both are ratios to Principled's in the same run.
"""

import functools
import math
import tempfile
import time
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import bpy
import numpy as np

import fitter
from fitter.cycles.node_mixture import cycles_mixture
from support import checkout, stage, synthetic

from . import reference

SIZE = 48
SAMPLES, MANY = 64, 384
REFERENCE_SAMPLES, DRAWN_SAMPLES = 128, 1024
DENOISED_SIZE, CONVERGED = 96, 512
BLOCK = 4                   # pixels: differences are looked for in means of blocks
LAMP = (-3, 0, 2)
SPOT = (-0.6, 0.0, 0.8)      # toward the centre of the bright spot
TURN = (0, -math.atan2(3, 2), 0)
# Principled BSDFs that look alike: base colour, metallic, roughness, specular level; by least squares in reflected
# radiance over views from 5 to 65 degrees
LIKE = {
    "foil": ((0.9, 0.9, 0.9), 0.85, 0.65, 0.5),
    "krylon": ((0.0, 0.0135, 0.085), 0.0, 0.375, 0.25),
    "cayman": ((0.001, 0.022, 0.035), 0.0, 0.2, 0.3)}
FILES = {"foil": ("curet/abrdf.dat", "15"), "krylon": ("cornell/krylon_blue_RGB.astm", None),
         "cayman": ("cornell/cayman.astm", None)}


def world():
    stage.background(bpy.context.scene, 1)
    return reference.world()


def bright_spot():
    """A dim sky with a spot of 3 degrees, fading toward its edge, that gives half of its light; as an image."""
    latitude, longitude = np.meshgrid((np.arange(1024) + 0.5) * np.pi / 1024 - np.pi / 2,
                                      np.pi - (np.arange(2048) + 0.5) * np.pi / 1024, indexing="ij")
    toward = (SPOT[0] * np.cos(longitude) + SPOT[1] * np.sin(longitude)) * np.cos(latitude) + SPOT[2] * np.sin(latitude)
    edge = math.cos(math.radians(3))
    radiance = 0.5 + 800 * np.maximum(0, (toward - edge) / (1 - edge))
    world = stage.sky_image(radiance)
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", 2048
    return reference.bright_spot(SPOT, math.radians(3), 800, 0.5)


def area():
    stage.add_lamp("AREA", 100, LAMP, TURN, shape="SQUARE", size=2)
    return reference.square(LAMP, [-x for x in LAMP], 2, 100)


def point(radius=0.1):
    stage.add_lamp("POINT", 100, LAMP, shadow_soft_size=radius)
    return reference.balls([LAMP], radius, 100)


def sun(angle=0.00918):
    stage.add_lamp("SUN", 1, rotation=(0, -math.radians(60), 0), angle=angle)
    return reference.sun((-math.sin(math.radians(60)), 0, 0.5), angle, 1)


def spot():
    """It shines on the whole object evenly."""
    stage.add_lamp("SPOT", 200, LAMP, TURN, shadow_soft_size=0.1, spot_size=1.2)
    return reference.balls([LAMP], 0.1, 200)


def many_points():
    turns = np.arange(32) / 32 * 2 * math.pi
    places = [(3 * math.cos(turn), 3 * math.sin(turn), 1 + number % 4) for number, turn in enumerate(turns)]
    for place in places:
        stage.add_lamp("POINT", 5, place, shadow_soft_size=0.1)
    return reference.balls(places, 0.1, 5)


def room():
    """A closed room of diffuse walls, lit by a panel under its ceiling: direct and indirect light."""
    bpy.context.scene.cycles.max_bounces = 4
    bpy.ops.mesh.primitive_cube_add(size=6)
    walls = bpy.context.object
    material, shader, surface = stage.blank_material("Walls", "ShaderNodeBsdfDiffuse")
    material.node_tree.links.new(shader.outputs[0], surface)
    walls.data.materials.append(material)
    bpy.context.scene.camera.location.z = 2.9
    bpy.ops.mesh.primitive_plane_add(size=1, location=(-2, 0, 1.5), rotation=(0, -math.atan2(3, 2) + math.pi, 0))
    material, shader, surface = stage.blank_material("Panel", "ShaderNodeEmission")
    shader.inputs["Strength"].default_value = 20
    material.node_tree.links.new(shader.outputs[0], surface)
    bpy.context.object.data.materials.append(material)


LIGHTS = {"world": world, "bright spot": bright_spot, "2 m area": area, "0.1 m point": point, "sun": sun,
          "point, no size": lambda: point(0), "sun, no size": lambda: sun(0), "spot": spot, "32 points": many_points,
          "mesh in a room": room}
SHAPES = ("sphere", "Suzanne")


@dataclass(frozen=True)
class Result:
    """What a way of rendering a scene gives, in the pixels that the object fills.

    Attributes
    ----------
    picture, noisy : (height, width, 3)
        Of many samples and of few; 0 elsewhere.
    noise, left : float
        Standard deviation of few samples and of many, over the mean.
    seconds : float
        Processor time between the two.
    """

    picture: np.ndarray
    noisy: np.ndarray
    noise: float
    left: float
    seconds: float


def measure(shape, light, make_material, few=SAMPLES, many=MANY):
    """Render an object of a material under a light; `make_material` is given what the light's reference integrates."""
    inside = _inside(shape)
    scene, target = _stage(shape)
    integral = LIGHTS[light]()
    target.data.materials.append(make_material(integral))
    pictures, seconds = [], []
    for seed, samples in enumerate((few, few, many)):
        scene.cycles.seed, scene.cycles.samples = seed, samples
        start = time.process_time()
        pictures.append(stage.render(scene)[..., :3] * inside)
        seconds.append(time.process_time() - start)
    first, second, picture = pictures
    noise = math.sqrt(((first - second) ** 2).mean() / 2 / inside.mean()) / (picture.mean() / inside.mean())
    return Result(picture, second, noise, noise * math.sqrt(few / many), seconds[2] - seconds[1])


def _stage(shape, size=SIZE):
    scene = stage.black_scene(size, size, 16, span=2.2)
    scene.cycles.max_bounces = 0
    if shape == "sphere":
        stage.add_sphere()
    else:
        bpy.ops.mesh.primitive_monkey_add(size=1.5, rotation=(-math.pi / 2, 0, 0))     # it looks up
        bpy.ops.object.shade_smooth()
    # it moves the origin of shadow rays on coarse meshes, of any material; the reference has no such correction
    bpy.context.object.shadow_terminator_geometry_offset = 0
    return scene, bpy.context.object


@functools.cache
def _inside(shape, size=SIZE):
    """Pixels that the object fills: (height, width, 1)."""
    return stage.render(_stage(shape, size)[0])[..., 3:] > 0.9999


def principled(colour, metallic, roughness, specular):
    material, shader, surface = stage.blank_material("Principled", "ShaderNodeBsdfPrincipled")
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = metallic, roughness
    shader.inputs["Specular IOR Level"].default_value = specular
    material.node_tree.links.new(shader.outputs[0], surface)
    return material


def measured(library, nodes=False):
    """A material with the node group of a .blend: Exact, or its closure nodes."""
    with bpy.data.libraries.load(str(library)) as (_, into):
        into.node_groups = ["Measured BRDF"]
    material, group, surface = stage.blank_material("Measured", "ShaderNodeGroup")
    group.node_tree = into.node_groups[0]
    group.inputs["Nodes"].default_value = nodes
    material.node_tree.links.new(group.outputs["BSDF"], surface)
    material.cycles.use_bump_map_correction = False
    return material


def difference(picture, other):
    """The systematic difference of two results: its root mean square over blocks of pixels, less what noise
    explains, over the mean."""
    def blocks(values):
        return values.reshape(SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).mean(axis=(1, 3))

    filled = (other.picture > 0).mean()
    squared = (blocks(picture.picture - other.picture) ** 2).mean() * filled / other.picture.mean() ** 2
    return math.sqrt(max(squared - (picture.left ** 2 + other.left ** 2) / BLOCK ** 2, 0))


def _library(fit, path):
    """A .blend with the node group of a fit."""
    stage.black_scene(8, 8, 1, 1)
    bpy.data.libraries.write(str(path), {checkout.extension().addon.core.node_group.of(fit)}, fake_user=True)
    return path


def rows(name, fit, shapes, lights, folder):
    """Measure a material: yields (shape, light, like, exact, nodes, truth)."""
    mixture = cycles_mixture(fit)
    library = _library(fit, Path(folder) / f"{name}.blend")
    for shape, light in product(shapes, lights):
        like = measure(shape, light, lambda _: principled(*LIKE[name]))
        exact, nodes = (measure(shape, light, lambda _, way=way: measured(library, way)) for way in (False, True))
        many = DRAWN_SAMPLES if light == "mesh in a room" else REFERENCE_SAMPLES
        truth = measure(shape, light, lambda integral: reference.material(fit, mixture, integral), many // 8, many)
        yield shape, light, like, exact, nodes, truth


def main(materials=(), shapes=(), lights=()):
    """Print the table, or the part of it that is named."""
    print(f"""{'':31}{'Exact':^44} | {'Nodes':^32}
{'':31}{'mean':>10} {'picture':>8} {'noise':>7} {'time':>7} {'largest':>8} | {'picture':>8} {'noise':>7} {'time':>7}
{'':31}{'to the reference':>19} {'to Principled':>15} {'pixel':>8} | {'to Exact':>8} {'to Principled':>15}""")
    with tempfile.TemporaryDirectory() as folder:
        for name, fit in _fits(materials or FILES):
            for shape, light, like, exact, nodes, truth in rows(name, fit, shapes or SHAPES, lights or LIGHTS, folder):
                print(f"{name:7} {shape:8}{light:15} {exact.picture.mean() / truth.picture.mean() - 1:+10.2%} "
                      f"{difference(exact, truth):8.2%} {exact.noise / like.noise:6.2f}x "
                      f"{exact.seconds / like.seconds:6.2f}x {exact.noisy.max() / exact.picture.max():7.2f}x | "
                      f"{difference(nodes, exact):8.2%} {nodes.noise / like.noise:6.2f}x "
                      f"{nodes.seconds / like.seconds:6.2f}x", flush=True)


def denoising():
    """Print the error of Suzanne in 64 samples against the converged picture, before and after OpenImageDenoise."""
    print(f"{'':23}{'Principled':^18} {'Exact':^18} {'Nodes':^18}")
    with tempfile.TemporaryDirectory() as folder:
        for name, fit in _fits(("foil", "krylon")):
            library = _library(fit, Path(folder) / f"{name}.blend")
            ways = (lambda name=name: principled(*LIKE[name]), lambda library=library: measured(library),
                    lambda library=library: measured(library, nodes=True))
            for light in ("world", "2 m area", "sun"):
                print(f"{name:7} {light:15}", *("{:7.1%} -> {:7.1%}".format(*_denoised(light, way)) for way in ways),
                      flush=True)


def _denoised(light, make_material):
    """Relative RMSE before and after the denoiser."""
    inside = _inside("Suzanne", DENOISED_SIZE)
    scene, target = _stage("Suzanne", DENOISED_SIZE)
    LIGHTS[light]()
    target.data.materials.append(make_material())
    found = []
    for seed, (samples, denoise) in enumerate(((CONVERGED, False), (SAMPLES, False), (SAMPLES, True))):
        scene.cycles.seed, scene.cycles.samples, scene.cycles.use_denoising = max(seed, 1), samples, denoise
        found.append(stage.render(scene)[..., :3] * inside)
    scale = found[0].mean() / math.sqrt(inside.mean())
    return [math.sqrt(((picture - found[0]) ** 2).mean()) / scale for picture in found[1:]]


def pictures(folder):
    """One row a light: converged, of 64 samples, Nodes, the reference, and ten times Exact less the reference."""
    from matplotlib import pyplot

    (name, fit), = _fits(["krylon"])
    lights = ("world", "2 m area", "sun", "mesh in a room")
    figure, axes = pyplot.subplots(len(lights), 5, figsize=(7.5, 1.6 * len(lights)), layout="constrained")
    with tempfile.TemporaryDirectory() as temporary:
        for line, (_, light, _, exact, nodes, truth) in zip(axes, rows(name, fit, ["Suzanne"], lights, temporary),
                                                            strict=True):
            shown = {"Exact, converged": exact.picture, f"Exact, {SAMPLES} samples": exact.noisy,
                     f"Nodes, {SAMPLES} samples": nodes.noisy, "reference": truth.picture}
            white = np.quantile(exact.picture, 0.995)
            for axis, (title, picture) in zip(line, shown.items(), strict=False):
                axis.imshow((picture / white).clip(0, 1) ** (1 / 2.2))
                axis.set_title(title, fontsize=7)
            line[4].imshow(10 * (exact.picture - truth.picture).mean(axis=2) / white, "coolwarm", vmin=-1, vmax=1)
            line[4].set_title("10 x (Exact - reference)", fontsize=7)
            line[0].set_ylabel(light, fontsize=7)
            for axis in line:
                axis.set(xticks=[], yticks=[])
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "rendering.png", dpi=110)


def _fits(materials):
    checkout.extension().register()
    data = synthetic.measurements_or_synthetic()[0]
    for name in materials:
        path, sample = FILES[name]
        if (data / path).is_file():
            yield name, fitter.fit(fitter.load(data / path, sample), **fitter.PRESETS["Standard"])
        else:
            print(f"{name}: {path} is absent")
