"""A lamp as the shader takes it: as numbers, and as driver expressions over `VARIABLES`, which are properties of the
lamp's object."""

import math
from typing import NamedTuple

import bpy
from mathutils import Matrix

from ..annotations import Vector3

POINTLIKE = 1e-6            # angular radius of a sun without a size: tells its size, a negative number, from a lamp's 0

# m12 is row 1, column 2 of the matrix: RNA has the columns first
VARIABLES = {f"m{row}{column}": f"matrix_world[{column}][{row}]" for row in range(3) for column in range(4)}
VARIABLES |= {name: name for name in ("hide_viewport", "hide_render")}
VARIABLES |= {"energy": "data.energy", "exposure": "data.exposure", "angle": "data.angle",
              "radius": "data.shadow_soft_size", "width": "data.size", "height": "data.size_y"}

VISIBILITY = "(1 - hide_viewport * hide_render)"   # expression: 0 where a lamp is in no picture
_POSITION = "m03", "m13", "m23"
_LENGTH = "max(sqrt(m02 * m02 + m12 * m12 + m22 * m22), 1e-30)"
_TOWARD = f"m02 / {_LENGTH}", f"m12 / {_LENGTH}", f"m22 / {_LENGTH}"
# Blender scales a lamp's radius by the factor by which a vector along (1, 1, 1) is stretched
_SCALE_SQUARED = " + ".join(f"(m{row}0 + m{row}1 + m{row}2) * (m{row}0 + m{row}1 + m{row}2)" for row in range(3))
_BALL = f"radius * sqrt(({_SCALE_SQUARED}) / 3)"
_WIDE, _HIGH = (" + ".join(f"m{row}{column} * m{row}{column}" for row in range(3)) for column in range(2))
_DIAGONAL = f"sqrt({{0}} * {{0}} * ({_WIDE}) + {{1}} * {{1}} * ({_HIGH})) / 2"
_LONGER = f"max({{0}} * sqrt({_WIDE}), {{1}} * sqrt({_HIGH})) / 2"
_AREA = {"SQUARE": _DIAGONAL.format("width", "width"), "RECTANGLE": _DIAGONAL.format("width", "height"),
         "DISK": _LONGER.format("width", "width"), "ELLIPSE": _LONGER.format("width", "height")}


class Lamp(NamedTuple):
    """What the shader knows of a lamp."""

    position: Vector3       # of a sun the direction toward it
    size: float             # radius of a ball around it, m; of a sun its angular radius, radians, with a minus sign
    strength: float         # irradiance, at 1 m; or that of a sun
    core: float = 1.0       # radius of a disk of the lamp's area, in that of the ball

    @property
    def rank(self) -> tuple[bool, bool, float, "Lamp"]:
        """Sort key: lamps without a size, which no sampled direction can hit, then suns, then the strongest."""
        return self.size not in (0, -POINTLIKE), self.size >= 0, -self.strength, self


def expressions(light: bpy.types.Light) -> tuple[str, str, str, str, str]:
    """The values of a light but for its core, as expressions over `VARIABLES`; the last is its strength."""
    energy = "energy * pow(2, exposure)" if hasattr(light, "exposure") else "energy"     # older Blenders have none
    if light.type == "SUN":
        return *_TOWARD, f"-max(angle / 2, {POINTLIKE:f})", energy
    if light.type == "AREA":
        return *_POSITION, _AREA[light.shape], f"{energy} / {math.pi!r}"
    return *_POSITION, _BALL, f"{energy} / {4 * math.pi!r}"


def from_light(light: bpy.types.Light, matrix: Matrix) -> Lamp:
    energy = light.energy * 2 ** getattr(light, "exposure", 0.0)
    if light.type == "SUN":
        x, y, z = (matrix[row][2] for row in range(3))
        length = max(math.sqrt(x * x + y * y + z * z), 1e-30)
        return Lamp((x / length, y / length, z / length), -max(light.angle / 2, POINTLIKE), energy)
    x, y, z = matrix.translation
    position = x, y, z
    if light.type == "AREA":
        sides = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        halves = [side * abs(scale) / 2 for side, scale in zip(sides, matrix.to_scale()[:2], strict=True)]
        is_round = light.shape in {"DISK", "ELLIPSE"}
        size = max(halves) if is_round else math.hypot(*halves)
        area = math.prod(halves) * (math.pi if is_round else 4)
        return Lamp(position, size, energy / math.pi, math.sqrt(area / math.pi) / max(size, 1e-30))
    return Lamp(position, light.shadow_soft_size * matrix.median_scale, energy / (4 * math.pi))
