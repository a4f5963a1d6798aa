"""The picture of what Add Studio makes of a new file: ``python -m demo_scenes.studio PNG``."""

import math
import sys
from pathlib import Path

import bpy

from support import sheet
from support.checkout import ROOT, extension
from support.stage import add_lamp, add_sphere, black_scene, render

OUT = ROOT / "build" / "demo" / "studio.png"
SIZE = 224
NAMES = ("gold-polished", "stainless-steel-brushed", "blue-acrylic")
GREY = 0.05                 # of the world of a new file, whose lamp is this one: place, and power in W
LAMP, POWER = (4.076, 1.005, 5.904), 1000


def main():
    """Render to the path given, or to build/demo/studio.png."""
    extension().register()
    path = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else OUT
    rows = [[_tile(name, has_studio) for name in NAMES] for has_studio in (False, True)]
    sheet.write(path, rows)
    print(path)


def _tile(name, has_studio):
    scene = black_scene(SIZE, SIZE, samples=256, span=2.3)
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 0), (math.pi / 2, 0, 0)
    scene.render.film_transparent = False
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (GREY, GREY, GREY, 1), 1
    add_lamp("POINT", POWER, LAMP, shadow_soft_size=0.1)
    add_sphere()
    bpy.ops.measured_brdf.use_published(name=name)
    bpy.context.view_layer.update()
    if has_studio:
        bpy.ops.measured_brdf.add_studio()
    picture = render(scene).copy()
    picture[..., 3] = 1
    return sheet.tile(picture, f"{bpy.context.object.active_material.name}: "
                               f"{'Add Studio' if has_studio else 'the world of a new file'}")


if __name__ == "__main__":
    sys.exit(main())
