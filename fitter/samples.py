"""Measured reflectance as arrays: pairs of directions, and the values measured there."""

from dataclasses import dataclass, replace

import numpy as np

from .arrays import ArrayLike, BoolArray, Directions, FloatArray, IntArray
from .colours import COLOURS, DEFAULT
from .errors import DatasetError

RGB = ("R", "G", "B")
HORIZON = np.pi / 2
LARGEST_VALUE = 1e30        # 1/sr: far above any measurement, and finite in single precision, in which fits are stored
_ROUNDING = 1e-5            # radians: files print angles to 6 decimals, and round pi/2 up


@dataclass(frozen=True, eq=False)
class Samples:
    """A measured BRDF.

    Directions point away from the surface. Polar angles theta are measured from the normal: 0 to pi/2. Azimuths are
    measured from the tangent, toward the bitangent; of an isotropic BRDF only their difference matters. The arrays are
    copied and made read-only; those of float64 that are read-only already, and no views, are taken as they are.

    Attributes
    ----------
    theta_i, phi_i, theta_o, phi_o : (n,) float64
        Incident and outgoing direction, radians.
    values : (n, channels) float64
        BRDF, 1/sr.
    channels : tuple of str
        The name of each channel: ``('R', 'G', 'B')``, or ``('grey',)``.
    name : str
        What was measured.
    source : str
        Where the data came from: a path, or how they were made.
    notes : tuple of str
        What reading made of the file, for its description.
    colours : str
        One of `colours.COLOURS`: what R, G and B are. Of grey samples it means nothing.
    deviation : (n,) float64, or None
        The relative standard deviation of each sample, if repeated measurements tell it. The larger, the less a fit
        follows a sample.
    isotropic : bool
        Whether the BRDF is to be taken as one that does not change when both directions turn about the normal.

    Raises
    ------
    DatasetError
        If the arrays do not have these shapes, or hold a number that is not finite, a direction below the horizon, or
        a value above `LARGEST_VALUE`; or if the colour space is not known.

    Examples
    --------
    >>> grey = Samples([0.0, 0.5], [0, 0], [0.3, 0.6], [0, 3.1], [[0.2], [0.25]])
    >>> len(grey), grey.values.shape, grey.channels
    (2, (2, 1), ('grey',))
    >>> try:
    ...     Samples([2.0], [0], [0.3], [0], [[0.2]])
    ... except DatasetError as error:
    ...     print(error)
    theta_i[0] is 2, expected 0 to pi/2 radians
    """

    theta_i: FloatArray
    phi_i: FloatArray
    theta_o: FloatArray
    phi_o: FloatArray
    values: FloatArray
    channels: tuple[str, ...] = ("grey",)
    name: str = "untitled"
    source: str = ""
    notes: tuple[str, ...] = ()
    colours: str = DEFAULT
    deviation: FloatArray | None = None
    isotropic: bool = True

    def __post_init__(self) -> None:
        values = _own(self.values)
        if values.ndim != 2 or not values.size:
            raise DatasetError(f"values have the shape {values.shape}, expected (samples, channels) with at least "
                               f"one sample", self.source or None)
        largest = max(values.max(), -values.min())
        if largest > LARGEST_VALUE:
            raise DatasetError(f"a value of {largest:g} / sr found, expected at most {LARGEST_VALUE:g}",
                               self.source or None)
        if len(self.channels) != values.shape[1]:
            raise DatasetError(f"{values.shape[1]} columns of values for the channels {self.channels}",
                               self.source or None)
        if self.colours not in COLOURS:
            raise DatasetError(f"the colour space {self.colours!r} found, expected one of {', '.join(COLOURS)}",
                               self.source or None)
        self._freeze("values", values)
        for field in ("theta_i", "phi_i", "theta_o", "phi_o"):
            angle = _own(getattr(self, field))
            if angle.shape != (len(values),):
                raise DatasetError(f"{field} has the shape {angle.shape}, expected ({len(values)},)",
                                   self.source or None)
            if field.startswith("theta"):
                beyond = np.flatnonzero((angle < 0) | (angle > HORIZON + _ROUNDING))
                if len(beyond):
                    raise DatasetError(f"{field}[{beyond[0]}] is {angle[beyond[0]]:g}, expected 0 to pi/2 radians",
                                       self.source or None)
                if len(angle) and angle.max() > HORIZON:
                    angle = np.minimum(angle, HORIZON)
            self._freeze(field, angle)
        if self.deviation is not None:
            deviation = _own(self.deviation)
            if deviation.shape != (len(values),) or (deviation < 0).any():
                raise DatasetError(f"deviation must have the shape ({len(values)},), and nothing below 0",
                                   self.source or None)
            self._freeze("deviation", deviation)
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


def _own(array: ArrayLike) -> FloatArray:
    """A copy of an array, or the array itself where nobody can change it."""
    if (isinstance(array, np.ndarray) and array.dtype == float and array.base is None and not array.flags.writeable):
        return array
    return np.array(array, dtype=float)


def subset(samples: Samples, which: slice | IntArray | BoolArray) -> Samples:
    """Select samples by a slice, by indices or by a mask.

    Examples
    --------
    >>> three = Samples([0.1, 0.2, 0.3], [0, 0, 0], [0, 0, 0], [0, 0, 0], [[1], [2], [3]])
    >>> subset(three, three.values[:, 0] > 1).theta_i.tolist()
    [0.2, 0.3]
    """
    arrays = {name: getattr(samples, name)[which] for name in ("theta_i", "phi_i", "theta_o", "phi_o", "values")}
    deviation = None if samples.deviation is None else samples.deviation[which]
    return replace(samples, **arrays, deviation=deviation)


def distinct_channels(samples: Samples) -> tuple[Samples, tuple[int, ...]]:
    """Leave out channels that equal an earlier one.

    Returns
    -------
    distinct : Samples
    columns : tuple of int
        For each channel of the samples, the index of the equal channel in `distinct`.

    Examples
    --------
    >>> rgb = Samples([0], [0], [0], [0], [[0.3, 0.1, 0.3]], channels=("R", "G", "B"))
    >>> distinct, columns = distinct_channels(rgb)
    >>> distinct.channels, columns
    (('R', 'G'), (0, 1, 0))
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
