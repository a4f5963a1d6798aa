"""``python -m demo_scenes.gallery``: the pictures of the first page, balls of materials under one sky and lamps.

``python -m demo_scenes.gallery FOLDER [NAME ...] [--size PIXELS] [--format PNG]``. Measurements that are not at
hand are left out, and named.
"""

import argparse
import sys
import time
from pathlib import Path

import bpy
import numpy as np

from fitter.formats import list_samples
from support.checkout import ROOT, extension, measurements
from support.stage import add_lamp, background, black_scene, look, rotation_toward, simple_material

from .anisotropic import revolved

OUT = ROOT / "build" / "demo" / "gallery"
SIZE, SAMPLES = 320, 64
# the name of the picture, the file, and the sample in it
MATERIALS = {
    "garnet_red": ("cornell/garnet_red.astm", ""),
    "cayman": ("cornell/cayman.astm", ""),
    "foil": ("curet/abrdf.dat", "aluminum foil"),
    "velvet": ("curet/abrdf.dat", "velvet"),
    "ibiza_sunset": ("rgl/cc_ibiza_sunset_rgb.bsdf", ""),
    "silk_blue": ("rgl/vch_silk_blue_rgb.bsdf", ""),
    "green_malachite": ("rgl/cc_green_malachite_rgb.bsdf", ""),
    "mint": ("rgl/chm_mint_rgb.bsdf", ""),
    "military_green": ("rgl/cm_military_green_rgb.bsdf", ""),
    "carpaint_blue": ("goniometer/carpaint_blue.mbsdf", ""),
    "lighttec_gold": ("goniometer/lighttec_C9_Gold.astm", ""),
    "gold_paint": ("published:gold-metallic-paint", ""),
    "black_phenolic": ("published:black-phenolic", ""),
    "violet_phenolic": ("published:specular-violet-phenolic", ""),
    "cherry": ("published:cherry-235", ""),
    "red_fabric": ("published:red-fabric", ""),
}


def stage(size=SIZE):
    """A ball on a foot in a pale round studio open to an even sky; a soft box to the left, a strip to the right."""
    scene = black_scene(size, size, SAMPLES, span=1)
    scene.render.film_transparent = False
    scene.cycles.use_denoising, scene.cycles.sample_clamp_indirect = True, 3    # no specks of light on the floor
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.35
    background(scene, 1.5, (0.86, 0.93, 1.0))
    for energy, place, settings in (
            (330, (-3.2, -2.6, 4.0), {"shape": "SQUARE", "size": 2.0}),
            (110, (3.4, -0.6, 2.4), {"shape": "RECTANGLE", "size": 0.5, "size_y": 3.0})):
        add_lamp("AREA", energy, place, rotation_toward(place, (0, 0, 1)), **settings)
    look((0, -7.2, 2.2), (0, 0, 0.99), lens=88)
    studio()
    ball()
    return scene


def studio():
    """A round floor that curves up into a wall, lit through its open top."""
    angle = np.radians(np.linspace(0, 90, 31))
    corner = np.stack([7.5 + 2.5 * np.sin(angle), 2.5 - 2.5 * np.cos(angle)], axis=1)
    room = revolved("Studio", np.vstack([(0, 0), corner, (10, 3.1)]), 96)
    room.data.materials.append(simple_material("Studio", "ShaderNodeBsdfDiffuse", {"Color": (0.36, 0.355, 0.345, 1)}))


def ball():
    """A sphere with a groove around it, on a foot, as the active object."""
    angle = np.radians(np.linspace(150, 0, 91))
    groove = 0.035 * np.exp(-(((np.degrees(angle) - 58) / 2.0) ** 2))
    sphere = np.stack([(1 - groove) * np.sin(angle), 1.08 + (1 - groove) * np.cos(angle)], axis=1)
    foot = np.array([(0, 0), (0.70, 0), (0.73, 0.015), (0.74, 0.04), (0.73, 0.065), (0.70, 0.08), (0.60, 0.1)])
    return revolved("Ball", np.vstack([foot, sphere]), 256)


def source(data, file, sample):
    """What `import_data` takes for a material, or None where its measurements are not at hand."""
    if file.startswith("published:"):
        return file
    path = data / file
    if not path.is_file() or (sample and sample not in [name for _, name in list_samples(path)]):
        return None
    return str(path)


def draw(folder, names, size=SIZE, file_format="JPEG"):
    """Render the named materials, each to a picture of its own."""
    for name in names:
        file, sample = MATERIALS[name]
        found = source(measurements(), file, sample)
        if found is None:
            print(f"{name}: {file} is not at hand")
            continue
        start = time.perf_counter()
        scene = stage(size)
        bpy.ops.measured_brdf.import_data(filepath=found, sample=sample, preset="Standard")
        image = scene.render.image_settings
        image.file_format, image.color_mode, image.quality, image.compression = file_format, "RGB", 85, 100
        scene.render.filepath = str(folder / name)
        bpy.ops.render.render(write_still=True)
        print(f"{folder / name}, {time.perf_counter() - start:.0f} s")


def main():
    """Render to the folder given, or to build/demo/gallery."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=OUT)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(MATERIALS))
    parser.add_argument("--size", type=int, default=SIZE)
    parser.add_argument("--format", default="JPEG", choices=("JPEG", "PNG"))
    options = parser.parse_args()
    extension().register()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    draw(folder, options.names or MATERIALS, options.size, options.format)


if __name__ == "__main__":
    sys.exit(main())
