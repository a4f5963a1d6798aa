"""``make title``: the picture that opens README.md, measured materials under sun and sky."""

import math
import sys
import time
from pathlib import Path

import bpy

from fitter.formats import list_samples
from support import synthetic
from support.checkout import ROOT, extension
from support.stage import black_scene, blank_material, set_input

OUT = ROOT / "build" / "demo" / "title.png"
# file, sample, and a tint for what CURET measured in grey
MATERIALS = {
    "foil": ("curet/abrdf.dat", "aluminum foil", (1, 1, 1)),
    "garnet red": ("cornell/garnet_red.astm", "", (1, 1, 1)),
    "krylon blue": ("cornell/krylon_blue.astm", "", (1, 1, 1)),
    "leather": ("curet/abrdf.dat", "leather", (0.27, 0.10, 0.035)),
    "velvet": ("curet/abrdf.dat", "velvet", (0.10, 0.34, 0.18)),
}
SUN_ELEVATION, SUN_ROTATION = math.radians(34), math.radians(235)
SPACING = 2.5


def stage(width, samples):
    """A clear sky with its sun, a floor of pale concrete, and a camera at eye level."""
    scene = black_scene(width, width * 2 // 7, samples, span=1)
    scene.render.film_transparent = False
    scene.cycles.use_denoising = True
    scene.view_settings.view_transform, scene.view_settings.exposure = "AgX", -4.7
    scene.view_settings.look = "AgX - Medium High Contrast"
    sky = scene.world.node_tree.nodes.new("ShaderNodeTexSky")
    sky.sun_elevation, sky.sun_rotation, sky.sun_size = SUN_ELEVATION, SUN_ROTATION, math.radians(2)
    world = scene.world.node_tree
    world.links.new(sky.outputs[0], world.nodes["Background"].inputs["Color"])
    world.nodes["Background"].inputs["Strength"].default_value = 1
    camera = scene.camera
    camera.data.type, camera.data.lens = "PERSP", 85
    camera.location, camera.rotation_euler = (-0.1, -30, 1.5), (math.radians(87.4), 0, 0)
    floor()
    return scene


def floor():
    """A diffuse ground."""
    bpy.ops.mesh.primitive_plane_add(size=5000, location=(0, 0, -1))
    material, shader, surface = blank_material("Floor", "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (0.21, 0.20, 0.19, 1)
    material.node_tree.links.new(shader.outputs[0], surface)
    bpy.context.object.data.materials.append(material)


def suzanne(place):
    """Suzanne, sitting on the floor, as the active object."""
    bpy.ops.mesh.primitive_monkey_add(size=2, location=(place * SPACING, 0, -0.19),
                                      rotation=(math.radians(-12), 0, math.radians(16 - 4 * place)))
    bpy.ops.object.shade_smooth()
    bpy.context.object.modifiers.new("Subdivision", "SUBSURF").render_levels = 3


def is_present(data, file, sample):
    """Whether the measurements have a sample: the synthetic ones have fewer."""
    path = data / file
    return path.is_file() and (not sample or sample in [name for _, name in list_samples(path)])


def draw(path, width=1050, samples=48, preset="Standard"):
    """Import each material for its Suzanne, and render them all."""
    data, _ = synthetic.measurements_or_synthetic()
    present = [material for material in MATERIALS.values() if is_present(data, *material[:2])]
    scene = stage(width, samples)
    for number, (file, sample, tint) in enumerate(present):
        suzanne(number - (len(present) - 1) / 2)
        bpy.ops.measured_brdf.import_data(filepath=str(data / file), sample=sample, preset=preset)
        set_input(bpy.context.object.active_material, "Tint", (*tint, 1))
    path.parent.mkdir(parents=True, exist_ok=True)
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.compression = 100
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    """Render to the path given, or to build/demo/title.png."""
    start = time.perf_counter()
    extension().register()
    path = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else OUT
    draw(path)
    print(f"{path}, {time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    sys.exit(main())
