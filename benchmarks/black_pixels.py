"""Pixels below zero in scenes that are hard for it: lights that the shader does not know, area lamps, bump maps.

``python -m benchmarks.black_pixels [--scenes NAME ...]`` renders a ball in 160 x 160 pixels of 128 samples and
prints, of Exact: the pixels with a channel below -2 % of the mean; the least value over the mean; the mean over that of
Nodes; and noise and time over a Principled BSDF's.
"""

import argparse
import functools
import math
import time

import bpy
import numpy as np

import fitter
from fitter.cycles.node_mixture import node_mixtures
from support import ball_files, checkout, stage
from support.evidence import show, show_table

from .ordinary import FILES, area, material_of

SIZE, SAMPLES, FEWER = 160, 128, 32
BELOW = -0.02               # of the mean


def hundred_lamps():
    random = np.random.default_rng(1)
    for _ in range(100):
        z, turn = random.uniform(0.1, 1), random.uniform(0, 2 * np.pi)
        flat = math.sqrt(1 - z * z)
        place = 6 * np.array([flat * math.cos(turn), flat * math.sin(turn), z])
        stage.add_lamp("POINT", 20, tuple(place), shadow_soft_size=0.05)


def lit_mesh():
    """A square that shines, which is no lamp."""
    place = -3, -3, 3
    bpy.ops.mesh.primitive_plane_add(size=1, location=place, rotation=stage.rotation_toward(place))
    bpy.context.object.data.materials.append(stage.simple_material("Lit", "ShaderNodeEmission", {"Strength": 60}))


def area_lamp():
    area(300, (-3, -3, 4))


def three_lamps():
    area(250, (-4, -3, 4), size=1.5)
    area(120, (4, -2, 3), size=1.0)
    place = 1, -5, 5
    stage.add_lamp("SPOT", 600, place, stage.rotation_toward(place), shadow_soft_size=0.1, spot_size=0.8)


# by name: lights, material, and whether it has a bump map
SCENES = {"foil, 100 lamps": (hundred_lamps, "foil", False), "foil, lit mesh": (lit_mesh, "foil", False),
          "mint, three lamps": (three_lamps, "mint", False), "krylon, area lamp": (area_lamp, "krylon", False),
          "krylon, bump map": (area_lamp, "krylon", True), "malachite, bump map": (area_lamp, "malachite", True),
          "malachite, three lamps": (three_lamps, "malachite", False),
          "cayman, three lamps": (three_lamps, "cayman", False)}


def scene(name, material):
    """Open one of SCENES with a material on the ball, which a function makes."""
    lights, _, bump = SCENES[name]
    made = stage.black_scene(SIZE, SIZE, SAMPLES, span=1)
    made.cycles.use_denoising, made.cycles.max_bounces = False, 0
    stage.add_sphere()
    ball = bpy.context.object
    lights()
    stage.look((0, -7, 1.5), (0, 0, 0), 110)
    shown = material()
    if bump:
        _add_bump_map(shown.node_tree)
    ball.data.materials.append(shown)
    return made


def _add_bump_map(tree):
    noise, bump = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeBump")
    noise.inputs["Scale"].default_value, bump.inputs["Distance"].default_value = 8, 0.1
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    shader = next(node for node in tree.nodes if "Normal" in node.inputs and node is not bump)
    tree.links.new(bump.outputs[0], shader.inputs["Normal"])


def below(picture):
    return int((picture < BELOW * picture.mean()).any(axis=-1).sum())


def is_there(name):
    return (checkout.measurements() / FILES[SCENES[name][1]][0]).is_file()


@functools.cache
def fitted(material):
    """Standard's fit of one of `ordinary.FILES`, and its closure nodes."""
    path, sample = FILES[material]
    fit = fitter.fit(fitter.load(checkout.measurements() / path, sample), **fitter.PRESETS["Standard"])
    return fit, node_mixtures(fit)


def _measured(name, material):
    """A picture, the noise of two and the time of a sample."""
    made = scene(name, material)
    pictures, seconds = [], []
    for samples, seed in ((FEWER, 1), (SAMPLES, 2), (SAMPLES, 3)):
        made.cycles.samples, made.cycles.seed = samples, seed
        start = time.process_time()
        pictures.append(stage.render(made)[..., :3].astype(float))
        seconds.append(time.process_time() - start)
    noise = np.sqrt(((pictures[1] - pictures[2]) ** 2).mean() / 2)
    return pictures[1], noise, (min(seconds[1:]) - seconds[0]) / (SAMPLES - FEWER)


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.black_pixels", description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", nargs="*", default=[""], help="only those whose names contain one of these")
    chosen = parser.parse_args().scenes
    checkout.extension().register()
    ball_files.add_openimageio()
    rows = []
    for name in (each for each in SCENES if is_there(each) and any(text in each for text in chosen)):
        fit, nodes = fitted(SCENES[name][1])
        found = {}
        for way in ("Exact", "Nodes", "Principled"):
            found[way] = _measured(name, functools.partial(material_of, way, fit, nodes, way))
        picture, noise, seconds = found["Exact"]
        rows.append((name, below(picture), f"{picture.min() / picture.mean():.3f}", below(found["Nodes"][0]),
                     f"{picture.mean() / found['Nodes'][0].mean():.4f}", f"{noise / found['Principled'][1]:.2f}",
                     f"{seconds / found['Principled'][2]:.2f}"))
    show_table("black-pixels", ("", f"below {BELOW:.0%} of the mean", "the least over the mean", "of Nodes",
                                "mean over Nodes'", "noise", "time"), rows)
    bad = [f"{count} ({name})" for name, count, *_ in rows if count]
    show("black-pixels-most", f"none in {len(rows) - len(bad)} of {len(rows)} scenes"
         + (f"; {', '.join(bad)}" if bad else ""))


if __name__ == "__main__":
    main()
