"""The lobe of a reflectance: the surface whose distance from the origin tells the value in each outgoing direction. Its
vertices are closest about the mirror direction and, less so, about the incident one, so that highlights a fraction of a
degree wide are met. Their number, and the faces, do not depend on the direction."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from ..arrays import FloatArray, IntArray, unit_vectors
from ..model import Reflectance

Radius = Literal["cube root", "linear"]
RADII: dict[Radius, np.ufunc] = {"cube root": np.cbrt, "linear": np.positive}

_FINEST_ANGLE = np.radians(0.05)  # about half of the spacing next to the mirror direction
_ON_ONE_SIDE = 120          # directions of the curve in the plane of incidence
_EVEN_SHARE = 0.5               # share of the vertices that are spread evenly


@dataclass(frozen=True, eq=False)
class Lobe:
    """A lobe as a mesh in the frame of the surface: x is the tangent, z the normal."""

    vertices: FloatArray        # (n, 3): directions times radii, first that of the normal, the last row on the horizon
    normals: FloatArray         # (n, 3): of the mesh, outward, of length 1
    faces: IntArray             # (m, 3): triangles, counter-clockwise from outside
    values: FloatArray          # (n, channels), 1/sr
    directions: FloatArray      # (n, 3): unit vectors


def lobe_surface(model: Reflectance, theta_i: float, phi_i: float = 0.0, rows: int = 64, columns: int = 128,
                 radius: Radius = "cube root") -> Lobe:
    """The lobe for one direction of incidence, radians: ``1 + rows * columns`` vertices, of columns a multiple of 4.
    The radius is what a vertex's distance from the origin is of its value: the mean of the channels, not below 0."""
    theta = _positions_denser_near(theta_i, np.pi / 2, rows)
    # a step in azimuth is short near the normal
    quarter = _growing(np.pi / 2, columns // 4, min(_FINEST_ANGLE / max(np.sin(theta_i), 1e-9), np.pi))
    half = np.concatenate([quarter, np.pi - quarter[-2::-1]])
    phi = phi_i + np.pi + np.concatenate([half, half[1:-1] + np.pi])

    rest_theta, rest_phi = (axis.ravel() for axis in np.meshgrid(theta[1:], phi, indexing="ij"))
    theta_o, phi_o = np.append(0.0, rest_theta), np.append(phi_i, rest_phi)
    values = model.evaluate(np.full(len(theta_o), theta_i), np.full(len(theta_o), phi_i), theta_o, phi_o)
    directions = unit_vectors(theta_o, phi_o)
    vertices = RADII[radius](np.maximum(values.mean(axis=1), 0))[:, None] * directions
    return Lobe(vertices, _normals(vertices, directions, rows, columns), _faces(rows, columns), values, directions)


def plane_curve(model: Reflectance, theta_i: float, phi_i: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Outgoing angles in the plane of incidence from -pi/2, grazing on the light's side, to pi/2, radians, (k,), the
    mirror direction among them; and the values there, (k, channels), 1/sr."""
    side = _positions_denser_near(theta_i, np.pi / 2, _ON_ONE_SIDE)
    theta = np.concatenate([-side[:0:-1], side])
    return theta, evaluate_in_plane(model, theta_i, phi_i, theta)


def evaluate_in_plane(model: Reflectance, theta_i: float, phi_i: float, theta: FloatArray) -> FloatArray:
    """The values at angles in the plane of incidence, negative on the light's side: (k,) to (k, channels)."""
    return model.evaluate(np.full(len(theta), theta_i), np.full(len(theta), phi_i), np.abs(theta),
                          phi_i + np.where(theta < 0, 0, np.pi))


def _positions_denser_near(center: float, end: float, count: int) -> FloatArray:
    """Positions from 0 to end, (count + 1,), closer together near a center, which is among them."""
    fine_below, fine_above = np.arcsinh(np.array([center, end - center]) / _FINEST_ANGLE)
    share = _EVEN_SHARE * center / end + (1 - _EVEN_SHARE) * fine_below / (fine_below + fine_above)
    below = int(np.clip(round(count * share), center > 0, count - 1))
    return np.concatenate([center - _growing(center, below, _FINEST_ANGLE)[::-1],
                           center + _growing(end - center, count - below, _FINEST_ANGLE)[1:]])


def _growing(length: float, count: int, finest: float) -> FloatArray:
    """Positions from 0 to length, (count + 1,): half of them even, half in steps that grow from 0 on."""
    if length <= 0:
        return np.zeros(count + 1)
    fine = finest * np.sinh(np.linspace(0, np.arcsinh(length / finest), 2000))
    order = _EVEN_SHARE * fine / length + (1 - _EVEN_SHARE) * np.linspace(0, 1, 2000)
    positions = np.interp(np.linspace(0, 1, count + 1), order, fine)
    positions[-1] = length
    return positions


@lru_cache(maxsize=8)
def _faces(rows: int, columns: int) -> IntArray:
    first, second = np.arange(columns), np.roll(np.arange(columns), -1)
    fan = np.stack([np.zeros(columns, dtype=int), 1 + first, 1 + second], axis=-1)
    start = 1 + columns * np.arange(rows - 1)[:, None]
    a, b = start + first, start + second
    strips = np.stack([a, a + columns, b, b, a + columns, b + columns], axis=-1).reshape(-1, 3)
    faces = np.concatenate([fan, strips]).astype(np.int32)
    faces.flags.writeable = False
    return faces


def _normals(vertices: FloatArray, directions: FloatArray, rows: int, columns: int) -> FloatArray:
    """Normals by differences between neighbours; where the mesh has no area, the directions."""
    grid = np.concatenate([np.broadcast_to(vertices[0], (1, columns, 3)), vertices[1:].reshape(rows, columns, 3)])
    along = np.gradient(grid, axis=0)[1:]
    around = np.roll(grid[1:], -1, axis=1) - np.roll(grid[1:], 1, axis=1)
    normals = np.cross(along, around)
    all_normals = np.concatenate([normals[:1].sum(axis=1), normals.reshape(-1, 3)])
    length = np.linalg.norm(all_normals, axis=1, keepdims=True)
    return np.where(length > 1e-15 * np.abs(vertices).max() ** 2, all_normals / np.maximum(length, 1e-300), directions)
