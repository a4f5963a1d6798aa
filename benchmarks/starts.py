"""What the start of a render costs, and a lamp that changes: processor seconds for each material, less a Principled's.

``python -m benchmarks.starts [COUNT ...]`` makes so many balls, each with a material of its own, and renders one sample
of 32 x 32 pixels (docs/rendering.md); then an animation of 24 materials under a lamp that moves: seconds for each
frame.
"""

import statistics
import sys
import tempfile
import time
from pathlib import Path

import bpy

import fitter
from fitter.cycles.node_mixture import node_mixtures
from support import ball_files, checkout, stage, synthetic
from support.evidence import show_table

from .ordinary import material_of

COUNTS = 1, 4, 20
ANIMATED = 24
FRAMES = 5
RUNS = 3
_SIZE = 32


def _scene(count, made):
    scene = stage.black_scene(_SIZE, _SIZE, 1, 1)
    scene.render.use_persistent_data = True
    lamp = stage.add_lamp("POINT", 100, (-3, -3, 4), shadow_soft_size=0.2)
    for number in range(count):
        bpy.ops.mesh.primitive_uv_sphere_add(location=(2 * number, 0, 0))
        bpy.context.object.data.materials.append(made(number))
    bpy.context.view_layer.update()
    return scene, lamp


def _seconds(scene, edit=lambda: None):
    edit()
    bpy.context.view_layer.update()
    begun = time.process_time()
    stage.render(scene)
    return time.process_time() - begun


def costs(count, made):
    """Seconds of a start, of another render, of one after a lamp has moved, has changed, and of one with another."""
    scene, lamp = _scene(count, made)
    light = lamp.data

    def move():
        lamp.location.x += 0.1

    def change():
        light.energy, light.shadow_soft_size, light.color.r = light.energy + 1, light.shadow_soft_size + 0.01, 0.5

    start = _seconds(scene)
    again, moved, changed = (statistics.median(_seconds(scene, edit) for _ in range(RUNS))
                             for edit in (lambda: None, move, change))
    return start, again, moved, changed, _seconds(scene, lambda: stage.add_lamp("POINT", 100, (3, -3, 4)))


def animation(made):
    """Seconds for each frame but the first."""
    scene, lamp = _scene(ANIMATED, made)
    for frame, x in ((1, -3), (FRAMES, 3)):
        lamp.location.x = x
        lamp.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, FRAMES
    begun = []
    bpy.app.handlers.frame_change_pre.append(lambda *_: begun.append(time.process_time()))
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame")
        bpy.ops.render.render(animation=True)
    bpy.app.handlers.frame_change_pre.pop()
    return (begun[FRAMES - 1] - begun[1]) / (FRAMES - 2)


def main(counts):
    extension = checkout.extension()
    extension.register()
    ball_files.add_openimageio()
    path = synthetic.measurements_or_synthetic()[0] / "curet" / "abrdf.dat"
    fits = [fitter.fit(fitter.load(path, str(number + 1)), **fitter.PRESETS["Standard"])
            for number in range(max(*counts, ANIMATED))]
    nodes = [node_mixtures(fit) for fit in fits]

    ways = {way: lambda number, way=way: material_of(way, fits[number], nodes[number], f"{way} {number}")
            for way in ("Principled", "Nodes", "Exact")}
    rows = []
    for count in counts:
        base = None
        for way, made in ways.items():
            found = costs(count, made)
            base = base or found
            each = [(seconds - less) / count for seconds, less in zip(found, base, strict=True)]
            if way != "Principled":
                rows.append((count, way, *(f"{seconds:.4f}" for seconds in each)))
    show_table("starts", ("materials", "", "start", "again", "moved", "changed", "another lamp"), rows)
    frames = {way: animation(made) for way, made in ways.items()}
    show_table("starts-animation", (f"{ANIMATED} materials", "s a frame", "of a Principled's"),
               [(way, f"{seconds:.3f}", f"{seconds / frames['Principled']:.2f}") for way, seconds in frames.items()])


if __name__ == "__main__":
    main([int(each) for each in sys.argv[1:]] or COUNTS)
