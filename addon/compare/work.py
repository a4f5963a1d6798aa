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
from ..work.tasks import Kept, kept_fit, silent

_spheres: Recent[tuple[str, int], SingleArray] = Recent(8)       # by digest and size


class Figures(NamedTuple):
    """The numbers of a fit that need no measurements; albedo: (3,), for light along the normal, linear."""

    coefficients: int
    nbytes: int
    albedo: FloatArray


def nothing(_report: Report = silent) -> None:
    """The work where all has been done before."""


def figures(kept: Kept, report: Report = silent) -> Figures:
    """The numbers of the fit in a material's shader. Raises ValueError if there is none."""
    report(0.0, "Albedo")
    fit = kept_fit(kept)
    albedo = np.broadcast_to(physics.directional_albedo(fit, [0.0])[0], 3)
    return Figures(fit.coefficient_count, fit.nbytes, np.array(albedo))


def sphere(kept: Kept, size: int, report: Report = silent) -> SingleArray:
    """The lit sphere of the fit in a material's shader: (size, size, 4). Raises ValueError if there is none."""
    report(0.0, "Drawing")
    key = kept.digest, size
    if key not in _spheres:
        _spheres[key] = pictures.lit_sphere(kept_fit(kept), size, colours=kept.colours, with_tangent=True)
    return _spheres[key]


def split_sphere(left: Kept, right: Kept, at: float, size: int, report: Report = silent) -> SingleArray:
    """A sphere of two materials, with a line between them: (size, size, 4). Raises as `sphere` does."""
    return pictures.split(sphere(left, size, report), sphere(right, size, report), at)


def polar(first: Kept, second: Kept | None, theta_i: float, size: int,
          report: Report = silent) -> SingleArray:
    """The polar plot of one material, or of two: (size, size, 4). Raises as `sphere` does."""
    report(0.0, "Drawing")
    if second is None:
        return pictures.polar_plot(kept_fit(first), None, theta_i, size)[0]
    return pictures.polar_comparison(kept_fit(first), kept_fit(second), theta_i, size,
                                     colours=(first.colours, second.colours))
