"""Measures photographs as a user does, with the file browser and in the background, and says what came of it.

It runs inside of Blender's window, which has the extension and no checkout; `h` is the harness of
../shared/tools/blender_gui. The photographs lie in /share/src/ball.
"""

import importlib
from pathlib import Path

import bpy

FOLDER = Path("/share/src/ball")


def running():
    return importlib.import_module("bl_ext.user_default.measured_brdf.addon.work.modal").running


def until_done(h):
    h.wait(1)
    if running() is not None:
        h.later.append(until_done)


def settings(h):
    return h.window.scene.measured_brdf_photographs


def setup(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_photographs("INVOKE_DEFAULT")
    h.wait(2)


def browser():
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "FILE_BROWSER" and area.spaces.active.active_operator is not None:
                return window, area
    raise LookupError("no file browser")


def choose(h):
    window, area = browser()
    params = area.spaces.active.params
    params.directory = str(FOLDER).encode()
    params.filename = "setup.toml"
    region = next(each for each in area.regions if each.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.file.execute()
    h.wait(2)


def outline(h):
    made = settings(h)
    view = h.area("VIEW_3D").spaces.active.region_3d.view_perspective
    print("OPENED", len(made.photographs), view, sep="|", flush=True)
    made.preset, made.ball.location = "Draft", (0.001, 0, 0)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.ed.undo_push(message="moved")
        bpy.ops.measured_brdf.fit_outline("INVOKE_DEFAULT")
    until_done(h)


def measure(h):
    print("OUTLINE", *(f"{each:.4f}" for each in settings(h).ball.location), sep="|", flush=True)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_ball("INVOKE_DEFAULT")
    until_done(h)


def compare(h):
    material = settings(h).ball.active_material
    print("MEASURED", material.measured_brdf.coefficients > 0, sep="|", flush=True)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.compare_photograph("INVOKE_DEFAULT")
    until_done(h)


def undo(h):
    print("COMPARED", f"{settings(h).photographs[0].difference:.4f}", sep="|", flush=True)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.ed.undo()
        bpy.ops.ed.undo()
    h.wait(1)


def undone(h):
    material = settings(h).ball.active_material
    print("UNDONE", material.measured_brdf.coefficients, settings(h).told == "", sep="|", flush=True)


steps = [choose, until_done, outline, measure, compare, undo, undone]
