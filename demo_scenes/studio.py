"""The picture of what Add Studio makes of a new file: ``python -m demo_scenes.studio PNG``."""

import math

import bpy

from support import sheet
from support.stage import add_lamp, add_sphere, background, black_scene, render

from . import run

SIZE = 224
NAMES = ("gold-polished", "stainless-steel-brushed", "blue-acrylic")
GREY = 0.05                 # of the world of a new file, whose lamp is this one: place, and power in W
LAMP, POWER = (4.076, 1.005, 5.904), 1000


def draw(path):
    sheet.write(path, [[_tile(name, has_studio) for name in NAMES] for has_studio in (False, True)])


def _tile(name, has_studio):
    scene = black_scene(SIZE, SIZE, samples=256, span=2.3)
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 0), (math.pi / 2, 0, 0)
    scene.render.film_transparent = False
    background(scene, 1, (GREY, GREY, GREY))
    add_lamp("POINT", POWER, LAMP, shadow_soft_size=0.1)
    add_sphere()
    bpy.ops.measured_brdf.use_published(name=name)
    bpy.context.view_layer.update()
    if has_studio:
        bpy.ops.measured_brdf.add_studio()
    return sheet.tile(render(scene)[..., :3], f"{bpy.context.object.active_material.name}: "
                                              f"{'Add Studio' if has_studio else 'the world of a new file'}")


if __name__ == "__main__":
    run(draw, "studio.png")
