"""Measured reflectance as arrays: a list of direction pairs and the values measured there."""

from dataclasses import dataclass, replace

import numpy as np

from .arrays import BoolArray, Directions, FloatArray, IntArray
from .errors import DatasetError

RGB = ("R", "G", "B")
HORIZON = np.pi / 2
LARGEST_VALUE = 1e30        # 1/sr; fits are stored in single precision, and no measurement comes near
_ROUNDING = 1e-5            # files print angles to 6 decimals, so pi/2 may come out slightly above itself


@dataclass(frozen=True, eq=False)
class Samples:
    """A measured isotropic BRDF.

    Directions point away from the surface; theta is measured from the normal, so that every theta is within
    0 to pi/2.

    Attributes
    ----------
    theta_i, phi_i, theta_o, phi_o : (n,) float64
        Incident and outgoing direction, radians.
    values : (n, channels) float64
        BRDF, 1/sr.
    channels : tuple of str
        One name a channel: ``('R', 'G', 'B')``, or ``('grey',)``.
    name : str
        What was measured.
    source : str
        Where it came from: a path, or a description of how it was made.

    Raises
    ------
    DatasetError
        If the arrays do not have these shapes, or hold anything that is not a finite number, a direction below
        the horizon, or a value that single precision cannot take.
    """

    theta_i: FloatArray
    phi_i: FloatArray
    theta_o: FloatArray
    phi_o: FloatArray
    values: FloatArray
    channels: tuple[str, ...] = ("grey",)
    name: str = "untitled"
    source: str = ""

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=float)
        if values.ndim != 2 or not values.size:
            raise DatasetError(f"values have the shape {values.shape}, expected (samples, channels) with at least "
                               f"one sample", self.source or None)
        if np.abs(values).max() > LARGEST_VALUE:
            raise DatasetError(f"a value of {np.abs(values).max():g} / sr found, expected at most {LARGEST_VALUE:g}",
                               self.source or None)
        if len(self.channels) != values.shape[1]:
            raise DatasetError(f"{values.shape[1]} columns of values for the channels {self.channels}",
                               self.source or None)
        self._freeze("values", values)
        for field in ("theta_i", "phi_i", "theta_o", "phi_o"):
            angle = np.array(getattr(self, field), dtype=float)
            if angle.shape != (len(values),):
                raise DatasetError(f"{field} has the shape {angle.shape}, expected ({len(values)},)",
                                   self.source or None)
            if field.startswith("theta"):
                beyond = np.flatnonzero((angle < 0) | (angle > HORIZON + _ROUNDING))
                if len(beyond):
                    raise DatasetError(f"{field}[{beyond[0]}] is {angle[beyond[0]]:g}, expected 0 to pi/2 radians",
                                       self.source or None)
                angle = np.minimum(angle, HORIZON)
            self._freeze(field, angle)
        object.__setattr__(self, "channels", tuple(map(str, self.channels)))

    def _freeze(self, field: str, array: FloatArray) -> None:
        if not np.isfinite(array).all():
            raise DatasetError(f"{field} holds numbers that are not finite", self.source or None)
        array.flags.writeable = False
        object.__setattr__(self, field, array)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def directions(self) -> Directions:
        """``(theta_i, phi_i, theta_o, phi_o)``, as `Fit.evaluate` takes them."""
        return self.theta_i, self.phi_i, self.theta_o, self.phi_o


def subset(samples: Samples, which: slice | IntArray | BoolArray) -> Samples:
    """The samples at an index, a slice or a mask."""
    arrays = {name: getattr(samples, name)[which] for name in ("theta_i", "phi_i", "theta_o", "phi_o", "values")}
    return replace(samples, **arrays)


def distinct_channels(samples: Samples) -> tuple[Samples, tuple[int, ...]]:
    """Leave out channels that equal an earlier one.

    Returns
    -------
    distinct : Samples
    columns : tuple of int
        Which channel of `distinct` each channel of the samples equals.
    """
    stored: list[int] = []
    columns = []
    for i, column in enumerate(samples.values.T):
        equal = next((k for k, j in enumerate(stored) if np.array_equal(column, samples.values[:, j])), len(stored))
        if equal == len(stored):
            stored.append(i)
        columns.append(equal)
    channels = tuple(samples.channels[i] for i in stored)
    return replace(samples, values=samples.values[:, stored], channels=channels), tuple(columns)
