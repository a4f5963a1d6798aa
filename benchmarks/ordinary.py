"""Ordinary scenes, of several measured materials: noise, time, dark specks and fireflies beside a Principled BSDF.

``python -m benchmarks.ordinary [--scenes spheres car]`` prints the table of docs/rendering.md, which says what its
columns are. A scene of which a material is absent is left out.
"""

import argparse
import functools
import math
import sys
import time

import bpy
import numpy as np

import fitter
from fitter.cycles.node_mixture import node_mixtures
from fitter.cycles.principled import principled as principled_of
from support import checkout, stage, synthetic
from support.evidence import show, show_table

WIDTH, HEIGHT = 160, 135
DARK, BRIGHT = 0.35, 3.0    # of the median around a pixel
SAMPLES, SEEDS = 64, 4
COUNTED = (16, 64, 256)
AROUND = 2                  # pixels on each side
BOUNCES = 4
FILES = {"foil": ("curet/abrdf.dat", "15"), "felt": ("curet/abrdf.dat", "1"), "leather": ("curet/abrdf.dat", "5"),
         "velvet": ("curet/abrdf.dat", "7"), "plaster": ("curet/abrdf.dat", "11"),
         "krylon": ("cornell/krylon_blue_RGB.astm", None), "garnet": ("cornell/garnet_red_RGB.astm", None),
         "cayman": ("cornell/cayman.astm", None), "mint": ("rgl/chm_mint_rgb.bsdf", None),
         "malachite": ("rgl/cc_green_malachite_rgb.bsdf", None), "irid": ("rgl/irid_flake_paint1_rgb.bsdf", None),
         "gold": ("goniometer/lighttec_C9_Gold.astm", None)}
PUBLISHED = {"chrome": "chrome", "cherry": "cherry-235"}


def area(energy, location, target=(0, 0, 0), size=2.0):
    return stage.add_lamp("AREA", energy, location, stage.rotation_toward(location, target), shape="SQUARE", size=size)


def _sphere(material, location, radius=1.0):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius, location=location)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material)


def _plane(material, size=20.0, location=(0, 0, 0), rotation=(0, 0, 0)):
    bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=rotation)
    bpy.context.object.data.materials.append(material)


def spheres(of):
    """Three spheres on a floor; an area lamp, a point lamp and a dim sky."""
    stage.background(bpy.context.scene, 0.1, (0.7, 0.8, 1.0))
    area(300, (-3, -2, 4), (0, 0, 1))
    stage.add_lamp("POINT", 150, (3, -3, 3), shadow_soft_size=0.15)
    for name, x in (("krylon", -2.2), ("velvet", 0), ("cayman", 2.2)):
        _sphere(of(name), (x, 0, 1))
    _plane(of("foil"))
    stage.look((0, -9, 3.2), (0, 0, 0.9), 55)


def interior(of):
    """A room lit through a window: floor and walls are measured."""
    stage.background(bpy.context.scene, 3, (0.8, 0.9, 1.0))
    stage.add_lamp("SUN", 3, rotation=(math.radians(55), 0, math.radians(75)), angle=0.00918)
    wall = of("plaster")
    _plane(of("leather"), 6)
    _plane(wall, 6, (0, 0, 3), (math.pi, 0, 0))
    for location, turn in (((0, 3, 1.5), 0), ((0, -3, 1.5), math.pi), ((-3, 0, 1.5), math.pi / 2)):
        _plane(wall, 6, location, (math.pi / 2, 0, turn))
    # the wall with the window: below, above and beside it
    for y, z, width, height in ((0, 0.25, 6, 0.5), (0, 2.6, 6, 0.8), (-2, 1.35, 2, 1.7), (2, 1.35, 2, 1.7)):
        _plane(wall, 1, (3, y, z), (math.pi / 2, 0, -math.pi / 2))
        bpy.context.object.scale = (width, height, 1)
    _sphere(of("krylon"), (0.4, 0.6, 0.6), 0.6)
    _sphere(of("foil"), (-1.2, 1.2, 0.5), 0.5)
    stage.look((-1.5, -2.7, 1.5), (0.1, 1, 0.9), 24)


def car(of, body=None):
    """A car-like body, a ring, a cloth and two balls on a wooden floor; two area lamps, a spot and a dim sky.

    `body`, a function of the materials as `of` is, makes another body than two boxes.
    """
    scene = bpy.context.scene
    scene.cycles.sample_clamp_indirect = 10         # as Cycles has it by default
    stage.background(scene, 0.1, (0.7, 0.8, 1.0))
    area(250, (-4, -3, 4), (0, 0, 0.5), 1.5)
    area(120, (4, -2, 3), (0, 0, 0.5), 1.0)
    stage.add_lamp("SPOT", 600, (1, -5, 5), stage.rotation_toward((1, -5, 5), (0, 0, 0.5)), shadow_soft_size=0.1,
                   spot_size=0.8)
    (body or _boxes)(of)
    bpy.ops.mesh.primitive_torus_add(major_radius=0.45, minor_radius=0.12, location=(1.6, -0.6, 0.5),
                                     rotation=(1.2, 0, 0.5))
    _smooth(of("gold"))
    _cloth(of("velvet"), (-1.6, -0.9, 0.25))
    _sphere(of("chrome"), (0.5, -1, 0.4), 0.4)
    _sphere(of("garnet"), (-0.6, -1.2, 0.35), 0.35)
    _plane(of("cherry"))
    stage.look((0.3, -7.5, 2.8), (0, 0, 0.4), 60)


def _boxes(of):
    for size, location in (((2.6, 1.2, 0.55), (-0.2, 0.6, 0.35)), ((1.3, 1.0, 0.45), (-0.1, 0.6, 0.8))):
        _rounded_box(of("irid"), size, location)


def _smooth(material):
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material)


def _rounded_box(material, size, location):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location)
    box = bpy.context.object
    box.scale = size
    bpy.ops.object.transform_apply(location=False, rotation=False)
    bevel = box.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.18, 3
    box.modifiers.new("Subdivision", "SUBSURF").render_levels = 2
    _smooth(material)


def _cloth(material, location):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=60, y_subdivisions=60, size=1.4, location=location)
    points = bpy.context.object.data.vertices
    at = np.empty(3 * len(points))
    points.foreach_get("co", at)
    x, y, _ = at.reshape(-1, 3).T
    at[2::3] = 0.08 * np.sin(7 * x + 2 * y) + 0.05 * np.sin(9 * y - 3 * x)
    points.foreach_set("co", at)
    _smooth(material)


SCENES = {each.__name__: each for each in (spheres, interior, car)}


def figures(few, noisy, many):
    """Those of pictures of COUNTED samples, each (height, width, 3), and `noisy` (SEEDS, ...), by name."""
    mean = converged(noisy, many)
    deviation = np.sqrt(noisy.var(axis=0, ddof=1).mean(axis=-1))
    first = noisy[0].max(axis=-1)
    row, column = np.unravel_index(first.argmax(), first.shape)
    around = mean[max(row - AROUND, 0):row + AROUND + 1, max(column - AROUND, 0):column + AROUND + 1]
    dark, bright = outliers(noisy[0], mean)
    return {"noise": np.sqrt((deviation ** 2).mean()) / mean.mean(), "median": np.median(deviation) / mean.mean(),
            "below": [int((picture < 0).any(axis=-1).sum()) for picture in (few, noisy[0], many)],
            "least": noisy[0].min() / mean.mean(), "largest": first.max() / around.max(), "dark": dark,
            "bright": bright}


def outliers(picture, mean):
    """How many pixels are much darker, and much brighter, than those around them, where the mean of pictures is not."""
    of_one, of_all = (to_median(each.mean(axis=-1)) for each in (picture, mean))
    return (int(((of_one < DARK) & (of_all >= DARK)).sum()), int(((of_one > BRIGHT) & (of_all <= BRIGHT)).sum()))


def to_median(values):
    """Pixels (height, width) over the median around each."""
    padded = np.pad(values, AROUND, mode="edge")
    around = np.lib.stride_tricks.sliding_window_view(padded, (2 * AROUND + 1,) * 2)
    return values / np.maximum(np.median(around, axis=(-2, -1)), np.finfo(float).tiny)


def converged(noisy, many):
    """The mean of all samples of the pictures of SAMPLES and of the one of the largest count."""
    counts = SAMPLES * len(noisy), COUNTED[-1]
    return (counts[0] * noisy.mean(axis=0) + counts[1] * many) / sum(counts)


def build(scene, of):
    """Build a scene of materials: `of` makes one, given its name."""
    opened = stage.black_scene(WIDTH, HEIGHT, SAMPLES, span=1)
    opened.render.film_transparent = False
    opened.cycles.max_bounces = opened.cycles.diffuse_bounces = opened.cycles.glossy_bounces = BOUNCES
    SCENES[scene](functools.cache(of))
    return opened


def measure(scene, of):
    """Render a scene: its `figures`, processor seconds of SAMPLES samples, their relative error after the denoiser, and
    the mean of all."""
    opened = build(scene, of)

    def rendered(samples, seed, denoised=False):
        opened.cycles.samples, opened.cycles.seed, opened.cycles.use_denoising = samples, seed, denoised
        start = time.process_time()
        picture = stage.render(opened)[..., :3].astype(float)
        return picture, time.process_time() - start

    few, seconds_few = rendered(COUNTED[0], 1)
    noisy, seconds = map(np.array, zip(*(rendered(SAMPLES, seed) for seed in range(2, 2 + SEEDS)), strict=True))
    many, _ = rendered(COUNTED[-1], 2 + SEEDS)
    denoised, _ = rendered(SAMPLES, 2, denoised=True)
    picture = converged(noisy, many)
    error = math.sqrt(((denoised - picture) ** 2).mean()) / picture.mean()
    per_sample = (np.median(seconds) - seconds_few) / (SAMPLES - COUNTED[0])
    return figures(few, noisy, many) | {"seconds": SAMPLES * per_sample, "denoised": error, "mean": picture.mean()}


def principled_material(fit, name):
    like = principled_of(fit)
    return stage.simple_material(name, "ShaderNodeBsdfPrincipled", {
        "Base Color": (*like.base_color, 1), "Metallic": like.metallic, "Roughness": like.roughness,
        "Specular IOR Level": like.specular_level, "Sheen Weight": like.sheen_weight,
        "Sheen Tint": (*like.sheen_tint, 1), "Sheen Roughness": like.sheen_roughness, "Coat Weight": like.coat_weight,
        "Coat Roughness": like.coat_roughness})


def material_of(way, fit, nodes, name):
    """A material that shows a fit by "Principled", the closest one, by "Nodes", or else exactly."""
    if way == "Principled":
        return principled_material(fit, name)
    material = stage.material_for(fit, nodes)
    stage.set_input(material, "Nodes", way == "Nodes")
    return material


def ways():
    """The ways of making materials: by name, a function of a material's name."""
    checkout.extension().register()
    data = synthetic.measurements_or_synthetic()[0]
    samples = functools.cache(lambda name: fitter.load_published(PUBLISHED[name]) if name in PUBLISHED
                              else fitter.load(data / FILES[name][0], FILES[name][1]))
    fit = functools.cache(lambda name: fitter.fit(samples(name), **fitter.PRESETS["Standard"]))
    nodes = functools.cache(lambda name: node_mixtures(fit(name)))
    return {way: lambda name, way=way: material_of(way, fit(name), nodes(name), name)
            for way in ("Principled", "Standard", "Nodes")}


def exact_everywhere(of):
    """As `of`, materials that are exact after rough bounces too."""
    def exact(name):
        material = of(name)
        stage.set_input(material, "Exact Everywhere", True)
        return material
    return exact


def absent(scene):
    """The materials of a scene of which there are no measurements."""
    names = []

    def named(name):
        names.append(name)
        return bpy.data.materials.new(name)

    build(scene, named)
    data = synthetic.measurements_or_synthetic()[0]
    return [name for name in names if name in FILES and not (data / FILES[name][0]).is_file()]


HEADS = ("scene", "", "noise", "median", "time", "at equal time", "denoised", "largest", "dark", "bright", "mean",
         f"below 0 at {', '.join(map(str, COUNTED))} samples", "least")


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ordinary", description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=["spheres", "car"], help="default: spheres car")
    found, rows, exact = ways(), [], []
    for scene in parser.parse_args().scenes:
        if missing := absent(scene):
            print(f"{scene}: left out, for there are no measurements of {', '.join(missing)}", file=sys.stderr)
            continue
        like = measure(scene, found["Principled"])
        rows.append((scene, "Principled", *_ratios(like, like), None, *_below(like)))
        true_mean = measure(scene, exact_everywhere(found["Standard"]))["mean"]
        for way in ("Standard", "Nodes"):
            made = measure(scene, found[way])
            mean = made["mean"] / true_mean - 1
            rows.append((scene, way, *_ratios(made, like), f"{mean:+.2%}", *_below(made)))
            exact += [(*_ratios(made, like), mean)] * (way == "Standard")
    show_table("ordinary", HEADS, rows)
    if exact:
        noise, _, spent, *_ = zip(*exact, strict=True)
        show("ordinary-exact", f"noise {' and '.join(f'{each:.2f}' for each in noise)}, time "
             f"{' and '.join(f'{each:.1f}' for each in spent)} times a Principled BSDF's; means within "
             f"{max(abs(row[-1]) for row in exact):.2%} of Exact Everywhere's")


def _ratios(found, like):
    """Noise, median, time, noise at equal time and denoised over Principled's, and the largest and outlying pixels."""
    noise, median, spent, denoised = (found[name] / like[name] for name in ("noise", "median", "seconds", "denoised"))
    return (noise, median, spent, noise * math.sqrt(spent), denoised, *(
        found[name] for name in ("largest", "dark", "bright")))


def _below(found):
    return " ".join(map(str, found["below"])), round(found["least"], 2)


if __name__ == "__main__":
    main()
