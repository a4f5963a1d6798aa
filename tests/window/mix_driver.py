"""Mixes two materials by the dialog, as a user does, saves, and says which materials are in the file.

It runs inside of Blender's window, which has the extension and no checkout; `h` is the harness of
../shared/tools/blender_gui.
"""

import subprocess

import bpy

SAVED = "/share/mixed.blend"


def table(name):
    """A file of 64 measurements of a matte surface, in radians."""
    path = f"/share/{name}.csv"
    with open(path, "w") as file:
        file.write("#angles: radians\ntheta_i,theta_o,phi,BRDF\n")
        for number in range(64):
            file.write(f"{number % 4 * 0.4},{number // 4 % 4 * 0.4},{number // 16},{0.1 + 0.01 * (number % 4)}\n")
    return path


def setup(h):
    h.properties_column(width=400)
    h.properties_tab("MATERIAL")
    with h.override(h.area("VIEW_3D")):
        bpy.ops.object.select_all(action="DESELECT")
        bpy.ops.mesh.primitive_uv_sphere_add()
        for name in ("first", "second"):
            bpy.ops.measured_brdf.import_data(filepath=table(name), preset="Draft")
            bpy.ops.ed.undo_push(message=name)


def ask(h):
    h.window.cursor_warp(500, 400)
    names = sorted(item.name for item in bpy.data.materials if item.measured_brdf.coefficients)
    print("MADE", *names, sep="|", flush=True)
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.mix("INVOKE_DEFAULT", first=names[0], second=names[1])
    h.wait(1)


def confirm(h):
    subprocess.run(["xdotool", "key", "Return"], check=True)
    h.wait(5)           # the users of what is mixed were forgotten after two or three seconds


def save(_h):
    bpy.ops.wm.save_as_mainfile(filepath=SAVED, copy=True)
    with bpy.data.libraries.load(SAVED) as (there, _):
        print("SAVED", *sorted(there.materials), sep="|", flush=True)


steps = [ask, confirm, save]
