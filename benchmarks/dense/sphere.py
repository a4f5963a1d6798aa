"""Pictures of a sphere under the sky, by integration: of all models with the same directions and weights.

The viewer is at infinity, (0, 0, 1), y is up. Directions to the light are chosen by the sky's luminance, the cosine,
and lobes about the mirror direction (half vectors by the GGX distribution of several widths), and weighted by the
balance heuristic of E. Veach, L. J. Guibas: Optimally Combining Sampling Techniques for Monte Carlo Rendering, SIGGRAPH
1995. Their numbers are Fibonacci lattices, moved by random shifts from pixel to pixel. Noise is the same in all
pictures.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from fitter.imaging.pictures import sphere

from . import sky

SIZE = 96                   # pixels
ALPHAS = 0.004, 0.02, 0.08, 0.3        # widths of the lobes, as slopes
_FIBONACCI = {34: 21, 89: 55}           # numbers, and those before them
COUNTS = {"sky": 89, "cosine": 34, "lobe": 34}          # directions of each strategy; those of a lobe for each width
_CHUNK = 1 << 15            # pairs of directions at a time: bounds the memory
_SEED = 2021


@dataclass(frozen=True, eq=False)
class Scene:
    """All that does not depend on the material. Angles are about the pixel's normal, radians; phi_i is 0."""

    inside: np.ndarray          # (size, size) bool: where the sphere is; the bottom row first
    pixel: np.ndarray           # (n,) int: of each direction to the light, the pixel among those inside
    theta_i: np.ndarray         # (n,)
    theta_o: np.ndarray
    phi_o: np.ndarray
    weight: np.ndarray          # (n, 3): radiance cos theta_i / p, so that the picture is the sum of f times this


@cache
def scene():
    """Directions and weights for a sphere under `sky.clear`."""
    image, random = sky.clear(), np.random.default_rng(_SEED)
    normal, inside, _ = sphere(SIZE)
    parts = [(kind, alpha, COUNTS[kind]) for kind, alpha in (
        ("sky", None), ("cosine", None), *(("lobe", alpha) for alpha in ALPHAS))]
    toward = np.concatenate([_sampled(kind, alpha, normal, _numbers(count, len(normal), random), image)
                             for kind, alpha, count in parts], axis=1)
    pixel = np.broadcast_to(np.arange(len(normal))[:, None], toward.shape[:2])
    above = np.einsum("pkc,pc->pk", toward, normal) > 1e-6
    toward, pixel = toward[above], pixel[above]
    normal = normal[pixel]
    cos_i, cos_o = np.einsum("nc,nc->n", toward, normal), normal[:, 2]
    density = sum(count * _density(kind, alpha, normal, toward, image) for kind, alpha, count in parts)
    # azimuth of the viewer from that of the light, about the normal
    x, y = toward[:, 2] - cos_i * cos_o, toward[:, 1] * normal[:, 0] - toward[:, 0] * normal[:, 1]
    return Scene(inside, pixel, np.arccos(np.minimum(cos_i, 1)), np.arccos(np.minimum(cos_o, 1)), np.arctan2(y, x),
                 image.at(toward) * (cos_i / density)[:, None])


def render(model, of):
    """The picture of a material in a `Scene`: (size, size, 3) float64, 0 outside the sphere, the bottom row first."""
    value = evaluated(model, (of.theta_i, 0 * of.theta_i, of.theta_o, of.phi_o))
    value = np.maximum(value, 0) * of.weight
    picture = np.zeros((*of.inside.shape, 3))
    count = np.count_nonzero(of.inside)
    for channel in range(3):
        picture[of.inside, channel] = np.bincount(of.pixel, value[:, channel], count)
    return picture


def evaluated(model, directions):
    """A model at directions (n,), a part at a time: (n, channels), 1/sr."""
    count = len(directions[0])
    return np.concatenate([model.evaluate(*(angle[first:first + _CHUNK] for angle in directions))
                           for first in range(0, count, _CHUNK)])


def _numbers(count, pixels, random):
    """A Fibonacci lattice in the unit square, shifted for each pixel: (pixels, count, 2)."""
    k = np.arange(count)
    lattice = np.stack([(k + 0.5) / count, (k * _FIBONACCI[count] / count) % 1], axis=-1)
    return (lattice + random.random((pixels, 1, 2))) % 1


def _sampled(kind, alpha, normal, u, image):
    """Directions (pixels, count, 3) of a strategy, of numbers u (pixels, count, 2)."""
    if kind == "sky":
        return image.sampled(u.reshape(-1, 2)).reshape(*u.shape[:2], 3)
    slope2 = u[..., 0] / np.maximum(1 - u[..., 0], 1e-12) * (1 if kind == "cosine" else alpha ** 2)
    up = 1 / np.sqrt(1 + slope2)
    across, azimuth = np.sqrt(np.maximum(1 - up ** 2, 0)), 2 * np.pi * u[..., 1]
    first, second = _frame(normal)
    found = (across * np.cos(azimuth))[..., None] * first[:, None] + (
        across * np.sin(azimuth))[..., None] * second[:, None] + up[..., None] * normal[:, None]
    if kind == "cosine":
        return found
    found *= 2 * found[..., 2:]             # the viewer mirrored at the half vector
    found[..., 2] -= 1
    return found


def _density(kind, alpha, normal, toward, image):
    """With which a strategy chooses directions (n, 3) about normals (n, 3): (n,), 1/sr."""
    if kind == "sky":
        return image.density(toward)
    if kind == "cosine":
        return np.einsum("nc,nc->n", toward, normal) / np.pi
    half = toward + (0, 0, 1)
    length = np.linalg.norm(half, axis=1)
    cos_h = np.einsum("nc,nc->n", half, normal) / np.maximum(length, 1e-12)
    cos_d = length / 2
    tan2 = _tan2(half, normal)
    return (1 + tan2) ** 2 / (np.pi * alpha ** 2 * (1 + tan2 / alpha ** 2) ** 2) * cos_h / (4 * np.maximum(cos_d, 1e-9))


def _tan2(half, normal):
    """The squared tangent of the angle between vectors and normals (n, 3), exact where it is small: (n,)."""
    along = np.einsum("nc,nc->n", half, normal)
    rest = half - along[:, None] * normal
    return np.einsum("nc,nc->n", rest, rest) / np.maximum(along, 1e-9) ** 2


def _frame(normal):
    """Two unit vectors that are upright on each normal (n, 3) and on each other."""
    helper = np.where(np.abs(normal[:, 1:2]) < 0.9, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normal, first)
