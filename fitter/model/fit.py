"""A fit: what is stored of a measured reflectance, and its evaluation.

Kameya and Lewis 2002, section 4: a function f_d + f_s of the directions' coordinates, f_d on a coarse dense lattice,
f_s on a fine sparse one that has one set of control points for all channels. A transform says what that function means:
the paper's lattices hold the reflectance itself.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..coordinates import Coordinates
from ..lattice.dense import DenseLattice
from ..lattice.sparse import SparseLattice
from . import fit_file
from .transform import IDENTITY, Transform

_CHUNK = 1 << 16            # directions evaluated at a time


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted reflectance.

    Attributes
    ----------
    coordinates : coordinates.Coordinates
        Of which coordinates of the directions the lattices are functions.
    diffuse : DenseLattice
        One column of control points for each distinct channel.
    specular : SparseLattice, or None
        Adds to the dense lattice; None for the dense one alone.
    transform : transform.Transform
        What makes a reflectance of the sum of the lattices.
    compression : float
        Percentage of the specular lattice that was dropped; 0 without one.
    channels : tuple of str
    columns : tuple of int
        Which column of the arrays each channel reads: equal channels are stored once. By default each its own.
    changes : tuple of str
        What was changed to make the fit physically plausible, in words.
    name, source : str
        As in the `Samples` it was fitted to.
    """

    coordinates: Coordinates
    diffuse: DenseLattice
    specular: SparseLattice | None = None
    transform: Transform = IDENTITY
    compression: float = 0.0
    channels: tuple[str, ...] = ("grey",)
    columns: tuple[int, ...] = ()
    changes: tuple[str, ...] = ()
    name: str = "untitled"
    source: str = ""

    def __post_init__(self) -> None:
        if not self.columns:
            object.__setattr__(self, "columns", tuple(range(len(self.channels))))

    @property
    def diffuse_level(self) -> int:
        """D, the level of the dense lattice."""
        return self.diffuse.level

    @property
    def specular_level(self) -> int | None:
        """S, or None without a sparse lattice."""
        return None if self.specular is None else self.specular.level

    @property
    def notation(self) -> str:
        """The levels as the paper writes them."""
        return notation(self.diffuse_level, self.specular_level, self.compression)

    @property
    def coefficient_count(self) -> int:
        """Control points stored, dense and sparse, counted once whatever the number of channels."""
        return self.diffuse.count + (0 if self.specular is None else self.specular.count)

    @property
    def nbytes(self) -> int:
        """Bytes that must be stored to evaluate, over all channels: coefficients, keys, hash table and prior."""
        return self.diffuse.nbytes + (0 if self.specular is None else self.specular.nbytes) + self.transform.nbytes

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The fitted BRDF, negative where a fit that need not be plausible undershoots.

        Parameters
        ----------
        theta_i, phi_i, theta_o, phi_o : (n,) array_like
            Directions, radians; they may be broadcast.

        Returns
        -------
        (n, channels) float64
            1/sr.

        Raises
        ------
        ValueError
            If an angle is not a finite number.
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

    def _stored_columns(self, theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray,
                        phi_o: FloatArray) -> FloatArray:
        x = self.coordinates.encode(theta_i, phi_i, theta_o, phi_o)
        field = self.diffuse.evaluate(x)
        if self.specular is not None:
            field += self.specular.evaluate(x)
        return self.transform.reflectance(field, theta_i, phi_i, theta_o, phi_o)

    def save(self, path: str | Path) -> None:
        """Write the fit to an .npz file; what was there is replaced only once the new file is whole."""
        fit_file.write(self, path)

    @staticmethod
    def load(path: str | Path) -> "Fit":
        """Read a fit that `save` wrote; `DatasetError` if the file is anything else."""
        return Fit(**fit_file.read(path))


def notation(diffuse_level: int, specular_level: int | None = None, compression: float = 0.0) -> str:
    """The levels of a fit as the paper writes them: ``(D,S,C)``, or ``level D`` for plain MBA.

    >>> notation(4, 6, 95.0)
    '(4,6,95)'
    """
    return f"level {diffuse_level}" if specular_level is None else (
        f"({diffuse_level},{specular_level},{compression:g})")
