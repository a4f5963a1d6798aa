"""Measures a flat sample as a user does: its corners are clicked in the Image Editor, Esc ends the first try.

It runs inside of Blender's window, which has the extension and no checkout; `h` is the harness of
../shared/tools/blender_gui. The description, whose corners are wrong by some pixels, and the photographs lie in
/share/src/flat, and the corners to be clicked, in pixels from the left and the top, in corners.json.
"""

import importlib
import json
import subprocess
from functools import partial
from pathlib import Path

import bpy

FOLDER = Path("/share/src/flat")
KINDS = "objects", "materials", "images", "meshes", "node_groups", "texts"


def running():
    return importlib.import_module("bl_ext.user_default.measured_brdf.addon.work.modal").running


def until_done(h):
    h.wait(1)
    if running() is not None:
        h.later.append(until_done)


def counts():
    return [len(getattr(bpy.data, kind)) for kind in KINDS]


def settings(h):
    return h.window.scene.measured_brdf_photographs


def setup(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_sample_photographs("INVOKE_DEFAULT", filepath=str(FOLDER / "setup.toml"))
    until_done(h)


def edit_mask(h):
    """The Image Editor in the place of the 3D view, with a photograph and a new mask."""
    area = h.area("VIEW_3D")
    area.ui_type = "IMAGE_EDITOR"
    space = area.spaces.active
    space.image = settings(h).photographs[0].picture
    space.mode = "MASK"
    with h.override(area):
        bpy.ops.mask.new(name="Corners")
        bpy.ops.image.view_all(fit_view=True)
    h.wait(1)


def press(step, h):
    subprocess.run(["xdotool", *step], check=True)
    h.wait(0.3)


def draw(h):
    area = h.area("IMAGE_EDITOR")
    region, (width, height) = h.region(area), area.spaces.active.image.size
    for x, y in json.loads((FOLDER / "corners.json").read_text()):
        right, up = region.view2d.view_to_region(x / width, 1 - y / height, clip=False)
        # one at a time: Blender asks which keys are down when it takes the event
        for step in (["mousemove", str(region.x + right), str(h.window.height - region.y - up - 1)],
                     ["keydown", "Control_L"], ["mousedown", "1"], ["mouseup", "1"], ["keyup", "Control_L"]):
            h.later.append(partial(press, step))


def measure(h):
    area = h.area("IMAGE_EDITOR")
    points = bpy.data.masks["Corners"].layers[0].splines[0].points
    print("DRAWN", len(points), sep="|", flush=True)
    area.ui_type = "VIEW_3D"
    settings(h).drawn_corners = bpy.data.masks["Corners"]
    print("BEFORE", *counts(), sep="|", flush=True)
    with h.override(area):
        bpy.ops.measured_brdf.measure_sample("INVOKE_DEFAULT")
    h.wait(0.5)


def escape(h):
    print("WORKS", running() is not None, sep="|", flush=True)
    h.window.cursor_warp(h.window.width // 2, h.window.height // 2)
    subprocess.run(["xdotool", "key", "Escape"], check=True)
    h.wait(2)


def again(h):
    print("ESCAPED", running() is None, *counts(), sep="|", flush=True)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_sample("INVOKE_DEFAULT")
    until_done(h)


def tell(h):
    made = settings(h).sample
    # not those that are exported in the place of a mix
    packed = sum(image.packed_file is not None and image.name.startswith(made.active_material.name)
                 for image in bpy.data.images)
    print("MADE", *(f"{each:.4f}" for each in made.dimensions), made.active_material.name, packed, sep="|", flush=True)
    h.wait(1)


steps = [edit_mask, draw, measure, escape, again, tell]
