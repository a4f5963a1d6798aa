"""What the start of a render costs, and a moved lamp: processor seconds for each material, less a Principled's.

``python -m benchmarks.starts [COUNT ...]`` makes so many balls, 1, 4 and 20 by default, each with a material of its
own, and renders one sample of 32 x 32 pixels: first; again with the data kept, as a viewport does; after a lamp has
moved and its values were written; and while it is dragged, when they are not.
"""

import statistics
import sys
import time

import bpy

import fitter
from fitter.cycles.node_mixture import node_mixtures
from support import ball_files, checkout, stage, synthetic
from support.evidence import show_table

from .ordinary import principled_material

COUNTS = 1, 4, 20
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


def _seconds(scene):
    begun = time.process_time()
    stage.render(scene)
    return time.process_time() - begun


def costs(count, made, lamps):
    """Seconds of a start, of another render, of one after a lamp's move and of one during a drag."""
    scene, lamp = _scene(count, made)
    start = _seconds(scene)
    again = statistics.median(_seconds(scene) for _ in range(RUNS))
    moved = []
    for _ in range(RUNS):
        lamp.location.x += 0.1
        bpy.context.view_layer.update()
        moved.append(_seconds(scene))
    has_window = lamps.has_window
    of_renders = ((bpy.app.handlers.render_init, lamps._before_use),
                  (bpy.app.handlers.frame_change_post, lamps._on_frame))
    for handlers, handler in of_renders:            # a viewport renders without them
        handlers.remove(handler)
    lamps.has_window = lambda: True
    dragged = []
    for _ in range(RUNS):
        lamp.location.x += 0.1
        bpy.context.view_layer.update()
        dragged.append(_seconds(scene))
    lamps.has_window = has_window
    for handlers, handler in of_renders:
        handlers.append(handler)
    lamps.update(bpy.context.evaluated_depsgraph_get())
    return start, again, statistics.median(moved), statistics.median(dragged)


def main(counts):
    """Print the table."""
    extension = checkout.extension()
    extension.register()
    ball_files.add_openimageio()
    lamps = extension.addon.core.lamps
    path = synthetic.measurements_or_synthetic()[0] / "curet" / "abrdf.dat"
    fits = [fitter.fit(fitter.load(path, str(number + 1)), **fitter.PRESETS["Standard"])
            for number in range(max(counts))]
    nodes = [node_mixtures(fit) for fit in fits]

    def measured(number, by_nodes):
        material = stage.material_for(fits[number], nodes[number])
        stage.set_input(material, "Nodes", by_nodes)
        return material

    ways = {"Principled": lambda number: principled_material(fits[number], f"Principled {number}"),
            "Nodes": lambda number: measured(number, True), "Exact": lambda number: measured(number, False)}
    rows = []
    for count in counts:
        base = None
        for way, made in ways.items():
            found = costs(count, made, lamps)
            base = base or found
            each = [(seconds - less) / count for seconds, less in zip(found, base, strict=True)]
            if way != "Principled":
                rows.append((count, way, *(f"{seconds:.3f}" for seconds in each)))
    show_table("starts", ("materials", "", "start", "again", "moved", "dragged"), rows)


if __name__ == "__main__":
    main([int(each) for each in sys.argv[1:]] or COUNTS)
