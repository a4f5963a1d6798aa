"""Anisotropic materials: a brushed pan and a satin cloth, measured at 16 rotations (synthetic tables).

``make demo`` draws them; ``python -m demo_scenes.anisotropic PATH`` only these.
"""

import bpy
import numpy as np

from fitter.imaging.pictures import srgb
from support import sheet
from support.anisotropic import SATIN, STEEL, write_table
from support.checkout import ROOT
from support.stage import add_lamp, background, black_scene, look, render, rotation_toward, simple_material

from . import run

DATA = ROOT / "build" / "synthetic"
WIDTH, HEIGHT = 480, 360
ROTATIONS, SAMPLES, STANDARD = 16, 24, {"preset": "Standard"}
# of the pan, from the middle of its floor to the rim and down its outside: radius and height
PAN = ((0, 0), (0.78, 0), (0.85, 0.012), (0.905, 0.05), (0.94, 0.11), (1.03, 0.34), (1.05, 0.355), (1.068, 0.345),
       (1.06, 0.32), (0.965, 0.08), (0.91, 0.01), (0.84, -0.035), (0, -0.04))
# of its handle, from one end to the other: radius and place along it
HANDLE = ((0, 0), (0.05, 0.005), (0.055, 0.03), (0.042, 0.25), (0.05, 0.62), (0.07, 1.0), (0.06, 1.12), (0.025, 1.17),
          (0, 1.175))


def pan():
    """A pan that was turned on a lathe: its tangent is the default one, around its Z axis."""
    return revolved("Pan", smooth(np.array(PAN), 8), 256)


def handle(direction):
    """The pan's handle, a rod that was turned as well: it points away from the pan, toward an azimuth, and up."""
    item = revolved("Handle", smooth(np.array(HANDLE)[::-1], 8), 64)
    item.location = 0.99 * np.cos(direction), 0.99 * np.sin(direction), 0.31
    item.rotation_euler = 0, np.radians(76), direction
    item.scale.x = 0.6          # flattened
    return item


def smooth(points, steps):
    """Points (n, 2) on a spline through others, `steps` between two."""
    before, after = np.vstack([points[:1], points[:-1]]), np.vstack([points[1:], points[-1:]])
    slope = (after - before) / 2
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    rows = []
    for k in range(len(points) - 1):
        t = np.linspace(0, 1, steps, endpoint=False)[:, None]
        # slopes no longer than the piece itself: no loops beside short pieces
        a, b = (each * min(1, length[k] / max(np.linalg.norm(each), 1e-9)) for each in (slope[k], slope[k + 1]))
        rows.append((2 * t ** 3 - 3 * t ** 2 + 1) * points[k] + (t ** 3 - 2 * t ** 2 + t) * a
                    + (3 * t ** 2 - 2 * t ** 3) * points[k + 1] + (t ** 3 - t ** 2) * b)
    return np.vstack([*rows, points[-1:]])


def revolved(name, profile, segments):
    """A smooth surface of revolution about Z, of (radius, height), as the active object."""
    angle = np.arange(segments) / segments * 2 * np.pi
    radius, height = profile.T
    places = np.stack([radius[:, None] * np.cos(angle), radius[:, None] * np.sin(angle),
                       np.repeat(height[:, None], segments, axis=1)], axis=-1).reshape(-1, 3)
    ring = np.arange(len(profile) - 1)[:, None] * segments
    this, following = np.arange(segments)[None], (np.arange(segments)[None] + 1) % segments
    faces = np.stack([ring + this, ring + segments + this, ring + segments + following, ring + following], axis=-1)
    return meshed(name, places, faces.reshape(-1, 4))


def cloth(columns=420, rows=240):
    """Satin that hangs in folds and is laid on the ground in front, with a UV map along its threads."""
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    places = folds(u, v)
    item = meshed("Satin", places.reshape(-1, 3), grid_faces(columns, rows))
    uv = item.data.uv_layers.new(name="Threads").uv
    corners = np.empty(len(item.data.loops), int)
    item.data.loops.foreach_get("vertex_index", corners)
    uv.foreach_set("vector", np.stack([u.ravel(), v.ravel()], axis=-1)[corners].astype(np.float32).ravel())
    return item


def grid_faces(columns, rows):
    """The quads of a grid of vertices, row by row."""
    corner = np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)[None]
    return np.stack([corner, corner + 1, corner + columns + 1, corner + columns], axis=-1).reshape(-1, 4)


def folds(u, v):
    """Places (..., 3) of the cloth: u across its folds, v from the ground in front up the wall behind."""
    length, lying, bend = 3.3, 1.05, 0.45
    arc, s = bend * np.pi / 2, v * length
    turn = np.clip((s - lying) / arc, 0, 1) * np.pi / 2          # of the cloth's normal, from up to the viewer
    y = np.minimum(s - lying, 0) + bend * np.sin(turn)
    z = bend * (1 - np.cos(turn)) + np.maximum(s - lying - arc, 0)
    # folds wander, and come together toward the top
    at = u + 0.02 * np.sin(5.1 * u + 2.2 * v) + 0.012 * np.sin(9.7 * u - 3.0 * v + 1.0)
    phase = 2 * np.pi * 4.2 * at + 0.6 * np.sin(1.9 * v + 0.4)
    height = (0.10 + 0.03 * np.sin(3.7 * u + 0.5)) * np.sin(phase)
    height += 0.035 * np.sin(1.73 * phase + 1.8 * v + 1.3) + 0.016 * np.sin(3.3 * phase - 1.2 * v)
    height *= np.clip(0.4 + 0.9 * v, 0, 1)                       # they flatten where the cloth lies
    x = (u - 0.5) * (4.4 - 0.5 * v) + 0.035 * np.sin(2 * phase)
    return np.stack([x, y - height * np.sin(turn), z + height * np.cos(turn)], axis=-1)


def meshed(name, places, faces):
    """A smooth mesh of places (n, 3) and quads (m, 4), as the active object."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(places.tolist(), [], faces.tolist())
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    return item


def imported(truth, choices):
    """Import a table of a truth for the active object, as a user would. Returns the material."""
    path = write_table(DATA / f"{truth.name.replace(' ', '_')}.csv", truth, ROTATIONS)
    bpy.ops.measured_brdf.import_data(filepath=str(path), **choices)
    return bpy.context.object.active_material


def plain(item, color):
    """A diffuse material for an object."""
    item.data.materials.append(simple_material(item.name, "ShaderNodeBsdfDiffuse", {"Color": (*color, 1)}))


def studio(samples=SAMPLES):
    """A dark room."""
    scene = black_scene(WIDTH, HEIGHT, samples, span=1)
    scene.render.film_transparent = False
    scene.cycles.use_denoising = True
    scene.cycles.max_bounces = 4
    background(scene, 0.04, (0.8, 0.9, 1.0))
    return scene


def lamp(energy, location, target, size, color=(1, 1, 1)):
    """A square lamp that looks at a place."""
    add_lamp("AREA", energy, location, rotation_toward(location, target), shape="SQUARE", size=size, color=color)


def brushed_pan(samples=SAMPLES, choices=STANDARD):
    """The pan on a table, seen from above at a slant."""
    scene = studio(samples)
    item = pan()
    item.location.z = 0.04
    material = imported(STEEL, choices)
    handle(np.radians(38)).data.materials.append(material)
    bpy.ops.mesh.primitive_plane_add(size=30)
    plain(bpy.context.object, (0.045, 0.042, 0.04))
    lamp(115, (-2.2, 2.2, 3.2), (0, 0, 0), 0.5)
    lamp(50, (3.2, -0.5, 2.2), (0, 0, 0), 0.6, color=(1, 0.86, 0.7))
    look((0.0, -3.3, 2.75), (0.19, 0.07, 0.12), 47)
    return scene


def satin_cloth(samples=SAMPLES, choices=STANDARD):
    """The cloth hanging in folds, its warp running across them."""
    from measured_brdf.addon.core.shading import tangents

    scene = studio(samples)
    cloth()
    tangents.take_from_uv(imported(SATIN, choices))
    lamp(185, (-2.8, -2.2, 3.4), (0, 0, 0.7), 0.5)
    lamp(26, (3.4, -1.8, 1.6), (0, 0, 0.7), 0.8, color=(1, 0.85, 0.75))
    look((0.1, -4.6, 1.75), (0.0, 0.1, 0.86), 62)
    return scene


def draw(path, samples=SAMPLES, choices=STANDARD):
    """Render both, side by side."""
    pictures = [render(scene(samples, choices)) for scene in (brushed_pan, satin_cloth)]
    sheet.write(path, [[srgb(picture[..., :3]) for picture in pictures]])


if __name__ == "__main__":
    run(draw, "anisotropic.png")
