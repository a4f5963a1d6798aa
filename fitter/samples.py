"""Measured reflectance as arrays: pairs of directions, and the values measured there."""

from dataclasses import dataclass, replace

import numpy as np

from .arrays import ArrayLike, BoolArray, Directions, FloatArray, IntArray
from .colours import COLOURS, DEFAULT
from .errors import DatasetError

RGB = ("R", "G", "B")
HORIZON = np.pi / 2
LARGEST_VALUE = 1e30        # 1/sr: far above any measurement, and finite in single precision, in which fits are stored
NO_SYMMETRY, HALF_TURN, MIRROR, HALF_TURN_AND_MIRROR = "none", "half_turn", "mirror", "half_turn_and_mirror"
SYMMETRIES = (NO_SYMMETRY, HALF_TURN, MIRROR, HALF_TURN_AND_MIRROR)
MOST_REPEATED = 4_000_000   # samples that symmetry makes, at most: 200 MB
_IMAGES = {NO_SYMMETRY: (), HALF_TURN: ((1, np.pi),), MIRROR: ((-1, 0.0),),
           HALF_TURN_AND_MIRROR: ((1, np.pi), (-1, 0.0), (-1, np.pi))}      # of an azimuth: its factor, and a turn
_ROUNDING = 1e-5            # radians: files print angles to 6 decimals, and round pi/2 up
_AT_NORMAL = 1e-3           # radians from the normal within which a direction has no azimuth
_STEPS = 15_000             # in a quarter turn: directions that agree so far are one


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


def choice(count: int, most: int) -> IntArray:
    """Indices of `count` things: of all, or of `most` that are chosen at random, in ascending order.

    Examples
    --------
    >>> choice(4, 10).tolist()
    [0, 1, 2, 3]
    >>> len(set(choice(100, 10).tolist()))
    10
    """
    if count <= most:
        return np.arange(count)
    return np.sort(np.random.default_rng(0).choice(count, most, replace=False))


def some(samples: Samples, most: int) -> Samples:
    """All samples, or `most` of them that are chosen at random: always the same, in the order that they have."""
    return subset(samples, choice(len(samples), most))


def repeated(samples: Samples, symmetry: str) -> Samples:
    """Add what a symmetry of the surface says of directions that were not measured.

    Parameters
    ----------
    samples : Samples
    symmetry : str
        One of `SYMMETRIES`. "half_turn": the surface is the same after half a turn about its normal; "mirror": the
        plane of the normal and the tangent, phi = 0, is a mirror; or both.

    Returns
    -------
    Samples
        These first, then their images, but for those in directions that were measured. The notes say so.

    Raises
    ------
    DatasetError
        If it is none of these, or makes more than `MOST_REPEATED` samples.

    Examples
    --------
    >>> quarter = Samples([0.5, 0.5], [0, 0.7], [0.3, 0.3], [0, 0.1], [[1], [2]], isotropic=False)
    >>> repeated(quarter, "mirror").phi_i.tolist()
    [0.0, 0.7, -0.7]
    """
    if symmetry not in _IMAGES:
        raise DatasetError(f"symmetry {symmetry!r} found, expected {', '.join(SYMMETRIES)}", samples.source or None)
    images = _IMAGES[symmetry]
    most = len(samples) * (1 + len(images))
    if not images:
        return samples
    if most > MOST_REPEATED:
        raise DatasetError(f"{len(samples):,} samples, which the symmetry {symmetry!r} makes {most:,}, expected at "
                           f"most {MOST_REPEATED:,}", samples.source or None)
    known = _places(*samples.directions)
    parts: list[tuple[Directions, IntArray]] = [(samples.directions, np.arange(len(samples)))]
    for factor, turn in images:
        image = (samples.theta_i, factor * samples.phi_i + turn, samples.theta_o, factor * samples.phi_o + turn)
        places = _places(*image)
        new = np.flatnonzero(~np.isin(places, known))
        parts.append((_only(image, new), new))
        known = np.concatenate([known, places[new]])
    theta_i, phi_i, theta_o, phi_o = (np.concatenate([part[axis] for part, _ in parts]) for axis in range(4))
    which = np.concatenate([indices for _, indices in parts])
    values, deviation = samples.values[which], None if samples.deviation is None else samples.deviation[which]
    for array in (theta_i, phi_i, theta_o, phi_o, values):
        array.flags.writeable = False           # so that `Samples` need not copy them
    note = f"Symmetry, {symmetry.replace('_', ' ')}: {len(samples):,} samples stand for {len(which):,}"
    return replace(samples, theta_i=theta_i, phi_i=phi_i, theta_o=theta_o, phi_o=phi_o, values=values,
                   deviation=deviation, notes=(*samples.notes, note))


def _only(directions: Directions, which: IntArray) -> Directions:
    theta_i, phi_i, theta_o, phi_o = (angle[which] for angle in directions)
    return theta_i, phi_i, theta_o, phi_o


def _places(theta_i: FloatArray, phi_i: FloatArray, theta_o: FloatArray, phi_o: FloatArray) -> IntArray:
    """A number for each pair of directions, (n,): the same where they agree. The normal has no azimuth."""
    place = np.zeros(len(theta_i), np.int64)
    for theta, phi in ((theta_i, phi_i), (theta_o, phi_o)):
        elevation = np.rint(theta * (_STEPS / HORIZON)).astype(np.int64)
        azimuth = np.rint(np.mod(phi, 4 * HORIZON) * (_STEPS / HORIZON)).astype(np.int64) % (4 * _STEPS)
        place = (place * (_STEPS + 1) + elevation) * (4 * _STEPS) + azimuth * (elevation > 0)
    return place


@dataclass(frozen=True)
class Rotations:
    """The rotations of a sample at which it was measured.

    Attributes
    ----------
    count : int
        How many azimuths of incidence differ, to a quarter of a degree. At the normal there is none.
    first, last : float
        The range that holds them all, degrees: the complement of the widest gap.
    """

    count: int
    first: float
    last: float


def rotations(theta_i: FloatArray, phi_i: FloatArray) -> Rotations:
    """The rotations at which samples were measured; (n,) radians each.

    Examples
    --------
    >>> rotations(np.ones(3), np.radians([350, 10, 30]))
    Rotations(count=3, first=350.0, last=390.0)
    """
    found = np.unique(np.rint(np.degrees(np.mod(phi_i[theta_i > _AT_NORMAL], 2 * np.pi)) * 4).astype(np.int64) % 1440)
    if not len(found):
        return Rotations(1, 0.0, 0.0)
    gaps = np.diff(found, append=found[0] + 1440)
    widest = len(found) - 1 if gaps[-1] >= gaps.max() - 1 else int(gaps.argmax())       # from 0 on, where all are alike
    first = int(found[(widest + 1) % len(found)])
    return Rotations(len(found), first / 4, (first + 1440 - int(gaps[widest])) / 4)


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
