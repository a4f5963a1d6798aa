"""The bi-level fit: a coarse dense diffuse lattice and a fine sparse specular one.

Kameya and Lewis 2002, section 4: f = f_d + f_s, where f_d is fitted first and f_s to what f_d leaves. Of the
(2^S + 3)^3 control points of f_s only the largest are kept, one set of them for all channels.
"""

from dataclasses import dataclass
from numbers import Real

import numpy as np

from . import fit_file, lattice, mba, sparse_lattice
from .nusselt import nusselt


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted reflectance.

    Attributes
    ----------
    diffuse_level : int
    diffuse : lattice.shape(diffuse_level) + (channels,) float32
        f_d, dense.
    specular : sparse_lattice.SparseLattice, or None
        f_s; None for plain MBA.
    compression : float
        Percentage of the specular lattice that was dropped; 0 for plain MBA.
    channels : tuple of str
    name, source : str
        As in the `Samples` it was fitted to.
    """

    diffuse_level: int
    diffuse: np.ndarray
    specular: sparse_lattice.SparseLattice | None = None
    compression: float = 0.0
    channels: tuple = ("grey",)
    name: str = "untitled"
    source: str = ""

    @property
    def specular_level(self):
        """S, or None for plain MBA."""
        return None if self.specular is None else self.specular.level

    @property
    def coefficient_count(self):
        """Control points stored, dense and sparse, counted once whatever the number of channels."""
        return self.diffuse[..., 0].size + (0 if self.specular is None else len(self.specular))

    @property
    def nbytes(self):
        """Bytes that must be stored to evaluate, over all channels: coefficients, keys and hash table."""
        return self.diffuse.nbytes + (0 if self.specular is None else self.specular.nbytes)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The fitted BRDF, negative where the fit undershoots.

        Parameters
        ----------
        theta_i, phi_i, theta_o, phi_o : (n,) array_like
            Directions, radians; they may be broadcast.

        Returns
        -------
        (n, channels) float64
            1/sr.
        """
        coordinates = nusselt(theta_i, phi_i, theta_o, phi_o)
        if not np.isfinite(coordinates).all():
            raise ValueError("directions that are not finite numbers")
        values = self.evaluate_nusselt(coordinates.reshape(-1, 3))
        return values.reshape(*coordinates.shape[:-1], values.shape[1])

    def evaluate_nusselt(self, x):
        """The fitted BRDF at Nusselt coordinates with kappa_i and lambda_o of at least 1/2: (n, 3) to (n, channels)."""
        value = lattice.evaluate(self.diffuse, self.diffuse_level, x)
        if self.specular is not None:
            value += lattice.evaluate(self.specular.dense, self.specular.level, x)
        return value

    def save(self, path):
        """Write the fit to an .npz file; what was there is replaced only once the new file is whole."""
        fit_file.write(self, path)

    @staticmethod
    def load(path):
        """Read a fit that `save` wrote; `DatasetError` if the file is anything else."""
        return Fit(**fit_file.read(path))


def fit(samples, diffuse_level=4, specular_level=6, compression=95.0):
    """Fit a measured reflectance as Kameya and Lewis (2002) do.

    Parameters
    ----------
    samples : Samples
    diffuse_level : int, 0 to 8
        D, the level of the dense lattice.
    specular_level : int, 0 to 8, or None
        S, the level of the sparse lattice; None for plain MBA at `diffuse_level` (section 3).
    compression : float, 0 to 100
        C, the percentage of the (2^S + 3)^3 specular control points to drop.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a level or the compression is out of range.
    """
    diffuse_level = _level("diffuse_level", diffuse_level)
    x = nusselt(*samples.directions)
    diffuse, residual = mba.approximate(x, samples.values, diffuse_level)
    named = {"channels": samples.channels, "name": samples.name, "source": samples.source}
    if specular_level is None:
        return Fit(diffuse_level, diffuse.astype(np.float32), **named)

    specular_level = _level("specular_level", specular_level)
    if not isinstance(compression, Real) or not 0 <= compression <= 100:
        raise ValueError(f"compression is {compression!r}, expected a percentage from 0 to 100")
    kept = round((1 - compression / 100) * lattice.full_size(specular_level))
    specular, _ = mba.approximate(x, residual, specular_level)
    return Fit(diffuse_level, diffuse.astype(np.float32),
               sparse_lattice.keep_largest(specular, specular_level, kept), float(compression), **named)


def notation(diffuse_level, specular_level=None, compression=0.0):
    """The levels of a fit as the paper writes them: ``(D,S,C)``, or ``level D`` for plain MBA."""
    return f"level {diffuse_level}" if specular_level is None else (
        f"({diffuse_level},{specular_level},{compression:g})")


def _level(name, level):
    if isinstance(level, bool) or not isinstance(level, int | np.integer) or not 0 <= level <= lattice.MAX_LEVEL:
        raise ValueError(f"{name} is {level!r}, expected a whole number from 0 to {lattice.MAX_LEVEL}")
    return int(level)
