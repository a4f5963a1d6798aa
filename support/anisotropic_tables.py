"""Tables of anisotropic materials, as a user would write them: synthetic, from an analytic truth.

`demo_scenes.anisotropic` renders two, and tests import them as users do.
"""

import numpy as np

from .anisotropic import brushed, rotations, woven
from .anisotropic_instruments import grid
from .truths import Truth

NOISE = 0.005               # relative standard deviation of a measurement


# ground along the tangent: a highlight is narrow along the grooves, and wide across them
STEEL = Truth("brushed steel", "brushed metal", brushed(3 * [0.012], [0.63, 0.61, 0.58], 0.09, 0.42, 0.0), NOISE)
# warp threads along the tangent, that float over the weft
SATIN = Truth("satin", "satin", woven(([0.42, 0.11, 0.135], 0.0, np.radians(3), 0.125),
                                      ([0.04, 0.003, 0.007], np.pi / 2, np.radians(20), 0.3),
                                      ground=[0.018, 0.0015, 0.003]), NOISE)


def write(path, truth, count=24, turn=2 * np.pi, directions=None):
    """Write a table of what an instrument measures of a truth, with noise: its path.

    Directions are four (n,), radians, by default those of `anisotropic.rotations`, which divide an angle by a count.
    """
    directions = rotations(count, turn) if directions is None else directions
    values = truth.evaluate(*directions)
    values = values * (1 + truth.noise * np.random.default_rng(0).standard_normal(values.shape))
    rows = np.column_stack([*np.degrees(directions), np.maximum(values, 0)])
    lines = [f"# name: {truth.name} (synthetic)", "# angles: degrees",
             "theta_i, phi_i, theta_o, phi_o, R, G, B"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines + [",".join(f"{number:.6g}" for number in row) for row in rows]) + "\n")
    return path


def few(count=6):
    """Few pairs of directions at several rotations, for tests: four (n,), radians."""
    return grid((0, 30, 60), np.arange(count) * 360 / count, (0, 25, 50, 75), range(0, 360, 45))
