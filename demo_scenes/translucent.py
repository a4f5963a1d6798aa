"""The picture of translucent materials, lit from behind: ``python -m demo_scenes.translucent PNG``."""

import math

import bpy

from support import sheet
from support.stage import add_lamp, background, render, set_input, suzanne

from . import run

SIZE, SAMPLES = 224, 64
NAMES = ("marble", "skin-1", "skim-milk")
METRES = {0.2: "40 cm wide", 0.01: "2 cm wide"}         # per unit, of a head of two


def draw(path, size=SIZE, samples=SAMPLES):
    """Draw heads of some materials at two scales, `size` pixels on a side."""
    sheet.write(path, [[_tile(name, metres, size, samples) for name in NAMES] for metres in METRES])


def _tile(name, metres, size, samples):
    scene = suzanne()
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.cycles.samples = samples
    scene.camera.data.lens = 84
    background(scene, 0.08, (0.75, 0.85, 1.0))
    bpy.data.objects["Area"].data.energy = 60
    add_lamp("AREA", 700, (2.2, 3.4, 2.2), (math.radians(-62), 0, math.radians(-32)), shape="SQUARE", size=1.5)
    bpy.ops.measured_brdf.use_published(name=name)
    material = bpy.context.object.active_material
    set_input(material, "Scale", metres)
    return sheet.tile(render(scene), f"{material.name}, {METRES[metres]}")


if __name__ == "__main__":
    run(draw, "translucent.png")
