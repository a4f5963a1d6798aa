"""The bi-level fit: a coarse dense diffuse lattice and a fine sparse specular one.

Kameya and Lewis 2002, section 4: f = f_d + f_s, where f_d is fitted first and f_s to what f_d leaves. Of the
(2^S + 3)^3 control points of f_s only some are kept, one set of them for all channels. By method "mba" the lattices
hold the reflectance in Nusselt coordinates, as the paper has it; by method "kriging" the field of `regression_kriging`.
"""

from dataclasses import dataclass, replace
from functools import partial
from numbers import Real

import numpy as np

from ..coordinates.half_difference import half_difference
from ..coordinates.nusselt import nusselt
from ..lattice import dense, mba, sparse
from ..model import fit_file
from . import regression_kriging
from .prior import Prior

METHODS = ("mba", "kriging")
_CHUNK = 1 << 16            # directions evaluated at a time


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted reflectance.

    Attributes
    ----------
    diffuse_level : int
    diffuse : lattice.shape(diffuse_level) + (columns,) float32
        The dense lattice.
    specular : sparse_lattice.SparseLattice, or None
        The sparse lattice; None for the dense one alone.
    compression : float
        Percentage of the specular lattice that was dropped; 0 without one.
    channels : tuple of str
    columns : tuple of int
        Which column of the arrays each channel reads: equal channels are stored once. By default each its own.
    prior : estimate.Prior, or None
        What makes a reflectance of the lattices' field, by method "kriging"; None by method "mba".
    softening : float
        The softening radius of `half_difference`, by method "kriging"; 0 in fits of versions that had none.
    changes : tuple of str
        What was changed to make the fit physically plausible, in words.
    name, source : str
        As in the `Samples` it was fitted to.
    """

    diffuse_level: int
    diffuse: np.ndarray
    specular: sparse.SparseLattice | None = None
    compression: float = 0.0
    channels: tuple = ("grey",)
    columns: tuple | None = None
    prior: Prior | None = None
    softening: float = 0.0
    changes: tuple = ()
    name: str = "untitled"
    source: str = ""

    def __post_init__(self):
        if self.columns is None:
            object.__setattr__(self, "columns", tuple(range(len(self.channels))))

    @property
    def method(self):
        """One of `METHODS`."""
        return "mba" if self.prior is None else "kriging"

    @property
    def specular_level(self):
        """S, or None without a sparse lattice."""
        return None if self.specular is None else self.specular.level

    @property
    def coefficient_count(self):
        """Control points stored, dense and sparse, counted once whatever the number of channels."""
        return self.diffuse[..., 0].size + (0 if self.specular is None else len(self.specular))

    @property
    def nbytes(self):
        """Bytes that must be stored to evaluate, over all channels: coefficients, keys, hash table and prior."""
        return self.diffuse.nbytes + sum(part.nbytes for part in (self.specular, self.prior) if part is not None)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The fitted BRDF, negative where a fit that need not be plausible undershoots.

        Parameters
        ----------
        theta_i, phi_i, theta_o, phi_o : (n,) array_like
            Directions, radians; they may be broadcast.

        Returns
        -------
        (n, channels) float64
            1/sr.
        """
        angles = np.broadcast_arrays(*(np.asarray(angle, dtype=float) for angle in (theta_i, phi_i, theta_o, phi_o)))
        directions = [angle.ravel() for angle in angles]
        if not all(np.isfinite(angle).all() for angle in directions):
            raise ValueError("directions that are not finite numbers")
        values = np.empty((angles[0].size, len(self.columns)))
        for start in range(0, len(values), _CHUNK):
            part = slice(start, start + _CHUNK)
            values[part] = self._stored_columns(*(angle[part] for angle in directions))[:, self.columns]
        return values.reshape(*angles[0].shape, len(self.columns))

    def _stored_columns(self, *directions):
        x = nusselt(*directions) if self.prior is None else half_difference(*directions, self.softening)
        values = dense.evaluate(self.diffuse, self.diffuse_level, x)
        if self.specular is not None:
            values += dense.evaluate(self.specular.dense, self.specular.level, x)
        return values if self.prior is None else self.prior.reflectance(values, *directions)

    def save(self, path):
        """Write the fit to an .npz file; what was there is replaced only once the new file is whole."""
        fit_file.write(self, path)

    @staticmethod
    def load(path):
        """Read a fit that `save` wrote; `DatasetError` if the file is anything else."""
        return Fit(**fit_file.read(path))


def fit(samples, diffuse_level=4, specular_level=6, compression=95.0, method="mba", plausible=True, estimated=None):
    """Fit a measured reflectance.

    Parameters
    ----------
    samples : Samples
    diffuse_level : int, 0 to 8
        D, the level of the dense lattice.
    specular_level : int, 0 to 8, or None
        S, the level of the sparse lattice; None for the dense lattice alone, by "mba" plain MBA (section 3).
    compression : float, 0 to 100
        C, the percentage of the (2^S + 3)^3 specular control points to drop.
    method : {"mba", "kriging"}
        "mba": as Kameya and Lewis (2002). "kriging": closer to the samples in a fraction of the storage, and closer
        to what was not sampled (`estimate`, `regression_kriging`).
    plausible : bool
        By "kriging", make the fit physically plausible: nowhere negative, and of directional albedo at most 1. What
        that changed is in `Fit.changes`. The paper's method has no such means.
    estimated : compact.Estimate, optional
        Of the samples' `distinct` channels, where it is at hand.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a level, the compression or the method is out of range.
    """
    diffuse_level = _level("diffuse_level", diffuse_level)
    kept = None
    if specular_level is not None:
        specular_level = _level("specular_level", specular_level)
        if not isinstance(compression, Real) or not 0 <= compression <= 100:
            raise ValueError(f"compression is {compression!r}, expected a percentage from 0 to 100")
        kept = round((1 - compression / 100) * dense.full_size(specular_level))
    if method not in METHODS:
        raise ValueError(f"method is {method!r}, expected one of {', '.join(METHODS)}")

    stored, columns = distinct(samples)
    assemble = partial(Fit, diffuse_level, compression=0.0 if kept is None else float(compression),
                       channels=stored.channels, name=samples.name, source=samples.source)
    if method == "mba":
        fitted = _as_the_paper(stored, diffuse_level, specular_level, kept, assemble)
    else:
        fitted = regression_kriging.approximate(stored, estimated or regression_kriging.Estimate(stored), diffuse_level, specular_level, kept,
                                     plausible, assemble)
    return replace(fitted, channels=samples.channels, columns=columns)


def distinct(samples):
    """The samples without channels that equal an earlier one, and for each channel which of these it reads."""
    stored, columns = [], []
    for i, column in enumerate(samples.values.T):
        equal = next((k for k, j in enumerate(stored) if np.array_equal(column, samples.values[:, j])), len(stored))
        if equal == len(stored):
            stored.append(i)
        columns.append(equal)
    channels = [samples.channels[i] for i in stored]
    return replace(samples, values=samples.values[:, stored], channels=channels), tuple(columns)


def _as_the_paper(samples, diffuse_level, specular_level, kept, assemble):
    x = nusselt(*samples.directions)
    diffuse, residual = mba.approximate(x, samples.values, diffuse_level)
    specular = None
    if specular_level is not None:
        control_points, _ = mba.approximate(x, residual, specular_level)
        specular = sparse.keep_largest(control_points, specular_level, kept)
    return assemble(diffuse=diffuse.astype(np.float32), specular=specular)


def notation(diffuse_level, specular_level=None, compression=0.0):
    """The levels of a fit as the paper writes them: ``(D,S,C)``, or ``level D`` for plain MBA."""
    return f"level {diffuse_level}" if specular_level is None else (
        f"({diffuse_level},{specular_level},{compression:g})")


def _level(name, level):
    if isinstance(level, bool) or not isinstance(level, int | np.integer) or not 0 <= level <= dense.MAX_LEVEL:
        raise ValueError(f"{name} is {level!r}, expected a whole number from 0 to {dense.MAX_LEVEL}")
    return int(level)
