"""The work of the background processes where two materials are compared. Nothing here imports bpy.

Functions take `report(fraction, doing)`, as in `tasks`.
"""

from typing import NamedTuple

import numpy as np

from ...fitter import pictures
from ...fitter.arrays import FloatArray, SingleArray
from ...fitter.quality import physics
from ..core.annotations import Report
from ..work.recent import Recent
from ..work.tasks import Kept, kept_fit, lit_sphere, silent

_spheres: Recent[str, SingleArray] = Recent(8)       # by digest


class Figures(NamedTuple):
    """The numbers of a fit that need no measurements; albedo: (3,), for light along the normal, linear."""

    coefficients: int
    nbytes: int
    albedo: FloatArray


def figures(kept: Kept, report: Report = silent) -> Figures:
    """The numbers of the fit in a material's shader. Raises ValueError if there is none."""
    report(0.0, "Albedo")
    fit = kept_fit(kept)
    albedo = np.broadcast_to(physics.directional_albedo(fit, [0.0])[0], 3)
    return Figures(fit.coefficient_count, fit.nbytes, np.array(albedo))


def _sphere(kept: Kept) -> SingleArray:
    """The lit sphere of the fit in a material's shader: (size, size, 4)."""
    if kept.digest not in _spheres:
        _spheres[kept.digest] = lit_sphere(kept, None)
    return _spheres[kept.digest]


def split_sphere(left: Kept, right: Kept, at: float, report: Report = silent) -> SingleArray:
    """A sphere of two materials, with a line between them: (size, size, 4). Raises ValueError if one has no fit."""
    report(0.0, "Drawing")
    return pictures.split(_sphere(left), _sphere(right), at)


def polar(first: Kept, second: Kept, theta_i: float, report: Report = silent) -> SingleArray:
    """The polar plot of two materials: (size, size, 4). Raises as `split_sphere` does."""
    report(0.0, "Drawing")
    return pictures.polar_comparison(kept_fit(first), kept_fit(second), theta_i,
                                     colours=(first.colours, second.colours))
