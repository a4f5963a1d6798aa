"""``python -m demo_scenes.title``: the picture that opens README.md, in measured materials and in Principled BSDFs.

The product scene of the benchmarks (`benchmarks.ordinary.car`) with a car's body in paint with flakes (`car_body`), a
ring of gold, a cloth, balls of colour-changing film and lacquer. Writes PATH.jpg, Exact; PATH_principled.jpg, where
each material is the Principled BSDF that other programs get of it; and the scene itself, build/demo/title.blend.
``python -m demo_scenes.title [--out PATH] [--width PIXELS] [--height PIXELS] [--samples N]``.
"""

import argparse
import sys
import time
from pathlib import Path

import bpy

from benchmarks import ordinary
from support import synthetic
from support.checkout import ROOT, extension
from support.stage import background, black_scene, look, set_input

from .car_body import car_body
from .gallery import source

OUT = ROOT / "build" / "demo" / "title"
EXPOSURE = 0.3
# what stands for a material of the scene: file, sample, and a tint for what CURET measured in grey
MATERIALS = {
    "irid": ("rgl/irid_flake_paint1_rgb.bsdf", "", (1, 1, 1)),
    "gold": ("published:gold-polished", "", (1, 1, 1)),
    "rims": ("published:aluminium-satin", "", (1, 1, 1)),
    "glass": ("published:black-obsidian", "", (1, 1, 1)),
    "velvet": ("curet/abrdf.dat", "velvet", (0.10, 0.34, 0.18)),
    "chrome": ("rgl/cc_ibiza_sunset_rgb.bsdf", "", (1, 1, 1)),
    "garnet": ("cornell/garnet_red.astm", "", (1, 1, 1)),
    "cherry": ("curet/abrdf.dat", "leather", (0.5, 0.42, 0.36)),
}


def stage(scene, of):
    """Build the product scene of materials: `of` returns one, given its name."""
    scene.render.film_transparent = False
    scene.cycles.use_denoising = True
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    scene.view_settings.exposure = EXPOSURE
    ordinary.car(of, car_body)
    background(scene, 0.4, (0.86, 0.93, 1.0))
    look((-0.07, -8.4, 2.4), (-0.07, 0, 0.22), lens=62)


def measured(name, data, preset):
    """The material of a name, imported as users do, or an empty one without measurements; no object may be selected."""
    file, sample, tint = MATERIALS[name]
    known = {*bpy.data.materials}
    path = source(data, file, sample)
    if path is None:                # the synthetic measurements have fewer
        return bpy.data.materials.new(name)
    bpy.ops.measured_brdf.import_data(filepath=path, sample=sample, preset=preset, rendering="EXACT")
    made, = {*bpy.data.materials} - known
    set_input(made, "Tint", (*tint, 1))
    return made


def use_principled(material, tint):
    """Render a measured material by the Principled BSDF that other programs get of it."""
    nodes = material.node_tree.nodes
    principled = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    for name in ("Base Color", "Sheen Tint"):
        colour = principled.inputs[name].default_value
        principled.inputs[name].default_value = [*(a * b for a, b in zip(colour, tint, strict=False)), 1]
    for output in (node for node in nodes if node.type == "OUTPUT_MATERIAL"):
        material.node_tree.links.new(principled.outputs[0], output.inputs["Surface"])


def draw(path, width=1600, height=640, samples=32, preset="Standard"):
    """Render the scene with the measured materials at hand, save it, and render it with Principled BSDFs."""
    data, _ = synthetic.measurements_or_synthetic()
    scene = black_scene(width, height, samples, span=1)
    made = {name: measured(name, data, preset) for name in MATERIALS}
    stage(scene, made.get)
    path.parent.mkdir(parents=True, exist_ok=True)
    image = scene.render.image_settings
    image.file_format, image.quality, image.color_mode = "JPEG", 88, "RGB"
    _render(scene, path.with_name(f"{path.name}.jpg"))
    OUT.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT.with_suffix(".blend")), compress=True, copy=True)
    scene.render.resolution_percentage = 50         # pages show it in half their width
    for name, material in made.items():
        if material.measured_brdf.coefficients:
            use_principled(material, MATERIALS[name][2])
    _render(scene, path.with_name(f"{path.name}_principled.jpg"))


def _render(scene, path):
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    """Render to the path given, or to build/demo/title."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--width", type=int, default=1600)
    parser.add_argument("--height", type=int, default=640)
    parser.add_argument("--samples", type=int, default=32)
    options = parser.parse_args()
    start = time.perf_counter()
    extension().register()
    draw(options.out.resolve(), options.width, options.height, options.samples)
    print(f"{options.out}.jpg, {OUT.with_suffix('.blend')}, {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    sys.exit(main())
