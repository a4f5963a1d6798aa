"""Measured reflectance as arrays: pairs of directions, and the values measured there."""

from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from .arrays import ArrayLike, BoolArray, Directions, FloatArray, IntArray
from .colours import COLOURS, DEFAULT_COLOURS
from .errors import DatasetError
from .optics.subsurface import Subsurface

RGB = ("R", "G", "B")
HORIZON = np.pi / 2
LARGEST_VALUE = 1e30        # 1/sr: far above any measurement, and finite in single precision, in which fits are stored
NO_SYMMETRY, HALF_TURN, MIRROR, HALF_TURN_AND_MIRROR = "none", "half_turn", "mirror", "half_turn_and_mirror"
SYMMETRIES = (NO_SYMMETRY, HALF_TURN, MIRROR, HALF_TURN_AND_MIRROR)
MOST_REPEATED = 4_000_000   # samples that symmetry makes, at most: 200 MB
_IMAGES = {NO_SYMMETRY: (), HALF_TURN: ((1, np.pi),), MIRROR: ((-1, 0.0),),
           HALF_TURN_AND_MIRROR: ((1, np.pi), (-1, 0.0), (-1, np.pi))}      # of an azimuth: its factor, and a turn
LARGEST_AZIMUTH = 1e6       # radians or degrees: up to it, double precision resolves directions to 1e-10
ROUNDING = 1e-5            # radians: files print angles to 6 decimals, and round pi/2 up
_AT_NORMAL = 1e-3           # radians from the normal within which a direction has no azimuth
_DECIMALS = 10              # of a surface's values, 1/sr
_ROTATION_STEPS = 15_000    # in a quarter turn: directions that agree so far are one
_Array = TypeVar("_Array", FloatArray, BoolArray)


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
    saturated : (n,) bool, or None
        The samples of which the files say that they overflowed the camera; None where they say nothing.
    subsurface : Subsurface, or None
        What lets light through and back: the values then have the diffuse surface of its albedo in them. None of what
        was measured as a BRDF.

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
    colours: str = DEFAULT_COLOURS
    deviation: FloatArray | None = None
    isotropic: bool = True
    saturated: BoolArray | None = None
    subsurface: Subsurface | None = None

    def __post_init__(self) -> None:
        values = _unchangeable(self.values)
        if values.ndim != 2 or not values.size:
            raise self._error(f"values have the shape {values.shape}, expected (samples, channels) with at least one "
                              f"sample")
        # values: a column a channel, of a known colour space
        largest = max(values.max(), -values.min())
        if largest > LARGEST_VALUE:
            raise self._error(f"a value of {largest:g} / sr found, expected at most {LARGEST_VALUE:g}")
        if len(self.channels) != values.shape[1]:
            raise self._error(f"{values.shape[1]} columns of values for the channels {self.channels}")
        if self.colours not in COLOURS:
            raise self._error(f"the colour space {self.colours!r} found, expected one of {', '.join(COLOURS)}")
        self._freeze("values", values)
        # angles: within the upper hemisphere, up to rounding
        for field in ("theta_i", "phi_i", "theta_o", "phi_o"):
            angle = self._check_array(field, _unchangeable(getattr(self, field)))
            if field.startswith("theta"):
                beyond = np.flatnonzero((angle < 0) | (angle > HORIZON + ROUNDING))
                if len(beyond):
                    raise self._error(f"{field}[{beyond[0]}] is {angle[beyond[0]]:g}, expected 0 to pi/2 radians")
                if angle.max() > HORIZON:
                    angle = np.minimum(angle, HORIZON)
            else:
                beyond = np.flatnonzero(np.abs(angle) > LARGEST_AZIMUTH)
                if len(beyond):
                    raise self._error(f"{field}[{beyond[0]}] is {angle[beyond[0]]:g}, expected at most "
                                      f"{LARGEST_AZIMUTH:,.0f} radians")
            self._freeze(field, angle)
        # what some files have besides
        if self.deviation is not None:
            deviation = self._check_array("deviation", _unchangeable(self.deviation))
            if (deviation < 0).any():
                raise self._error("deviation holds numbers below 0")
            self._freeze("deviation", deviation)
        if self.saturated is not None:
            self._freeze("saturated", self._check_array("saturated", np.array(self.saturated, dtype=bool)))
        object.__setattr__(self, "channels", tuple(map(str, self.channels)))

    def _error(self, message: str) -> DatasetError:
        return DatasetError(message, self.source or None)

    def _check_array(self, field: str, array: _Array) -> _Array:
        if array.shape != (len(self.values),):
            raise self._error(f"{field} has the shape {array.shape}, expected ({len(self.values)},)")
        return array

    def _freeze(self, field: str, array: FloatArray | BoolArray) -> None:
        if not np.isfinite(array).all():
            raise self._error(f"{field} holds numbers that are not finite")
        array.flags.writeable = False
        object.__setattr__(self, field, array)

    def __len__(self) -> int:
        return len(self.values)

    @property
    def directions(self) -> Directions:
        """``(theta_i, phi_i, theta_o, phi_o)``, as `Fit.evaluate` takes them."""
        return self.theta_i, self.phi_i, self.theta_o, self.phi_o


def _unchangeable(array: ArrayLike) -> FloatArray:
    """A copy of an array, or the array itself where nobody can change it."""
    if (isinstance(array, np.ndarray) and array.dtype == float and array.base is None and not array.flags.writeable):
        return array
    return np.array(array, dtype=float)


def freeze_new_arrays(*arrays: FloatArray) -> None:
    """Make arrays read-only that nobody else has, so that `Samples` need not copy them."""
    for array in arrays:
        array.flags.writeable = False


def subset(samples: Samples, which: slice | IntArray | BoolArray) -> Samples:
    """Select samples by a slice, by indices or by a mask."""
    arrays = {name: getattr(samples, name) for name in ("theta_i", "phi_i", "theta_o", "phi_o", "values", "deviation",
                                                        "saturated")}
    chosen: dict[str, Any] = {name: array[which] for name, array in arrays.items() if array is not None}
    freeze_new_arrays(*chosen.values())
    return replace(samples, **chosen)


def surface_samples(samples: Samples) -> Samples:
    """What the surface reflects of samples, without what comes from below it."""
    if samples.subsurface is None:
        return samples
    values = samples.values - samples.subsurface.diffuse(samples.theta_i, samples.theta_o)
    return replace(samples, values=np.round(values, _DECIMALS), subsurface=None)      # equal channels stay equal


def choice(count: int, most: int) -> IntArray:
    """Indices of `count` things: of all, or of `most` that are chosen at random, in ascending order."""
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, most, replace=False))


def subsample(samples: Samples, most: int) -> Samples:
    """All samples, or `most` of them that are chosen at random: always the same, in the order that they have."""
    return subset(samples, choice(len(samples), most))


def apply_symmetry(samples: Samples, symmetry: str) -> Samples:
    """Samples and their images by a symmetry of the surface, in directions that were not measured. The notes say so.

    By "half_turn" the surface is the same after half a turn about its normal; by "mirror" the plane of the normal and
    the tangent, phi = 0, is a mirror; or both. Raises DatasetError if the symmetry is none of `SYMMETRIES`, or makes
    more than `MOST_REPEATED` samples.
    """
    if symmetry not in _IMAGES:
        raise DatasetError(f"symmetry {symmetry!r} found, expected {', '.join(SYMMETRIES)}", samples.source or None)
    images = _IMAGES[symmetry]
    if not images:
        return samples
    most = len(samples) * (1 + len(images))
    if most > MOST_REPEATED:
        raise DatasetError(f"{len(samples):,} samples, which the symmetry {symmetry!r} makes {most:,}, expected at "
                           f"most {MOST_REPEATED:,}", samples.source or None)
    known = _number_pairs(*samples.directions)
    which, factors, turns = [np.arange(len(samples))], [1.0], [0.0]
    for factor, turn in images:
        numbers = _number_pairs(samples.theta_i, factor * samples.phi_i + turn,
                                samples.theta_o, factor * samples.phi_o + turn)
        which.append(np.flatnonzero(~np.isin(numbers, known)))
        factors.append(factor)
        turns.append(turn)
        known = np.concatenate([known, numbers[which[-1]]])
    counts = [len(indices) for indices in which]
    factor_of, turn_of = np.repeat(factors, counts), np.repeat(turns, counts)
    whole = subset(samples, np.concatenate(which))
    phi_i, phi_o = factor_of * whole.phi_i + turn_of, factor_of * whole.phi_o + turn_of
    freeze_new_arrays(phi_i, phi_o)
    note = f"Symmetry, {symmetry.replace('_', ' ')}: {len(samples):,} samples stand for {len(whole):,}"
    return replace(whole, phi_i=phi_i, phi_o=phi_o, notes=(*samples.notes, note))


def _number_pairs(theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray) -> IntArray:
    """A number for each pair of directions, (n,): the same where they agree. The normal has no azimuth."""
    number = np.zeros(len(theta_i), np.int64)
    for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)):
        elevation = np.rint(theta * (_ROTATION_STEPS / HORIZON)).astype(np.int64)
        azimuth = np.rint(np.mod(phi, 4 * HORIZON) * (_ROTATION_STEPS / HORIZON)).astype(np.int64)
        azimuth %= 4 * _ROTATION_STEPS
        number = (number * (_ROTATION_STEPS + 1) + elevation) * (4 * _ROTATION_STEPS) + azimuth * (elevation > 0)
    return number


@dataclass(frozen=True)
class Rotations:
    """The rotations of a sample at which it was measured."""

    count: int      # how many azimuths of incidence differ, to a quarter of a degree; at the normal there is none
    first: float    # the range that holds them all, degrees: the complement of the widest gap
    last: float


def rotations(theta_i: FloatArray, phi_i: FloatArray) -> Rotations:
    """The rotations at which samples were measured; (n,) radians each."""
    azimuths = np.degrees(np.mod(phi_i[theta_i > _AT_NORMAL], 2 * np.pi))
    quarters = np.unique(np.rint(azimuths * 4).astype(np.int64) % 1440)         # of a degree
    if not len(quarters):
        return Rotations(1, 0.0, 0.0)
    gaps = np.diff(quarters, append=quarters[0] + 1440)
    widest = len(quarters) - 1 if gaps[-1] >= gaps.max() - 1 else int(gaps.argmax())    # from 0 on, where all are alike
    first = int(quarters[(widest + 1) % len(quarters)])
    return Rotations(len(quarters), first / 4, (first + 1440 - int(gaps[widest])) / 4)


def distinct_channels(samples: Samples) -> tuple[Samples, tuple[int, ...]]:
    """Leave out channels that equal an earlier one; and for each channel, the index of the equal one of those that
    stay.

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
