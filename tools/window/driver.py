"""What each picture of Blender's window shows. It runs inside of that Blender, which has the extension and no checkout.

`h` is the harness, which arranges the window: areas, scrolling, clicks. Measurements lie in /data.
"""

# ruff: noqa: D103 (the functions are the pictures)

import importlib
import os
import subprocess
import sys
import time
from types import SimpleNamespace

import bpy

PICTURE = "panel"           # ``python -m tools.window`` puts another name here
CURET, STEEL, BALL = "/data/abrdf.dat", "/data/brushed_steel.csv", "/data/ball/setup.toml"
LION, LEFT_OUT = "/data/lion/dirs.lp", 121
GARNET, KRYLON = "/data/garnet_red.astm", "/data/krylon_blue.astm"
WIDTH = 380                 # of the column of properties
FRAMES = "/share/extra-frame"


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
    panels = {cls.__name__: cls for cls in bpy.types.Panel.__subclasses__()
              if cls.is_registered and getattr(cls, "bl_parent_id", "").startswith("MEASUREDBRDF")}

    def depth(cls):
        parent = panels.get(getattr(cls, "bl_parent_id", ""))
        return 0 if parent is None else 1 + depth(parent)

    panels = sorted(panels.values(), key=lambda cls: (depth(cls), getattr(cls, "bl_order", 0)))
    for cls in reversed(panels):
        bpy.utils.unregister_class(cls)
    for cls in panels:
        rest = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
        cls.bl_options = rest if cls.__name__.removeprefix("MEASUREDBRDF_PT_") in names else rest | {"DEFAULT_CLOSED"}
        bpy.utils.register_class(cls)


def import_sample(name="velvet", path=CURET):
    bpy.ops.measured_brdf.import_data(filepath=path, sample=name, preset="Standard")


def leather_beside_velvet():
    """A sphere of leather, which is pinned, and beside it one of velvet."""
    import_sample("leather")
    bpy.ops.measured_brdf.pin()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=1.6, location=(4, 0, 0))
    import_sample()


def call(h, operator, *how, **options):
    """Call an operator as from the 3D view."""
    with h.override(h.area("VIEW_3D")):
        operator(*how, **options)


def settle(h):
    """Wait until what the panels have asked for is there, and they are drawn with it."""
    queue = next(module for name, module in sys.modules.items() if name.endswith("measured_brdf.addon.work.queue"))
    h.wait(2)
    if any(lane.pending() for lane in queue._lanes.values()):
        h.later.append(settle)


def to_the_end(h):
    h.scroll(h.area("PROPERTIES"), 6000)
    h.wait(4)


def pointer_away(h):
    """From buttons, which would show a tooltip."""
    h.window.cursor_warp(10, 10)
    h.wait(2)


def column(h):
    return h.area("PROPERTIES")


def library(h):
    stage(h, "start")


def velvet(seconds, *opened):
    """The column of properties of a sphere of velvet."""
    def setup(h):
        stage(h, *opened)
        import_sample()
        h.wait(seconds)
    return setup


def layers(h):
    stage(h, "mix")
    for name in ("red-fabric", "gold-metallic-paint", "violet-acrylic"):
        bpy.ops.measured_brdf.use_published(name=name)
    bpy.ops.measured_brdf.mix(first="Red fabric", second="Gold metallic paint", factor=0.3)
    bpy.ops.measured_brdf.mix(first="Red fabric + Gold metallic paint", second="Violet acrylic", factor=0.25)
    bpy.context.object.active_material.name = "Dyed cloth"
    h.wait(10)


def flakes(h):
    stage(h, "texture")
    bpy.ops.measured_brdf.use_published(name="violet-acrylic")
    call(h, bpy.ops.measured_brdf.add_flakes)
    bpy.context.object.active_material.node_tree.nodes["Group"].inputs["Size"].default_value = 0.01
    h.area("VIEW_3D").spaces.active.region_3d.view_distance = 5
    h.wait(60)                              # EEVEE compiles


def compare(h):
    stage(h, "pictures", "compare")
    h.properties_column(width=520)          # three spheres beside one another
    import_sample()
    h.wait(4)


def compare_with(h):
    stage(h, "pictures")
    leather_beside_velvet()
    h.wait(4)


def look(h):
    stage(h, "look")
    leather_beside_velvet()
    bpy.ops.measured_brdf.render_look()
    h.wait(6)


def rendering(h):
    velvet(10, "rendering")(h)
    bpy.context.scene.cycles.sample_clamp_indirect = 10


def moved(h):
    velvet(6, "data")(h)
    bpy.context.object.active_material.measured_brdf.filepath = "/data/moved/abrdf.dat"


def fitting(h):
    stage(h)
    import_sample()
    bpy.ops.measured_brdf.use_preset(preset="Reference")
    call(h, bpy.ops.measured_brdf.fit, "INVOKE_DEFAULT")
    h.wait(2)


def samples(h):
    stage(h)
    h.area("VIEW_3D").spaces.active.shading.type = "SOLID"      # EEVEE would draw the popup late


def point(h):
    area = h.area("VIEW_3D")
    h.window.cursor_warp(area.x + 330, area.y + area.height - 240)
    h.wait(2)


def choose_sample(h):
    call(h, bpy.ops.measured_brdf.choose_sample, "INVOKE_DEFAULT", filepath=CURET)
    h.wait(2)


def nudge(h):
    """A popup is drawn again when the pointer goes to another of its entries."""
    subprocess.run(["xdotool", "mousemove_relative", "--", "0", "40", "sleep", "0.3", "mousemove_relative", "0", "-40"],
                   check=True)
    h.wait(2)


def shoot_popup(h):
    """A popup closes when the pointer leaves it, as it does before the picture of an area is taken."""
    area = h.area("VIEW_3D")
    around = SimpleNamespace(x=area.x + 320, y=area.y + area.height - 510, width=282, height=285)
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
    call(h, bpy.ops.measured_brdf.inspect, "INVOKE_DEFAULT", place="CURSOR")
    h.wait(20)


def of_this_file(h):
    h.area("FILE_BROWSER").spaces.active.params.asset_library_reference = "LOCAL"
    h.wait(6)


def photographs(h):
    h.wait(1)


def open_photographs(h):
    call(h, bpy.ops.measured_brdf.measure_photographs, filepath=BALL)
    bpy.context.scene.measured_brdf_photographs.active = 2
    h.sidebar("Measured BRDF")
    h.wait(8)


def measure(h):
    call(h, bpy.ops.measured_brdf.measure_ball, "INVOKE_DEFAULT")
    until_done(h)


def not_yet(h, step, seconds=0.2):
    """Try a step again, some time later."""
    h.later.append(step)
    h.wait(seconds)


def until_done(h):
    h.wait(2)
    if importlib.import_module("bl_ext.user_default.measured_brdf.addon.work.modal").running is not None:
        h.later.append(until_done)


def open_lion(h):
    """Each twelfth photograph is used, and one of the others shown."""
    call(h, bpy.ops.measured_brdf.measure_sample_photographs, filepath=LION)
    made = bpy.context.scene.measured_brdf_photographs
    for number, each in enumerate(made.photographs):
        each.used = number % 12 == 0
    made.active = LEFT_OUT
    h.sidebar("Measured BRDF")
    h.wait(2)


def measure_lion(h):
    call(h, bpy.ops.measured_brdf.measure_sample)
    h.wait(2)


def compare_photograph(h):
    call(h, bpy.ops.measured_brdf.compare_photograph, "INVOKE_DEFAULT")
    until_done(h)


def sidebar_to_the_end(h):
    h.scroll(h.area("VIEW_3D"), 6000, "UI")
    h.wait(4)


def sidebar(h):
    return h.region(h.area("VIEW_3D"), "UI")


def first_material(h):
    """The material tab of the cube on an empty profile, and the seconds that Blender does not answer."""
    uninstall()
    h.wait(1)


def gold_ring(h):
    """From an empty profile to a rendered ring of gold: the tab, a picture, F12. Only its mesh is there before."""
    uninstall()
    cube = bpy.context.object
    bpy.ops.mesh.primitive_torus_add(major_segments=96, minor_segments=32, minor_radius=0.35, location=cube.location)
    bpy.ops.object.shade_smooth()
    bpy.data.objects.remove(cube)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 32
    scene.render.resolution_x, scene.render.resolution_y = 480, 270
    h.wait(1)


def uninstall():
    places = [repository.module for repository in bpy.context.preferences.extensions.repos]
    bpy.ops.extensions.package_uninstall(repo_index=places.index("user_default"), pkg_id="measured_brdf")


def install(h):
    bpy.app.timers.register(beat)
    begin("all")
    begin("install")
    bpy.ops.extensions.package_install_files(filepath="/share/ext.zip", repo="user_default", enable_on_install=True)
    tell("Install from Disk", "install")
    h.wait(1)


def beat():
    """Notice how long Blender does not answer: a timer."""
    now = time.monotonic()
    began["longest"] = max(began.get("longest", 0), now - began.get("beat", now))
    began["beat"] = now
    return 0.05


def open_tab(h):
    area = column(h)
    began["longest"] = 0
    press(h, area.x + 15, area.y + area.height - 451, "tab")
    h.wait(0.2)


def until_there(h):
    if column(h).spaces.active.context != "MATERIAL" and time.monotonic() - began["tab"] > 5:
        raise RuntimeError("the click has not opened the material tab")
    shelf = importlib.import_module("bl_ext.user_default.measured_brdf.addon.starter.shelf")
    if not shelf.published_icon("gold-polished") or "gold-polished" in shelf.coming():      # and what is beside it
        return not_yet(h, until_there)
    tell("Open the material tab, until its pictures are there", "tab")
    h.wait(0.5)                     # they are drawn


def click_picture(h):
    area = column(h)
    press(h, area.x + 70, area.y + area.height - 330, "click")
    h.wait(0.1)


def press(h, x, y, what):
    subprocess.run(["xdotool", "mousemove", str(x), str(h.window.height - y), "sleep", "0.2", "click", "1"], check=True)
    begin(what)


def until_made(h):
    made = bpy.context.object.active_material
    if made is None or "gold" not in made.name.lower():
        return not_yet(h, until_made, 0.1)
    tell(f"Click a picture, until the object has {made.name}", "click")


def render_ring(h):
    """What F12 calls: the key itself does not arrive on a screen without a window manager."""
    bpy.app.handlers.render_complete.append(lambda *_: began.setdefault("rendered", time.monotonic()))
    begin("render")
    call(h, bpy.ops.render.render, "INVOKE_DEFAULT")
    h.wait(0.2)


def until_rendered(h):
    if "rendered" not in began:
        return not_yet(h, until_rendered)
    tell("F12, until the picture is rendered", "render")
    tell("All, with the way of the pointer", "all")
    h.wait(3)


def until_icon(h):
    """Until Blender has drawn its own picture of the cube's material."""
    if bpy.app.is_job_running("RENDER_PREVIEW") or time.monotonic() - began["tab"] < 20:
        return not_yet(h, until_icon, 0.5)
    tell("Blender's own picture of the cube's material, or 20 s", "tab")
    print("TIME", "The longest of these that Blender did not answer", f"{began['longest']:.1f} s", sep="|", flush=True)


def begin(what):
    began[what], began[what, "processor"] = time.monotonic(), processor()


def processor():
    """Seconds of processor of Blender and of the workers that have ended."""
    return sum(os.times()[:4])


def tell(what, name):
    print("TIME", what, f"{time.monotonic() - began[name]:.1f} s",
          f"{processor() - began[name, 'processor']:.1f} s of processor in Blender itself", sep="|", flush=True)


began = {}                  # what is timed, and when it began


def film(h, seconds, around):
    """Take pictures of a part of the window for some seconds, as fast as they come, each named after the pointer."""
    left, top = around.x, h.window.height - around.y - around.height
    subprocess.Popen(["bash", "-c", f"""
        end=$(($(date +%s) + {seconds})); number=1000
        while [ $(date +%s) -lt $end ]; do
            eval $(xdotool getmouselocation --shell)
            import -silent -window root -crop {around.width}x{around.height}+{left}+{top} +repage \
                {FRAMES}-$((number++))-$((X - {left}))-$((Y - {top})).png
        done"""])
    h.wait(seconds + 2)


def drag(places, pause=0.25, hold=1.0):
    """Press at the first place, move through the others, and release; in pixels from the top left of the window."""
    (x, y), *others = ([str(round(each)) for each in place] for place in places)
    moves = [word for place in others for word in ("mousemove", *place, "sleep", str(pause))]
    subprocess.Popen(["xdotool", "mousemove", x, y, "sleep", str(hold), "mousedown", "1", "sleep", str(hold), *moves,
                      "sleep", str(hold), "mouseup", "1"])


def between(first, last, count=16):
    """Places on the way from one to another."""
    return [[a + step / count * (b - a) for a, b in zip(first, last, strict=True)] for step in range(count + 1)]


def screen(h):
    return SimpleNamespace(x=0, y=0, width=h.window.width, height=h.window.height)


def film_stage(h, *opened):
    """As `stage`, with a view that is drawn quickly, and drags as far as the pointer goes."""
    stage(h, *opened)
    bpy.context.preferences.inputs.use_mouse_continuous = False
    view = h.area("VIEW_3D").spaces.active
    view.region_3d.view_distance, view.shading.type = 8.5, "SOLID"


def film_adjust(h):
    film_stage(h, "adjust")
    import_sample("", GARNET)
    h.scroll(h.area("PROPERTIES"), 120)
    h.wait(4)


def drag_slider(h):
    """Highlight Width, to the right and back."""
    area = h.area("PROPERTIES")
    left, right = ((area.x + x, h.window.height - area.y - area.height + 619) for x in (240, 300))
    drag(between(left, right) + between(right, (left[0] - 15, left[1])), 0.4)
    film(h, 40, area)


def adjusted(h):
    if bpy.context.object.active_material.measured_brdf.adjusted in ("", "{}"):
        raise RuntimeError("the slider has not moved")


def film_compare(h):
    film_stage(h, "pictures")
    import_sample("", KRYLON)
    bpy.ops.measured_brdf.pin()
    import_sample("", GARNET)
    h.wait(10)


def drag_line(h):
    area = h.area("PROPERTIES")
    middle, left, right = ((area.x + x, h.window.height - area.y - 367) for x in (125, 85, 165))
    drag([*between(middle, right), *between(right, left), *between(left, middle)])
    film(h, 24, area)


def film_inspect(h):
    film_stage(h)
    import_sample("", GARNET)
    bpy.context.scene.cursor.location = 0.9, -0.2, 1.4
    h.wait(4)


def drag_light(h):
    area = h.area("VIEW_3D")
    at = area.x + area.width // 2, h.window.height - area.y - area.height // 2 - 120
    drag(between(at, (at[0] + 150, at[1])) + between((at[0] + 150, at[1]), (at[0] - 60, at[1] - 80)))
    film(h, 24, area)


def film_drop(h):
    film_stage(h)
    h.area("VIEW_3D").spaces.active.shading.type = "MATERIAL"
    area = h.area("DOPESHEET_EDITOR")
    h.move_edge(lambda h: (area.x + area.width // 2, area.y + area.height), lambda h: 180)
    h.set_area(area, "FILES")
    h.wait(60)


def open_folder(h):
    params = h.area("FILE_BROWSER").spaces.active.params
    params.directory, params.display_type, params.filter_search = b"/data", "THUMBNAIL", "garnet_red.a"
    h.wait(6)


def drag_file(h):
    files, view = (h.region(h.area(kind)) for kind in ("FILE_BROWSER", "VIEW_3D"))
    start = files.x + 62, h.window.height - (files.y + files.height - 64)
    end = view.x + view.width // 2, h.window.height - (view.y + view.height // 2)
    drag(between(start, end, 10), 0.5)
    film(h, 110, screen(h))


def dropped(h):
    if not any(item.measured_brdf.coefficients for item in bpy.data.materials):
        raise RuntimeError("no material was made of the file")


def sphere_and_column(h):
    area = h.area("VIEW_3D")
    return SimpleNamespace(x=area.x + area.width // 2 - 250, y=area.y, width=area.width // 2 + 250 + WIDTH,
                           height=area.height)


def whole(h):
    return max(h.window.screen.areas, key=lambda area: area.width * area.height)


# what arranges the picture, what follows a redraw later, and the area that is shown
PICTURES = {
    "library": (library, (settle,), column),
    "panel": (velvet(20, "adjust"), (settle,), column),
    "layers": (layers, (settle,), column),
    "flakes": (flakes, (settle,), sphere_and_column),
    "compare": (compare, (settle, to_the_end), column),
    "compare_with": (compare_with, (settle, to_the_end, pointer_away), column),
    "look": (look, (settle, to_the_end), column),
    "details": (velvet(4, "data", "details", "settings"), (settle, to_the_end), column),
    "measurements": (velvet(10, "data"), (settle, to_the_end), column),
    "rendering": (rendering, (to_the_end,), column),
    "moved": (moved, (to_the_end,), column),
    "fitting": (fitting, (), column),
    "samples": (samples, (point, choose_sample, settle, nudge, shoot_popup), whole),
    "anisotropy_panel": (anisotropy, (settle, to_the_end), column),
    "assets": (assets, (of_this_file,), whole),
    "lobe": (lobe, (inspect,), whole),
    "photographs": (photographs, (open_photographs,), whole),
    "sample_measured": (photographs, (open_lion, measure_lion, compare_photograph, sidebar_to_the_end), whole),
    "photographs_measured": (photographs, (open_photographs, measure, compare_photograph, sidebar_to_the_end), sidebar),
}
# likewise: films, and what is timed
OTHERS = {
    "adjust": (film_adjust, (settle, drag_slider, adjusted), column),
    "compare_drag": (film_compare, (settle, to_the_end, drag_line), column),
    "inspect": (film_inspect, (inspect, drag_light), whole),
    "drop": (film_drop, (open_folder, drag_file, dropped), screen),
    "ring": (gold_ring, (install, open_tab, until_there, click_picture, until_made, render_ring, until_rendered),
             screen),
    "icon": (first_material, (install, open_tab, until_there, until_icon), column),
}
setup, steps, crop = (PICTURES | OTHERS)[PICTURE]
steps = list(steps)
