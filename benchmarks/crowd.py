"""What many measured materials cost Blender: ``python -m benchmarks.crowd [COUNT ...]``, 1, 10 and 50 by default.

Synthetic data of the preset Draft, one for each material, on a plane each, under one lamp. Milliseconds, the median of
REPEATS: an undo step; a lamp's move; a frame with ANIMATED lamps of which each moves; a redraw of all panels of the
extension, all open, with all answers there; saving and loading. All less what the same takes without a measured
material, but for redraw and load.
"""

import contextlib
import functools
import io
import statistics
import sys
import tempfile
import time
from pathlib import Path
from types import SimpleNamespace

import bpy

from support import checkout, drawn, stage
from support.synthetic import make_files

REPEATS, ANIMATED = 11, 100
COLUMNS = "undo", "move", "frame", "redraw", "save", "load"


def main():
    """Print one row for each count."""
    counts = sorted(map(int, sys.argv[1:])) or [1, 10, 50]
    checkout.extension().register()
    with tempfile.TemporaryDirectory() as folder:
        files = make_files(Path(folder), counts[-1])
        base = measured(Path(folder), [])
        print("materials" + "".join(f"{name:>9}" for name in COLUMNS) + "   ms", flush=True)
        for count in counts:
            row = measured(Path(folder), files[:count])
            less = {name: 0.0 if name in ("redraw", "load") else base[name] for name in COLUMNS}
            print(f"{count:9}" + "".join(f"{row[name] - less[name]:9.1f}" for name in COLUMNS), flush=True)


def measured(folder, files):
    """Milliseconds by name, in a new scene with a material of each file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.preferences.edit.use_global_undo = True
    scene = stage.black_scene(8, 8, 1, span=1)
    lamp = stage.add_lamp("POINT", 1, (0, 0, 1))
    for path in files:
        bpy.ops.mesh.primitive_plane_add()
        with contextlib.redirect_stdout(io.StringIO()):
            bpy.ops.measured_brdf.import_data(filepath=str(path), preset="Draft")
    path = folder / "crowd.blend"
    found = {"undo": timed(lambda: bpy.ops.ed.undo_push(message="step")),
             "move": timed(lambda: moved(lamp)), "redraw": timed(redrawn) if files else 0.0}
    for number in range(ANIMATED - 1):
        stage.add_lamp("POINT", 1, (number, 0, 1))
    for each in [item for item in scene.objects if item.type == "LIGHT"]:
        each.driver_add("location", 2).driver.expression = "frame * 0.01"
    bpy.context.view_layer.update()
    found["frame"] = timed(lambda: scene.frame_set(scene.frame_current + 1))
    found["save"] = timed(lambda: bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True))
    found["load"] = timed(lambda: bpy.ops.wm.open_mainfile(filepath=str(path)), 3)
    return found


def timed(run, repeats=REPEATS):
    """The median milliseconds of a function."""
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):
            run()
        seconds.append(time.perf_counter() - start)
    return 1e3 * statistics.median(seconds)


def moved(lamp):
    """Move a lamp, as dragging does."""
    lamp.location.x += 0.01
    bpy.context.view_layer.update()


def redrawn():
    """Draw all panels in the material tab for the active object, once their questions have been answered."""
    from measured_brdf.addon.work import queue

    shown = {"material": bpy.context.object.active_material}
    context = SimpleNamespace(object=bpy.context.object, scene=bpy.context.scene, preferences=bpy.context.preferences,
                              **shown)
    for panel in panels():
        if getattr(panel, "poll", lambda _: True)(context):
            drawn.draw(panel, **shown)
    queue.answer_all()


@functools.cache
def panels():
    """The panels of the extension in the material tab: Blender has a thousand others."""
    return [panel for panel in bpy.types.Panel.__subclasses__()
            if panel.__module__.startswith("measured_brdf.") and getattr(panel, "bl_context", "") == "material"]


if __name__ == "__main__":
    sys.exit(main())
