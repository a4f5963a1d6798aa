"""The paper's method: the reflectance itself on two lattices over Nusselt coordinates, by multilevel B-splines (Kameya
and Lewis 2002, sections 3 and 4). Anisotropic samples are fitted over four coordinates in the same way, as the paper
proposes for future work."""

import numpy as np

from .. import progress
from ..coordinates.anisotropic_nusselt import AnisotropicNusselt
from ..coordinates.nusselt import Nusselt
from ..lattice import mba, sparse
from ..lattice.dense import DenseLattice
from ..model.fit import Fit
from ..samples import Samples
from .levels import Levels


def fit(samples: Samples, levels: Levels, plausible: bool = True) -> Fit:
    """Fit samples by multilevel B-spline approximation. It cannot ensure that a fit is plausible."""
    if not samples.isotropic:
        levels.check_four_axes()
    coordinates = Nusselt() if samples.isotropic else AnisotropicNusselt()
    x = coordinates.encode(*samples.directions)
    with progress.part(0.0, 0.2, "Fitting the dense lattice"):
        control_points, residual = mba.approximate(x, samples.values, levels.diffuse)
    diffuse, specular = DenseLattice(levels.diffuse, control_points.astype(np.float32)), None
    if levels.specular is not None:
        with progress.part(0.2, 1.0, "Fitting the sparse lattice"):
            control_points, _ = mba.approximate(x, residual, levels.specular)
            specular = sparse.keep_largest(control_points, levels.specular, levels.kept_count(x.shape[1]))
    return Fit(coordinates, diffuse, specular, compression=levels.effective_compression, channels=samples.channels,
               name=samples.name, source=samples.source)
