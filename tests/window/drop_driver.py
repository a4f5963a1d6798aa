"""Drops assets of the starter library onto the default cube, as a user does, and says what the cube then has.

It runs inside of Blender's window, which has the extension with its library and no checkout; `h` is the harness of
../shared/tools/blender_gui.
"""

import hashlib
import importlib
import subprocess
import time

import bpy

METHODS = "APPEND", "PACK"      # that of the library as the extension adds it, and Blender's default
PAUSE = 10                      # s, until the browser shows a library


def extension(name):
    return importlib.import_module(f"bl_ext.user_default.measured_brdf.addon.{name}")


def setup(h):
    area = h.area("DOPESHEET_EDITOR")
    h.move_edge(lambda h: (area.x + area.width // 2, area.y + area.height), lambda h: 250)
    h.set_area(area, "ASSETS")
    bpy.ops.measured_brdf.add_starter_library()
    libraries = bpy.context.preferences.filepaths.asset_libraries
    print("LIBRARY", libraries[-1].import_method, sep="|", flush=True)
    h.wait(2)


def show(h):
    space = h.area("FILE_BROWSER").spaces.active
    space.params.asset_library_reference = bpy.context.preferences.filepaths.asset_libraries[-1].name
    h.wait(PAUSE)


def drop(method):
    def step(h):
        bpy.context.preferences.filepaths.asset_libraries[-1].import_method = method
        bpy.context.object.data.materials.clear()
        tiles, view = (h.region(h.area(kind)) for kind in ("FILE_BROWSER", "VIEW_3D"))
        start = tiles.x + 50, h.window.height - (tiles.y + tiles.height - 60)
        end = view.x + view.width // 2, h.window.height - (view.y + view.height // 2)
        moves = [part for share in (0.1, 0.3, 0.6, 0.9, 1, 1) for part in (
            "mousemove", *(str(round(a + share * (b - a))) for a, b in zip(start, end, strict=True)), "sleep", "1")]
        # not waited for: Blender takes up each event as it comes
        subprocess.Popen(["xdotool", "mousemove", *map(str, start), "sleep", "1", "mousedown", "1", "sleep", "1",
                          *moves, "mouseup", "1"])
    return step


def redraw(h):
    h.wait(2)           # between two steps the harness draws the window, which a drag waits for


def tell(method):
    def step(_h):
        item = bpy.context.object.active_material
        material, node_group, rendered = (
            extension(f"core.shading.{name}") for name in ("material", "node_group", "rendered"))
        fit = node_group.kept_fit(material.group_node(item).node_tree)
        print("DROPPED", method, item.name, item.library is not None, material.is_measured(item),
              rendered.scene_rendering(item, bpy.context.scene).how, hashlib.sha256(fit).hexdigest(), sep="|",
              flush=True)
    return step


def click(h):
    start = time.perf_counter()
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.use_published("INVOKE_DEFAULT", name="alumina-oxide")
    bpy.context.view_layer.update()
    fit = extension("core.shading.node_group").kept_fit(
        extension("core.shading.material").group_node(bpy.context.object.active_material).node_tree)
    print("CLICKED", f"{time.perf_counter() - start:.2f}", hashlib.sha256(fit).hexdigest(), sep="|", flush=True)


steps = [show, *(step for method in METHODS for step in (drop(method), *[redraw] * 12, tell(method))), click]
