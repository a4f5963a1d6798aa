"""A car's body for the title picture: sections along its length, cut by wheel arches, with a window and wheels."""

import bpy
import numpy as np

_LENGTH, _WIDTH, _SILL = 3.0, 0.62, 0.16        # along x; half of it along y; the lower edge's height
# along the length, from the front (-1) to the rear (1): height of the roof line and of the shoulder, and relative width
_STATIONS = np.array([(-1.0, 0.40, 0.36, 0.62), (-0.96, 0.47, 0.42, 0.80), (-0.85, 0.53, 0.48, 0.92),
                      (-0.60, 0.60, 0.53, 0.99), (-0.36, 0.66, 0.56, 1.0), (-0.24, 0.78, 0.57, 1.0),
                      (-0.06, 0.93, 0.58, 1.0), (0.14, 0.98, 0.59, 1.0), (0.40, 0.94, 0.60, 1.0),
                      (0.66, 0.80, 0.61, 0.99), (0.84, 0.67, 0.60, 0.94), (0.96, 0.58, 0.54, 0.82),
                      (1.0, 0.48, 0.46, 0.66)])
_PILLAR = 0.09              # between the windows, along the length
_AXLES, _WHEEL, _ARCH = (-0.92, 0.93), 0.27, 0.31   # x of the wheels, their radius, and that of the arches
_SPOKES = 7
_GLASS = 0.12               # of the height above the shoulder: where the window begins


def car_body(of):
    """Make the body: paint is the material "irid", the wheels are "rims", the window "glass"."""
    at, x = (-0.2, 0.6, 0.0), np.linspace(-1, 1, 241)
    roof, shoulder, width = (_smooth(x, _STATIONS[:, column]) for column in (1, 2, 3))
    around = np.linspace(0, 1, 81)
    section = [_section(around, *each) for each in zip(roof, shoulder, width, strict=True)]
    points = [(_LENGTH / 2 * place, y, z) for place, each in zip(x, section, strict=True) for y, z in each]
    rows, columns = len(x), len(section[0])
    faces = [(row * columns + c, row * columns + (c + 1) % columns, (row + 1) * columns + (c + 1) % columns,
              (row + 1) * columns + c) for row in range(rows - 1) for c in range(columns)]
    faces += [tuple(range(columns))[::-1], tuple((rows - 1) * columns + c for c in range(columns))]
    mesh = bpy.data.meshes.new("Body")
    mesh.from_pydata(points, [], faces)
    mesh.materials.append(of("irid"))
    mesh.materials.append(of("glass"))
    heights = np.array([[points[each][2] for each in face] for face in faces[:-2]]).mean(axis=1)
    for polygon, height in zip(mesh.polygons, [*heights, 0, 0], strict=True):
        place = int(polygon.index // columns) if polygon.index < len(heights) else 0
        above = roof[place] - shoulder[place]
        polygon.use_smooth = True
        polygon.material_index = int(above > 0.15 and shoulder[place] + _GLASS * above < height
                                     < roof[place] - 0.16 * above and abs(x[place] - _PILLAR) > 0.012)
    body = bpy.data.objects.new("Body", mesh)
    body.location = at
    bpy.context.scene.collection.objects.link(body)
    for axle in _AXLES:
        _arch(body, (at[0] + axle, at[1], _WHEEL))
        for side in (-1, 1):
            _wheel(of, (at[0] + axle, at[1] + side * (_WIDTH - 0.1), _WHEEL))


def _smooth(x, values):
    """Between stations by cubic Hermite polynomials, with the slopes of a parabola through three of them."""
    places = _STATIONS[:, 0]
    slope = np.gradient(values, places)
    k = np.clip(np.searchsorted(places, x) - 1, 0, len(places) - 2)
    step = places[k + 1] - places[k]
    t = (x - places[k]) / step
    return ((1 + 2 * t) * (1 - t) ** 2 * values[k] + t * (1 - t) ** 2 * step * slope[k]
            + t ** 2 * (3 - 2 * t) * values[k + 1] + t ** 2 * (t - 1) * step * slope[k + 1])


def _section(around, roof, shoulder, width):
    """A section from the sill over the shoulder, where it has an edge, to the roof and down again: (y, z)."""
    side, top = around[around < 0.45] / 0.45, (around[around >= 0.45] - 0.45) / 0.55
    half = _WIDTH * width
    y = np.concatenate([half * (0.94 + 0.06 * np.sin(np.pi * 0.62 * side)),
                        0.985 * half * (1 - 0.3 * top ** 1.2) * np.sqrt(np.maximum(1 - top ** 5, 0))])
    z = np.concatenate([_SILL + (shoulder - _SILL) * side,
                        shoulder + (roof - shoulder) * np.sin(np.pi / 2 * np.minimum(top * 1.05, 1)) ** 1.1])
    return [*zip(-y, z, strict=True), *zip(y[-2::-1], z[-2::-1], strict=True)]


def _arch(body, at):
    bpy.ops.mesh.primitive_cylinder_add(vertices=64, radius=_ARCH, depth=3, location=at, rotation=(np.pi / 2, 0, 0))
    cutter = bpy.context.object
    cutter.hide_render = True
    cut = body.modifiers.new("Arch", "BOOLEAN")
    cut.operation, cut.object, cut.solver = "DIFFERENCE", cutter, "EXACT"


def _wheel(of, at):
    bpy.ops.mesh.primitive_torus_add(major_radius=_WHEEL - 0.06, minor_radius=0.07, location=at,
                                     rotation=(np.pi / 2, 0, 0), major_segments=64, minor_segments=24)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(of("glass"))
    bpy.ops.mesh.primitive_torus_add(major_radius=_WHEEL - 0.11, minor_radius=0.025, location=at,
                                     rotation=(np.pi / 2, 0, 0), major_segments=64, minor_segments=24)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(of("rims"))
    for turn in np.arange(_SPOKES) * 2 * np.pi / _SPOKES:
        bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.022, depth=_WHEEL - 0.11, location=(
            at[0] + (_WHEEL - 0.11) / 2 * np.sin(turn), at[1], at[2] + (_WHEEL - 0.11) / 2 * np.cos(turn)),
            rotation=(0, turn, 0))
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(of("rims"))
