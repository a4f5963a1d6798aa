"""Tables of anisotropic materials, as a user would write them: synthetic, from an analytic truth.

`demo_scenes.anisotropic` renders two, and tests import them as users do.
"""

import numpy as np

from .anisotropic import ggx, rotations, vectors
from .truths import Truth

NOISE = 0.005               # relative standard deviation of a measurement


def _steel(*directions):
    """Ground along the tangent: a highlight is narrow along the grooves, and wide across them."""
    wi, wo = vectors(*directions)
    color = np.array([0.63, 0.61, 0.58])
    fresnel = color + (1 - color) * ((1 - np.minimum(np.linalg.norm(wi + wo, axis=1) / 2, 1)) ** 5)[:, None]
    return 0.012 + fresnel * ggx(wi, wo, 0.09, 0.42)[:, None]


def _satin(*directions):
    """Warp threads along the tangent, that float over the weft: each thread shines on a cone about its direction, as
    the fibres of J. Kajiya and T. Kay (1989), but reciprocal. Dye colours what goes through them, below."""
    wi, wo = vectors(*directions)
    total = np.tile([0.018, 0.0015, 0.003], (len(wi), 1))
    heights = wi[:, 2] + wo[:, 2] + 0.1
    for (x, y), slope, width, color in (((1, 0), np.radians(3), 0.125, [0.42, 0.11, 0.135]),
                                        ((0, 1), np.radians(20), 0.3, [0.04, 0.003, 0.007])):
        for side in (-slope, slope):
            thread = np.array([x * np.cos(side), y * np.cos(side), np.sin(side)])
            total += np.exp(-((wi + wo) @ thread / width) ** 2)[:, None] / heights[:, None] * color
    return total


STEEL = Truth("brushed steel", "brushed metal", _steel, NOISE)
SATIN = Truth("satin", "satin", _satin, NOISE)


def write(path, truth, count=24, turn=2 * np.pi, comments=(), seed=0, directions=None):
    """Write a table of what an instrument measures of a truth at several rotations, with noise. Returns its path.

    Parameters
    ----------
    path : Path
    truth : truths.Truth
    count, turn : int, float
        Rotations, and the angle that they divide, as `anisotropic.rotations` takes them.
    comments : sequence of str
        Lines before the names, as ``symmetry: 180 degrees``.
    seed : int
        Of the noise.
    directions : four (n,), optional
        Instead of those of `rotations`, radians.
    """
    directions = rotations(count, turn) if directions is None else directions
    values = truth.evaluate(*directions)
    values = values * (1 + truth.noise * np.random.default_rng(seed).standard_normal(values.shape))
    rows = np.column_stack([*np.degrees(directions), np.maximum(values, 0)])
    lines = [f"# name: {truth.name} (synthetic)", "# angles: degrees", *(f"# {comment}" for comment in comments),
             "theta_i, phi_i, theta_o, phi_o, R, G, B"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines + [",".join(f"{number:.6g}" for number in row) for row in rows]) + "\n")
    return path


def few(count=6):
    """Few pairs of directions at several rotations, for tests: four (n,), radians."""
    grid = np.meshgrid(np.arange(count) / count * 2 * np.pi, np.radians([0, 30, 60]), np.radians([0, 25, 50, 75]),
                       np.radians(np.arange(0, 360, 45)), indexing="ij")
    phi_i, theta_i, theta_o, turns = (axis.ravel() for axis in grid)
    return theta_i, phi_i, theta_o, phi_i + turns
