"""The bi-level model of Kameya and Lewis 2002, section 4, generalised to other coordinates and transforms: the lattices
hold a field f_d + f_s over coordinates of the directions, which a transform maps to reflectance."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from ..arrays import ArrayLike, FloatArray, broadcast_directions
from ..coordinates import ISOTROPIC_AXES, Coordinates
from ..lattice import dense, sparse
from ..lattice.dense import DenseLattice
from ..lattice.sparse import SparseLattice
from ..optics.subsurface import Subsurface
from ..samples import HORIZON, ROUNDING
from ..storage import files
from . import fit_file
from .edit import Edit
from .transform import LogRelative

_CHUNK = 1 << 16            # directions evaluated at a time


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted reflectance.

    Attributes
    ----------
    coordinates : coordinates.Coordinates
        The arguments of the field.
    diffuse : DenseLattice
        f_d; it has a column of control points for each distinct channel.
    specular : SparseLattice, or None
        f_s, or None for f_d alone.
    transform : LogRelative, or None
        Maps the field to reflectance; None where the field is the reflectance, as in the paper.
    compression : float
        Percentage of the specular control points that was dropped; 0 without a specular lattice.
    channels : tuple of str
    columns : tuple of int
        For each channel, the column of the lattices that it reads: equal channels share one. By default, each has its
        own.
    changes : tuple of str
        What was changed to make the fit physically plausible, in words.
    name, source : str
        Those of the `Samples`.
    edit : Edit, or None
        What an artist has changed; `evaluate` has the edited reflectance.
    subsurface : Subsurface, or None
        What is below the surface that the lattices hold; `evaluate` adds the diffuse surface of its albedo.

    Examples
    --------
    A Lambertian of albedo 0.6, as a lattice of equal control points:

    >>> from ..coordinates.nusselt import Nusselt
    >>> from ..lattice import dense
    >>> control_points = np.full((*dense.shape(1), 1), 0.6 / np.pi, dtype=np.float32)
    >>> lambertian = Fit(Nusselt(), DenseLattice(1, control_points))
    >>> (np.pi * lambertian.evaluate([0, 0.5], 0, [0.3, 1.5], 2)).round(6).tolist()
    [[0.6], [0.6]]
    >>> lambertian.notation, lambertian.coefficient_count, lambertian.nbytes
    ('level 1', 80, 320)
    """

    coordinates: Coordinates
    diffuse: DenseLattice
    specular: SparseLattice | None = None
    transform: LogRelative | None = None
    compression: float = 0.0
    channels: tuple[str, ...] = ("grey",)
    columns: tuple[int, ...] = ()
    changes: tuple[str, ...] = ()
    name: str = "untitled"
    source: str = ""
    edit: Edit | None = None
    subsurface: Subsurface | None = None

    def __post_init__(self) -> None:
        if not self.columns:
            object.__setattr__(self, "columns", tuple(range(len(self.channels))))

    @property
    def isotropic(self) -> bool:
        """Whether the reflectance stays the same when both directions turn about the normal."""
        return len(self.coordinates.axes) == ISOTROPIC_AXES and (self.transform is None or self.transform.isotropic)

    @property
    def edited_subsurface(self) -> Subsurface | None:
        """What is below the surface, as it was edited."""
        if self.subsurface is None or self.edit is None:
            return self.subsurface
        return replace(self.subsurface, albedo=np.clip(self.subsurface.albedo * self.edit.diffuse, 0, 1))

    @property
    def surface(self) -> "Fit":
        """The surface alone."""
        return self if self.subsurface is None else replace(self, subsurface=None)

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
        """The levels in the paper's notation."""
        return notation(self.diffuse_level, self.specular_level, self.compression)

    @property
    def coefficient_count(self) -> int:
        """Control points stored, dense and sparse, counted once whatever the number of channels."""
        return self.diffuse.count + (0 if self.specular is None else self.specular.count)

    @property
    def nbytes(self) -> int:
        """Bytes that must be stored to evaluate, over all channels: coefficients, keys, hash table, prior, and edit."""
        return self.diffuse.nbytes + sum(part.nbytes for part in (self.specular, self.transform, self.edit)
                                         if part is not None)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """Evaluate the fitted BRDF, as it was edited. Raises ValueError if an angle is not a finite number.

        Parameters
        ----------
        theta_i, phi_i, theta_o, phi_o : array_like, broadcast to (...)
            Incident and outgoing direction, radians. A polar angle below 0 is the same angle at the opposite azimuth.

        Returns
        -------
        (..., channels) float64
            1/sr, without the cosine; 0 where a direction is below the horizon. A fit that was not made plausible may be
            negative.
        """
        angles = broadcast_directions(theta_i, phi_i, theta_o, phi_o)
        directions = [angle.ravel() for angle in angles]
        if not all(np.isfinite(angle).all() for angle in directions):
            raise ValueError("directions that are not finite numbers")
        directions = [*_nonnegative_polar(*directions[:2]), *_nonnegative_polar(*directions[2:])]
        below = np.maximum(directions[0], directions[2]) > HORIZON + ROUNDING
        values = np.empty((angles[0].size, len(self.columns)))
        for start in range(0, len(values), _CHUNK):
            part = slice(start, start + _CHUNK)
            at = [angle[part] for angle in directions]
            values[part] = (self._stored_columns(*at)[:, self.columns] if self.edit is None else
                            self.edit.reflectance(self._stored_columns, self.columns, *at))
        if self.edited_subsurface is not None:
            values += self.edited_subsurface.diffuse(directions[0], directions[2])
        values[below] = 0
        return values.reshape(*angles[0].shape, len(self.columns))

    @cached_property
    def _total(self) -> tuple[int, FloatArray] | None:
        """Both lattices as one, which takes half the time; None without a sparse one, or where it would be large."""
        return None if self.specular is None else sparse.total(self.diffuse, self.specular)

    def _stored_columns(self, theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray,
                        phi_o: FloatArray) -> FloatArray:
        x = self.coordinates.encode(theta_i, phi_i, theta_o, phi_o)
        if self._total is not None:
            level, control_points = self._total
            field = dense.evaluate(control_points, level, x)
        else:
            field = self.diffuse.evaluate(x)
            if self.specular is not None:
                field += self.specular.evaluate(x)
        return field if self.transform is None else self.transform.reflectance(field, theta_i, phi_i, theta_o, phi_o)

    def save(self, path: str | Path) -> None:
        """Write the fit to an .npz file. A file at `path` is replaced once the new one is complete.

        Raises OSError if the file cannot be written; a file at `path` then stays as it was.
        """
        with files.replace_file(path) as stream:
            stream.write(self.to_bytes())

    @staticmethod
    def load(path: str | Path) -> "Fit":
        """Read a fit that `save` wrote; anything else raises `DatasetError`."""
        return Fit(**fit_file.read(path))

    def to_bytes(self) -> bytes:
        """The fit as `save` writes it. Equal fits have equal bytes."""
        return fit_file.to_bytes({field.name: getattr(self, field.name) for field in fields(self)})

    @staticmethod
    def from_bytes(content: bytes) -> "Fit":
        """Read a fit that `to_bytes` returned; anything else raises `DatasetError`."""
        return Fit(**fit_file.from_bytes(content))


def notation(diffuse_level: int, specular_level: int | None = None, compression: float = 0.0) -> str:
    """The levels of a fit in the paper's notation: ``(D,S,C)``, or ``level D`` for plain MBA."""
    return f"level {diffuse_level}" if specular_level is None else (
        f"({diffuse_level},{specular_level},{compression:g})")


def _nonnegative_polar(theta: FloatArray, phi: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same directions with polar angles of 0 to pi, radians."""
    turned = theta - 2 * np.pi * np.round(theta / (2 * np.pi))
    return np.abs(turned), np.where(turned < 0, phi + np.pi, phi)
