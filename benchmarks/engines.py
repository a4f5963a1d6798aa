"""Closure nodes beside the exact rendering, in Cycles without OSL and in EEVEE (docs/engines.md).

``python -m benchmarks.engines [--out FOLDER]``. What goes wrong by integration, and spheres beside Exact of many
samples; FLIP of Exact of as few tells what noise alone does. EEVEE needs OpenGL: Mesa's in software will do (on Debian:
libegl-mesa0 and libgl1-mesa-dri).
"""

import argparse
import functools
import math
from pathlib import Path

import bpy
import numpy as np

import fitter
from fitter.cycles.node_mixture import node_mixtures
from support import ball_files, checkout, sheet, stage
from support.anisotropic import ANISOTROPIC, rotations
from support.evidence import show_table

from .dense import image_errors
from .ordinary import area

FILES = {"felt": "curet/abrdf.dat", "aluminum foil": "curet/abrdf.dat", "velvet": "curet/abrdf.dat",
         "krylon": "cornell/krylon_blue_RGB.astm", "garnet": "cornell/garnet_red_RGB.astm",
         "cayman": "cornell/cayman.astm", "aurora white": "rgl/aurora_white_rgb.bsdf",
         "mint": "rgl/chm_mint_rgb.bsdf", "iridescent flakes": "rgl/irid_flake_paint1_rgb.bsdf",
         "C9 Gold": "goniometer/lighttec_C9_Gold.astm"}
SYNTHETIC = "brushed b", "woven b"
PICTURED = "velvet", "krylon", "iridescent flakes", "brushed b"
SIZE, SPAN = 96, 2.1
FEW, MANY, IN_EEVEE = 64, 512, 32


def sun():
    stage.add_lamp("SUN", math.pi, rotation=(0, -math.radians(50), 0), angle=math.radians(1))


LIGHTS = {"sun": sun, "area": functools.partial(area, 300, (-3, 0, 3))}


def samples_of(name):
    if name in SYNTHETIC:
        truth, = (each for each in ANISOTROPIC if each.name == name)
        directions = rotations(16)
        return fitter.Samples(*directions, truth.evaluate(*directions), fitter.samples.RGB, name, isotropic=False)
    path = checkout.measurements() / FILES[name]
    return fitter.load(path, name if path.suffix == ".dat" else None)


@functools.cache
def inside():
    """The pixels that the sphere fills: (height, width)."""
    scene = stage.black_scene(SIZE, SIZE, 16, span=SPAN)
    stage.add_sphere()
    return stage.render(scene)[..., 3] > 0.999


def pictures(fit, nodes, light):
    """Under a light: Exact of many and of few samples, nodes in Cycles, and EEVEE; each (SIZE, SIZE, 4)."""
    scene = stage.black_scene(SIZE, SIZE, FEW, span=SPAN)
    scene.cycles.max_bounces = 0
    stage.add_sphere()
    LIGHTS[light]()
    material = stage.material_for(fit, nodes)
    stage.add_eevee_output(material)
    bpy.context.object.data.materials.append(material)

    def rendered(osl, samples, seed=0):
        scene.cycles.shading_system, scene.cycles.samples, scene.cycles.seed = osl, samples, seed
        return stage.render(scene)

    return (rendered(True, MANY, 1), rendered(True, FEW), rendered(False, 4 * FEW),
            stage.render_in_eevee(scene, IN_EEVEE))


def compared(truth, *others):
    """Of each picture the difference of its mean to the true one's, and FLIP."""
    for other in others:
        yield f"{other[..., :3].mean() / truth[..., :3].mean() - 1:+.1%}"
        yield image_errors.errors(truth[..., :3], other[..., :3], inside())["flip"]


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.engines", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("build/engines"), help="default: %(default)s")
    out = parser.parse_args().out
    checkout.extension().register()
    ball_files.add_openimageio()
    fits = {name: fitter.fit(samples_of(name), **fitter.PRESETS["Standard"]) for name in (*FILES, *SYNTHETIC)
            if name in SYNTHETIC or (checkout.measurements() / FILES[name]).is_file()}
    nodes = {name: node_mixtures(fit) for name, fit in fits.items()}
    show_table("engines-integrals", ("", "lobes", "in Cycles", "at the worst", "albedo", "in EEVEE", "albedo "), [
        (name, len(cycles.kinds), *(f"{share:.1%}" for share in (
            cycles.error, cycles.worst, cycles.albedo_error, eevee.error, eevee.albedo_error)))
        for name, (cycles, eevee) in nodes.items()])
    rows, tiles = [], []
    for name in filter(fits.get, PICTURED):
        for light in LIGHTS:
            found = pictures(fits[name], nodes[name], light)
            _, noise, *others = compared(*found)
            rows.append((name, light, noise, *others))
        scale = image_errors.exposure(found[0][inside()][:, :3])
        shown = (np.concatenate([scale * each[..., :3], each[..., 3:]], axis=-1) for each in (found[0], *found[2:]))
        tiles.append([sheet.tile(each, f"{name}: {what}")
                      for each, what in zip(shown, ("Exact", "nodes", "EEVEE"), strict=True)])
    show_table("engines-spheres", ("", "light", "FLIP of noise", "nodes: mean", "FLIP", "EEVEE: mean", "FLIP "), rows)
    out.mkdir(parents=True, exist_ok=True)
    if tiles:
        sheet.write(out / "engines.png", tiles)


if __name__ == "__main__":
    main()
