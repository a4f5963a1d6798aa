"""A lamp as the shader takes it, and the same as expressions over properties of the lamp's object, for drivers.

Each of the five values of a lamp (`group.sockets`) is written once, as an expression in the notation that Python and
Blender's driver expressions share, over variables that are properties of the object: `VARIABLES` says where each is.
"""

import math
from typing import NamedTuple

POINTLIKE = 1e-6            # angular radius of a sun without a size, to be told from a lamp

# element in row i and column j of the matrix: RNA has the columns first
VARIABLES = {f"m{row}{column}": f"matrix_world[{column}][{row}]" for row in range(3) for column in range(4)}
VARIABLES |= {"energy": "data.energy", "angle": "data.angle", "radius": "data.shadow_soft_size",
              "width": "data.size", "height": "data.size_y"}

_POSITION = "m03", "m13", "m23"
_TOWARD = tuple(f"{axis} / max(sqrt(m02 * m02 + m12 * m12 + m22 * m22), 1e-30)" for axis in ("m02", "m12", "m22"))
# what Blender scales a lamp's radius with: how much longer a vector along (1, 1, 1) becomes
_SCALE = " + ".join(f"(m{row}0 + m{row}1 + m{row}2) * (m{row}0 + m{row}1 + m{row}2)" for row in range(3))
_BALL = f"radius * sqrt(({_SCALE}) / 3)"
_WIDE, _HIGH = (" + ".join(f"m{row}{column} * m{row}{column}" for row in range(3)) for column in range(2))
_DIAGONAL = f"sqrt({{0}} * {{0}} * ({_WIDE}) + {{1}} * {{1}} * ({_HIGH})) / 2"
_LONGER = f"max({{0}} * sqrt({_WIDE}), {{1}} * sqrt({_HIGH})) / 2"
_AREA = {"SQUARE": _DIAGONAL.format("width", "width"), "RECTANGLE": _DIAGONAL.format("width", "height"),
         "DISK": _LONGER.format("width", "width"), "ELLIPSE": _LONGER.format("width", "height")}


class Lamp(NamedTuple):
    """What the shader knows of a lamp.

    Attributes
    ----------
    position : (x, y, z)
        Of a sun the direction toward it.
    size : float
        Radius of a ball around what shines (m); of a sun minus its angular radius (radians).
    strength : float
        Irradiance at 1 m; of a sun its irradiance.
    """

    position: tuple
    size: float
    strength: float

    @property
    def rank(self):
        """Sorts lamps: those without a size first (nothing else finds them), then suns, then the strongest."""
        return self.size not in (0, -POINTLIKE), self.size >= 0, -self.strength, self


def expressions(light):
    """The five values of a light, as expressions over `VARIABLES`: the last of them its strength."""
    if light.type == "SUN":
        return *_TOWARD, f"-max(angle / 2, {POINTLIKE:f})", "energy"
    if light.type == "AREA":
        return *_POSITION, _AREA[light.shape], f"energy / {math.pi!r}"
    return *_POSITION, _BALL, f"energy / {4 * math.pi!r}"


def of(light, matrix):
    """The lamp that a light is where this matrix puts it."""
    if light.type == "SUN":
        x, y, z = (matrix[row][2] for row in range(3))
        length = max(math.sqrt(x * x + y * y + z * z), 1e-30)
        return Lamp((x / length, y / length, z / length), -max(light.angle / 2, POINTLIKE), light.energy)
    position = tuple(matrix.translation)
    if light.type == "AREA":
        sides = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        halves = [side * abs(scale) / 2 for side, scale in zip(sides, matrix.to_scale().xy, strict=True)]
        size = max(halves) if light.shape in {"DISK", "ELLIPSE"} else math.hypot(*halves)
        return Lamp(position, size, light.energy / math.pi)
    return Lamp(position, light.shadow_soft_size * matrix.median_scale, light.energy / (4 * math.pi))


def value(name, item):
    """The value of a variable for an evaluated object."""
    if name.startswith("m"):
        return item.matrix_world[int(name[1])][int(name[2])]
    return getattr(item.data, VARIABLES[name].partition(".")[2])
