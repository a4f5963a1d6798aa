"""The work of the background processes where two materials are compared. Nothing here imports bpy."""

from typing import NamedTuple

import numpy as np

from ...fitter import pictures, progress
from ...fitter.arrays import FloatArray, SingleArray
from ...fitter.quality import physics
from ..core.outcomes import Kept, KeptMix, Shown
from ..work.recent import Recent
from ..work.tasks import fit_of, kept_fit, lit_sphere

_spheres: Recent[str, SingleArray] = Recent(8)       # by digest


class Figures(NamedTuple):
    """The numbers of a fit that need no measurements; albedo: (3,), for light along the normal, linear."""

    coefficients: int
    nbytes: int
    albedo: FloatArray


def figures(shown: Kept | KeptMix) -> Figures:
    """The numbers of the fit in a material's shader, or of those of a mix. Raises ValueError if one has none."""
    progress.report(0.0, "Albedo")
    albedo = np.broadcast_to(physics.directional_albedo(fit_of(shown), [0.0])[0], 3)
    fits = [kept_fit(part) for part in {part.digest: part for part in _parts(shown)}.values()]
    return Figures(sum(fit.coefficient_count for fit in fits), sum(fit.nbytes for fit in fits), np.array(albedo))


def _parts(shown: Kept | KeptMix) -> list[Kept]:
    return [*_parts(shown.first), *_parts(shown.second)] if isinstance(shown, KeptMix) else [shown]


def _sphere(shown: Shown) -> SingleArray:
    """The lit sphere of a material: (size, size, 4). A mix by a mask has half of each: the picture is split already."""
    if shown.digest not in _spheres:
        evenly = shown._replace(share=0.5) if isinstance(shown, KeptMix) and shown.share is None else shown
        _spheres[shown.digest] = lit_sphere(evenly, None)
    return _spheres[shown.digest]


def split_sphere(left: Shown, right: Shown, at: float) -> SingleArray:
    """A sphere of two materials, with a line between them: (size, size, 4). Raises ValueError if one has no fit."""
    progress.report(0.0, "Drawing")
    return pictures.split(_sphere(left), _sphere(right), at)
