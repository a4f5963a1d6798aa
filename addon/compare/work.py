"""The work of the background processes where two materials are compared. Nothing here imports bpy."""

from typing import NamedTuple

import numpy as np

from ...fitter import progress
from ...fitter.arrays import FloatArray
from ...fitter.quality import physics
from ..core.storage.outcomes import EmbeddedFit, KeptMix
from ..work.tasks import fit_of, kept_fit


class Figures(NamedTuple):
    """The numbers of a fit that need no measurements; albedo: (3,), for light along the normal, linear."""

    coefficients: int
    nbytes: int
    albedo: FloatArray


def figures(shown: EmbeddedFit | KeptMix) -> Figures:
    """The numbers of the fit in a material's shader, or of those of a mix. Raises ValueError if one has none."""
    progress.report(0.0, "Albedo")
    albedo = np.broadcast_to(physics.directional_albedo(fit_of(shown), [0.0])[0], 3)
    fits = [kept_fit(part) for part in {part.digest: part for part in _parts(shown)}.values()]
    return Figures(sum(fit.coefficient_count for fit in fits), sum(fit.nbytes for fit in fits), np.array(albedo))


def _parts(shown: EmbeddedFit | KeptMix) -> list[EmbeddedFit]:
    return [*_parts(shown.first), *_parts(shown.second)] if isinstance(shown, KeptMix) else [shown]
