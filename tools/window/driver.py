"""What each picture of Blender's window shows. It runs inside of that Blender, which has the extension and no checkout.

`h` is the harness, which arranges the window: areas, scrolling, clicks. Measurements lie in /data.
"""

# ruff: noqa: D103 (the functions are the pictures)

import importlib
import sys
from types import SimpleNamespace

import bpy

PICTURE = "panel"           # ``python -m tools.window`` puts another name here
CURET, STEEL, BALL = "/data/abrdf.dat", "/data/brushed_steel.csv", "/data/ball/setup.toml"
WIDTH = 380                 # of the column of properties


def stage(h, *opened):
    """A sphere under a sun, and the column of properties with these panels of the extension open and no others."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.6)
    bpy.ops.object.shade_smooth()
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3, (0.8, 0, -0.7)
    bpy.context.scene.collection.objects.link(sun)
    bpy.context.scene.render.engine = "CYCLES"
    h.properties_column(width=WIDTH)
    h.properties_tab("MATERIAL")
    shading = h.area("VIEW_3D").spaces.active.shading
    shading.type, shading.use_scene_lights, shading.use_scene_world = "MATERIAL", True, False
    open_panels(opened)


def open_panels(names):
    """Register the sub-panels again, so that these are open when they are drawn first, without Blender's own below."""
    for cls in bpy.types.Panel.__subclasses__():
        if (getattr(cls, "bl_context", "") == "material" and not cls.__name__.startswith("MEASUREDBRDF")
                and cls.is_registered and "HIDE_HEADER" not in getattr(cls, "bl_options", ())):
            bpy.utils.unregister_class(cls)
    panels = sorted((cls for cls in bpy.types.Panel.__subclasses__()
                     if cls.is_registered and getattr(cls, "bl_parent_id", "").startswith("MEASUREDBRDF")),
                    key=lambda cls: (cls.bl_parent_id == "MEASUREDBRDF_PT_data", getattr(cls, "bl_order", 0)))
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    for cls in panels:
        rest = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
        cls.bl_options = rest if cls.__name__.removeprefix("MEASUREDBRDF_PT_") in names else rest | {"DEFAULT_CLOSED"}
        bpy.utils.register_class(cls)


def import_sample(name="velvet", path=CURET):
    bpy.ops.measured_brdf.import_data(filepath=path, sample=name, preset="Standard")


def settle(h):
    """Wait until what the panels have asked for is there, and they are drawn with it."""
    queue = next(module for name, module in sys.modules.items() if name.endswith("measured_brdf.addon.work.queue"))
    h.wait(2)
    if any(queue._lanes[name].pending() for name in ("read", "fit")):
        h.later.append(settle)


def to_the_end(h):
    h.scroll(h.area("PROPERTIES"), 6000)
    h.wait(4)


def column(h):
    return h.area("PROPERTIES")


def library(h):
    stage(h, "start")
    h.wait(25)


def panel(h):
    stage(h, "adjust")
    import_sample()
    h.wait(20)


def compare(h):
    stage(h, "data", "compare")
    import_sample()
    h.wait(4)


def compare_with(h):
    stage(h, "compare_with")
    import_sample("leather")
    bpy.ops.measured_brdf.pin()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.6, location=(4, 0, 0))
    import_sample()
    h.wait(4)


def look(h):
    stage(h, "look")
    import_sample("leather")
    bpy.ops.measured_brdf.pin()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.6, location=(4, 0, 0))
    import_sample()
    bpy.ops.measured_brdf.render_look()
    h.wait(6)


def details(h):
    stage(h, "data", "details", "settings")
    import_sample()
    h.wait(4)


def measurements(h):
    stage(h, "data")
    import_sample()
    h.wait(10)


def rendering(h):
    stage(h, "rendering")
    import_sample()
    bpy.context.scene.cycles.sample_clamp_indirect = 10
    h.wait(10)


def moved(h):
    stage(h, "data")
    import_sample()
    bpy.context.object.active_material.measured_brdf.filepath = "/data/moved/abrdf.dat"
    h.wait(6)


def fitting(h):
    stage(h)
    import_sample()
    bpy.ops.measured_brdf.use_preset(preset="Reference")
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.fit("INVOKE_DEFAULT")
    h.wait(2)


def samples(h):
    stage(h)
    area = h.area("VIEW_3D")
    h.window.cursor_warp(area.x + 330, area.y + area.height - 240)
    h.wait(2)


def choose_sample(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.choose_sample("INVOKE_DEFAULT", filepath=CURET)
    h.wait(2)


def shoot_popup(h):
    """A popup closes when the pointer leaves it, as it does before the picture of an area is taken."""
    area = h.area("VIEW_3D")
    around = SimpleNamespace(x=area.x + 120, y=area.y + area.height - 520, width=420, height=440)
    h.shoot("/share/extra-popup.png", around)


def anisotropy(h):
    stage(h, "pictures")
    import_sample("", STEEL)
    h.wait(4)


def assets(h):
    stage(h)
    for name in ("velvet", "leather", "aluminum foil", "felt"):
        import_sample(name)
        bpy.ops.measured_brdf.save_asset()
        bpy.context.object.data.materials.clear()
    h.set_area(h.area("VIEW_3D"), "ASSETS")
    h.wait(6)


def lobe(h):
    stage(h)
    import_sample("", STEEL)
    steel = bpy.context.object.active_material
    view = h.area("VIEW_3D").spaces.active
    view.region_3d.view_distance, view.shading.type = 8.5, "SOLID"
    steel.measured_brdf.shown_phi = 0.7
    bpy.context.scene.cursor.location = 0.9, -0.2, 1.4
    h.wait(4)


def inspect(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.inspect("INVOKE_DEFAULT", place="CURSOR")
    h.wait(20)


def of_this_file(h):
    h.area("FILE_BROWSER").spaces.active.params.asset_library_reference = "LOCAL"
    h.wait(6)


def photographs(h):
    h.wait(1)


def open_photographs(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_photographs(filepath=BALL)
    bpy.context.scene.measured_brdf_photographs.active = 2
    h.sidebar("Measured BRDF")
    h.wait(8)


def measure(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.measure_ball("INVOKE_DEFAULT")
    until_done(h)


def until_done(h):
    h.wait(2)
    if importlib.import_module("bl_ext.user_default.measured_brdf.addon.work.modal").running is not None:
        h.later.append(until_done)


def compare_photograph(h):
    with h.override(h.area("VIEW_3D")):
        bpy.ops.measured_brdf.compare_photograph("INVOKE_DEFAULT")
    until_done(h)


def sidebar_to_the_end(h):
    h.scroll(h.area("VIEW_3D"), 6000, "UI")
    h.wait(4)


def sidebar(h):
    return h.region(h.area("VIEW_3D"), "UI")


def whole(h):
    return max(h.window.screen.areas, key=lambda area: area.width * area.height)


# what arranges the picture, what follows a redraw later, and the area that is shown
PICTURES = {
    "library": (library, (), column),
    "panel": (panel, (settle,), column),
    "compare": (compare, (settle, to_the_end), column),
    "compare_with": (compare_with, (settle, to_the_end), column),
    "look": (look, (settle, to_the_end), column),
    "details": (details, (settle, to_the_end), column),
    "measurements": (measurements, (settle, to_the_end), column),
    "rendering": (rendering, (to_the_end,), column),
    "moved": (moved, (to_the_end,), column),
    "fitting": (fitting, (), column),
    "samples": (samples, (choose_sample, shoot_popup), whole),
    "anisotropy_panel": (anisotropy, (settle, to_the_end), column),
    "assets": (assets, (of_this_file,), whole),
    "lobe": (lobe, (inspect,), whole),
    "photographs": (photographs, (open_photographs,), whole),
    "photographs_measured": (photographs, (open_photographs, measure, compare_photograph, sidebar_to_the_end), sidebar),
}
setup, steps, crop = PICTURES[PICTURE]
steps = list(steps)
