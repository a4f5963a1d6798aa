"""Closure nodes beside the exact rendering: in Cycles without OSL, and in EEVEE.

``python -m benchmarks.engines`` prints two tables, and writes a sheet of spheres where ``--pictures`` names a folder.

- What goes wrong by integration: the share of the reflected light in wrong directions, in the mean over the viewing
  angles and at the worst; and the largest difference of the nodes' albedo from the fit's.
- Spheres under a sun of a degree, a 2 m area lamp and an image of a clear sky, beside Exact of many samples: the
  difference of the mean, and FLIP as `benchmarks.dense.image_errors` has it. FLIP of Exact of as few samples tells what
  noise alone does. *time* is the processor's for the samples alone, without OSL, to a Principled BSDF's of like
  appearance in the same scene, likewise without OSL.

EEVEE needs OpenGL: Mesa's in software will do (on Debian: libegl-mesa0 and libgl1-mesa-dri).
"""

import argparse
import functools
import math
import time
from pathlib import Path
from typing import NamedTuple

import bpy
import numpy as np

import fitter
from benchmarks import rendering
from benchmarks.anisotropic_rendering import samples_of
from benchmarks.dense import image_errors, sky
from fitter.cycles import principled
from fitter.cycles.node_mixture import node_mixtures
from support import checkout, sheet, stage

CURET = ("felt", "aluminum foil", "velvet", "brick a", "leather", "straw", "human skin", "painted spheres")
FILES = ("cornell/krylon_blue_RGB.astm", "cornell/garnet_red_RGB.astm", "cornell/cayman.astm",
         "rgl/aurora_white_rgb.bsdf", "rgl/chm_mint_rgb.bsdf", "rgl/irid_flake_paint1_rgb.bsdf",
         "goniometer/lighttec_C9_Gold.astm")
TURNED = ("brushed b", "woven b")
PICTURED = ("felt", "velvet", "aluminum foil", "krylon_blue_RGB", "cayman", "irid_flake_paint1_rgb", "brushed b")
SIZE, SPAN = 96, 2.1
FEW, MANY, IN_EEVEE = 64, 512, 32
_TIMED = (16, 144)          # samples: the difference is timed


def sun():
    stage.add_lamp("SUN", math.pi, rotation=(0, -math.radians(50), 0), angle=math.radians(1))


def area():
    stage.add_lamp("AREA", 300, (-3, 0, 3), stage.rotation_toward((-3, 0, 3)), shape="SQUARE", size=2.0)


def clear_sky():
    """The sky above what the camera, which looks down, sees as up."""
    radiance = sky.clear().radiance
    image = bpy.data.images.new("Sky", radiance.shape[1], radiance.shape[0], float_buffer=True, is_data=True)
    pixels = np.ones((*radiance.shape[:2], 4), dtype=np.float32)
    pixels[..., :3] = radiance[::-1] / radiance.mean()
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = bpy.context.scene.world.node_tree
    texture, background = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes["Background"]
    texture.image = image
    background.inputs["Strength"].default_value = 0.5
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


LIGHTS = {"sun": sun, "area": area, "sky": clear_sky}


class Material(NamedTuple):
    """A fit, with its node group in a .blend."""

    name: str
    fit: fitter.Fit
    library: Path


def load(name):
    """Samples of a material, by its name."""
    if name in CURET:
        return fitter.load(checkout.measurements() / "curet" / "abrdf.dat", name)
    return samples_of(name)


def measured(material, _way):
    """A material with outputs for Cycles and for EEVEE."""
    made = rendering.measured(material.library)
    stage.add_eevee_output(made)
    return made


def like(material, _way):
    """A Principled BSDF of like appearance."""
    close = principled.principled(material.fit)
    return rendering.principled(close.base_color, close.metallic, close.roughness, close.specular_level)


def scene_of(light, material, made):
    """A sphere of a material under a light."""
    scene = stage.black_scene(SIZE, SIZE, FEW, span=SPAN)
    scene.cycles.max_bounces = 0
    stage.add_sphere()
    LIGHTS[light]()
    found = made(material, None)
    bpy.context.object.data.materials.append(found)
    return scene, found


def picture(scene, osl=True, samples=FEW, seed=0):
    scene.cycles.shading_system, scene.cycles.samples, scene.cycles.seed = osl, samples, seed
    return stage.render(scene)


def seconds(light, material, made):
    """Processor time of samples without OSL."""
    scene, _ = scene_of(light, material, made)
    spent = []
    for samples in _TIMED:
        start = time.process_time()
        picture(scene, osl=False, samples=samples)
        spent.append(time.process_time() - start)
    return spent[1] - spent[0]


@functools.cache
def inside():
    """The pixels that the sphere fills: (height, width)."""
    scene = stage.black_scene(SIZE, SIZE, 16, span=SPAN)
    stage.add_sphere()
    return stage.render(scene)[..., 3] > 0.999


def row(material, light):
    """Print a line; return the pictures of Exact, of nodes and of EEVEE."""
    scene, _ = scene_of(light, material, measured)
    truth = picture(scene, samples=MANY, seed=1)
    noisy, nodes = picture(scene), picture(scene, osl=False, samples=4 * FEW)
    eevee = stage.render_in_eevee(scene, IN_EEVEE)
    numbers = []
    for found in (noisy, nodes, eevee):
        error = image_errors.errors(truth[..., :3], found[..., :3], inside())["flip"]
        numbers.append((found[..., :3].mean() / truth[..., :3].mean() - 1, math.nan if error is None else error))
    ratio = seconds(light, material, measured) / seconds(light, material, like)
    print(f"{material.name[-22:]:23}{light:5} {numbers[0][1]:9.3f}"
          + "".join(f"  {mean:+7.1%} {error:6.3f}" for mean, error in numbers[1:]) + f" {ratio:7.2f}x", flush=True)
    return truth, nodes, eevee


def integrals(name, fit):
    """Print a line of errors by integration."""
    cycles, eevee = node_mixtures(fit)
    print(f"{name[-22:]:23}{len(cycles.kinds):6} {cycles.error:7.1%} {cycles.worst:7.1%} {cycles.albedo_error:7.1%} "
          f"{eevee.error:9.1%} {eevee.albedo_error:7.1%}", flush=True)


def main():
    parser = argparse.ArgumentParser(prog="benchmarks.engines", description=__doc__.split("\n")[0])
    parser.add_argument("--materials", nargs="+", default=(*CURET, *FILES, *TURNED))
    parser.add_argument("--spheres", nargs="*", default=PICTURED, help="materials to render, by the stem of the name")
    parser.add_argument("--lights", nargs="*", choices=LIGHTS, default=list(LIGHTS))
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="where to write engines.png")
    parser.add_argument("--folder", type=Path, default=Path("build/engines"), help="of fits, which are kept")
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    checkout.extension().register()
    from measured_brdf.addon.core import osl_support

    assert not osl_support.missing()
    materials = []
    print(f"{'':23}{'nodes, in Cycles':^30} {'in EEVEE':^17}\n{'':23}{'lobes':>6} {'mean':>7} {'worst':>7} "
          f"{'albedo':>7} {'mean':>9} {'albedo':>7}")
    for name in chosen.materials:
        stem = Path(name).stem
        kept = chosen.folder / f"{stem}.npz"
        if not kept.is_file():
            fitter.fit(load(name), **fitter.PRESETS["Standard"]).save(kept)
        fit = fitter.Fit.load(kept)
        integrals(stem, fit)
        materials.append(Material(stem, fit, rendering._library(fit, chosen.folder / f"{stem}.blend")))
    print(f"\n{'':28} {'noise':>9}  {'nodes, in Cycles':^14}  {'in EEVEE':^14}\n{'':28} {'FLIP':>9}"
          + 2 * f"  {'mean':>7} {'FLIP':>6}" + f" {'time':>8}")
    tiles = []
    for material in [each for each in materials if each.name in chosen.spheres]:
        shown = []
        for light in chosen.lights:
            found = row(material, light)
            if light == "area":
                scale = image_errors.exposure(found[0][inside()][:, :3])
                shown = [np.concatenate([each[..., :3] * scale, each[..., 3:]], axis=-1) for each in found]
        if shown:
            tiles.append([sheet.tile(each, f"{material.name}: {what}")
                          for each, what in zip(shown, ("Exact", "nodes", "EEVEE"), strict=True)])
    if chosen.pictures is not None and tiles:
        sheet.write(chosen.pictures / "engines.png", tiles)


if __name__ == "__main__":
    main()
