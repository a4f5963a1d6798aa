"""Whether measurements are of an isotropic material, found from the values at several rotations of the sample.

Samples that agree in theta_i, theta_o and |phi_o - phi_i|, a cell, are compared by y, the cube root of the BRDF times
both cosines. What y differs from its cell's mean, r, is a property of the material where it is alike at neighbours
(outgoing directions at one rotation, or rotations in one cell), which noise is not: the mean product of r at neighbours
is the variance that rotation makes. Where too few samples agree, as when directions are scattered, harmonics of the
azimuth of the half vector are fitted to y, which an isotropic material does not have.
"""

from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, unit_vectors
from ..samples import NO_SYMMETRY, Samples, apply_symmetry, rotations, subset
from .reading import Reading

FEWEST_ROTATIONS = 3        # at which a material can be seen to be anisotropic
_EFFECT = 0.015             # a BRDF that rotation changes by 4.5 %
_CRITERIA = (4.0, _EFFECT), (2.5, 0.08)     # standard errors and effect: of a large effect there is less doubt
_LEAST_EFFECT = 0.15       # the effect where too few samples have neighbours to tell noise: 45 %
_REPEATED = 3.0             # or, where repeated measurements tell the noise, as many times that
_FEWEST = 30                # neighbours, or pairs, whose mean product tells
_AGREEING = 1e-3        # radians between polar angles, and azimuths, that agree
_NEIGHBOURS = np.radians(25)        # between outgoing directions that are neighbours, at most
_TURNED_APART = np.radians(35)  # between rotations that are, likewise
_LINE_ANGLE = np.radians(10)  # of directions that are sought for neighbours together
_RING, _MOST_RINGS = 100, 12        # scattered samples whose half vectors are about as steep, at least; and such rings
_HARMONICS = 1, 2, 4        # of a tilted surface, of a brushed one, of a weave
_OWN_SHARE = 0.8            # of the harmonics' squares, what no polynomial explains: less where paths are few
_SURE_OF_HARMONICS = 8.0    # standard errors: what they leave is not only noise
_MOST = 200_000             # samples that are compared
_TURN = 2 * np.pi
ONE_SIDED = "The two sides of the plane of incidence differ: the fit is the same on both, their mean"


def decide_symmetry(samples: Samples, reading: Reading, said: str = NO_SYMMETRY) -> Samples:
    """Samples as a format returns them: isotropic or not, and of anisotropic ones what their symmetry adds, one of
    `samples.SYMMETRIES` that the file has `said`. What `reading` says of both is true, whatever the values or the file
    say.
    """
    samples = decide_isotropy(samples, reading.isotropic)
    symmetry = said if reading.symmetry is None else reading.symmetry
    if not samples.isotropic or symmetry == NO_SYMMETRY:
        return apply_symmetry(samples, symmetry)
    note = f"Symmetry, {symmetry.replace('_', ' ')}: adds nothing to an isotropic material"
    return replace(samples, notes=(*samples.notes, note))


def decide_isotropy(samples: Samples, isotropic: bool | None = None) -> Samples:
    """Samples that say whether they are isotropic: as asked, or as their values tell; with a note of it.

    Those at one rotation, of which nothing can be told, stay as they are.
    """
    if isotropic is not None:
        return as_asked(samples, isotropic)
    if not np.ptp(samples.phi_i):
        return samples
    is_isotropic, note = _compare_rotations(samples)
    if not is_isotropic:
        note = rotations_note(samples.theta_i, samples.phi_i)
    return replace(samples, isotropic=is_isotropic, notes=(*samples.notes, *filter(None, [note])))


def note_sides(samples: Samples) -> Samples:
    """Samples with a note where those of an isotropic material differ on both sides of the plane of incidence.

    An isotropic fit is the same on both: of a tape that returns light to one side only it is the mean.
    """
    if not samples.isotropic:
        return samples
    apart, side = _relative_azimuths(samples)
    beside = (apart > _AGREEING) & (apart < np.pi - _AGREEING)
    if len({*side[beside].tolist()}) < 2:
        return samples
    chosen = subset(samples, beside)
    chosen = subset(chosen, _some(chosen))
    _, side = _relative_azimuths(chosen)
    y, cell = _size(chosen), _cells(chosen)
    cells = cell.max() + 1
    count = np.stack([np.bincount(cell[at], minlength=cells) for at in (side, ~side)])
    both = count.min(axis=0) > 0
    mean = np.stack([np.bincount(cell[at], y[at], cells) for at in (side, ~side)])[:, both] / count[:, both]
    is_one_sided = mean.shape[1] >= _FEWEST and (
        np.mean((mean[0] - mean[1]) ** 2) > _LEAST_EFFECT ** 2 * np.mean((mean[0] + mean[1]) ** 2))
    return replace(samples, notes=(*samples.notes, ONE_SIDED)) if is_one_sided else samples


def as_asked(samples: Samples, isotropic: bool) -> Samples:
    """Samples that are taken as isotropic or not, whatever they were, with a note of it."""
    notes = [f"Taken as {'isotropic' if isotropic else 'anisotropic'}, as asked"]
    if samples.isotropic and not isotropic:
        notes.append(rotations_note(samples.theta_i, samples.phi_i))
    return replace(samples, isotropic=isotropic, notes=(*samples.notes, *notes))


def rotations_note(theta_i: FloatArray, phi_i: FloatArray) -> str:
    """The note of an anisotropic material that was measured at these directions, (n,) radians each."""
    at = rotations(theta_i, phi_i)
    return (f"Anisotropic, measured at {at.count:,} rotation{'s' * (at.count > 1)} from {at.first:g} to {at.last:g} "
            f"degrees")


def _compare_rotations(samples: Samples) -> tuple[bool, str]:
    """Whether samples at several rotations are isotropic, and what to say of it, if anything."""
    samples = subset(samples, _some(samples))
    y, cell, rotation = _size(samples), _cells(samples), np.mod(samples.phi_i, _TURN)
    rotation = _whole_steps(rotation) % int(np.rint(_TURN / _AGREEING))
    shared = _is_at_several(cell, rotation)
    if 10 * np.count_nonzero(shared) < len(y):
        return _fit_harmonics(samples, y)
    count = len(np.unique(rotation[shared & (samples.theta_i > _AGREEING)]))
    if count < FEWEST_ROTATIONS:
        return True, f"Measured at {count} rotations: taken as isotropic" if count > 1 else ""
    r = (y - (np.bincount(cell, y) / np.bincount(cell))[cell])[shared]
    samples, y, cell = subset(samples, shared), y[shared], cell[shared]
    size = float(np.sqrt(np.mean(y ** 2)))
    tests = [_alike(r, pairs) for pairs in (_direction_neighbours(samples), _rotation_neighbours(samples, cell))]
    if sum(count for count, _, _ in tests) < _FEWEST:
        noise = None if samples.deviation is None else y * samples.deviation / 3
        least = _LEAST_EFFECT * size if noise is None else max(_EFFECT * size, _REPEATED * np.sqrt(np.mean(noise ** 2)))
        differs = np.sqrt(np.mean(r ** 2)) > least
    else:
        differs = any(mean > sure * error and mean > (effect * size) ** 2 for _, mean, error in tests
                      for sure, effect in _CRITERIA)
    return not differs, f"Measured at {count:,} rotations, which agree: taken as isotropic"


def _relative_azimuths(samples: Samples) -> tuple[FloatArray, BoolArray]:
    """The angle between the azimuths, 0 to pi, and whether phi_o is clockwise from phi_i: (n,)."""
    # azimuths may be as large as numbers get
    apart = np.mod(np.mod(samples.phi_o, _TURN) - np.mod(samples.phi_i, _TURN), _TURN)
    return np.minimum(apart, _TURN - apart), apart > np.pi


def _size(samples: Samples) -> FloatArray:
    """y of samples: (n,)."""
    return np.cbrt(samples.values.mean(axis=1) * np.cos(samples.theta_i) * np.cos(samples.theta_o))


def _whole_steps(angle: FloatArray, step: float = _AGREEING) -> IntArray:
    """Angles as whole steps; what is printed in round numbers is not at the edge of one."""
    return np.floor(angle / step + 0.37).astype(np.int64)


def _cells(samples: Samples) -> IntArray:
    """0, 1, 2 ... for each different combination of theta_i, theta_o and |phi_o - phi_i|: (n,)."""
    packed = np.zeros(len(samples), np.int64)
    for angle in (samples.theta_i, samples.theta_o, _relative_azimuths(samples)[0]):
        key = _whole_steps(angle)
        packed = packed * (int(key.max(initial=0)) + 1) + key
    return np.asarray(np.unique(packed, return_inverse=True)[1])


def _some(samples: Samples) -> BoolArray | slice:
    """Of very many samples those of some patches of directions, at all rotations."""
    if len(samples) <= _MOST:
        return slice(None)
    apart, _ = _relative_azimuths(samples)
    patch = _whole_steps(samples.theta_i, np.radians(1)) * 1009 + _whole_steps(apart, _LINE_ANGLE)
    patch = patch * 2654435761 % (1 << 32)
    return np.asarray(patch <= max((1 << 32) * (_MOST / len(samples)), float(patch.min())))


def _is_at_several(cell: IntArray, rotation: IntArray) -> BoolArray:
    """Which samples share their cell with one of another rotation."""
    order = np.lexsort((rotation, cell))
    new = np.ones(len(order), bool)
    new[1:] = (cell[order[1:]] != cell[order[:-1]]) | (rotation[order[1:]] != rotation[order[:-1]])
    return np.asarray(np.bincount(cell[order[new]])[cell] > 1)


def _direction_neighbours(samples: Samples) -> tuple[IntArray, IntArray]:
    """Pairs of samples at one rotation whose outgoing directions are neighbours."""
    (apart, side), theta_o = _relative_azimuths(samples), samples.theta_o
    line = [_whole_steps(np.mod(samples.phi_i, _TURN)), side.astype(np.int64), _whole_steps(samples.theta_i)]
    pairs = []
    for across, along in ((apart, theta_o), (theta_o, apart)):
        order = np.lexsort((along, _whole_steps(across, _LINE_ANGLE), *line))
        a, b = order[:-1], order[1:]
        same = np.all([key[a] == key[b] for key in line], axis=0)
        cosine = (np.cos(theta_o[a]) * np.cos(theta_o[b])
                  + np.sin(theta_o[a]) * np.sin(theta_o[b]) * np.cos(apart[a] - apart[b]))
        near = same & (cosine > np.cos(_NEIGHBOURS)) & (cosine < np.cos(2 * _AGREEING))
        pairs.append((a[near], b[near]))
    return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def _rotation_neighbours(samples: Samples, cell: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of samples in one cell whose rotations are neighbours."""
    (_, side), rotation = _relative_azimuths(samples), np.mod(samples.phi_i, _TURN)
    order = np.lexsort((rotation, side, cell))
    a, b = order[:-1], order[1:]
    turn = rotation[b] - rotation[a]
    near = (cell[a] == cell[b]) & (side[a] == side[b]) & (turn > 2 * _AGREEING) & (turn < _TURNED_APART)
    return a[near], b[near]


def _alike(r: FloatArray, pairs: tuple[IntArray, IntArray]) -> tuple[int, float, float]:
    """The number of pairs, the mean product of what differs, and its standard error."""
    products = r[pairs[0]] * r[pairs[1]]
    if len(products) < 2:
        return len(products), 0.0, 0.0
    return len(products), float(products.mean()), float(products.std() / np.sqrt(len(products) / 2))


def _fit_harmonics(samples: Samples, y: FloatArray) -> tuple[bool, str]:
    """What samples tell of which hardly any agree: whether y follows the azimuth of the half vector.

    In rings of half vectors, a quadratic polynomial of the coordinates of an isotropic material is fitted to y, and
    then harmonics of the azimuth as well. They must explain more than they would of noise.
    """
    count = rotations(samples.theta_i, samples.phi_i).count
    few = True, (f"Measured at {count:,} rotations, but too few directions in common to compare them: taken as "
                 "isotropic" if count >= FEWEST_ROTATIONS else "")
    if count < FEWEST_ROTATIONS or len(y) < _RING:
        return few
    half = (unit_vectors(samples.theta_i, samples.phi_i) + unit_vectors(samples.theta_o, samples.phi_o)).T
    theta_h, phi_h = np.arctan2(np.hypot(half[0], half[1]), half[2]), np.arctan2(half[1], half[0])
    coordinates = np.stack([theta_h, samples.theta_i + samples.theta_o, np.cos(_relative_azimuths(samples)[0])])
    explained = error = own = 0.0
    rings = np.array_split(np.argsort(theta_h, kind="stable"), min(len(y) // _RING, _MOST_RINGS))
    for ring in rings:
        x = coordinates[:, ring] - coordinates[:, ring].mean(axis=1, keepdims=True)
        smooth = np.stack([np.ones(len(ring)), *x, *(x[i] * x[j] for i in range(3) for j in range(i, 3))], axis=1)
        turning = np.stack([wave(m * phi_h[ring]) for m in _HARMONICS for wave in (np.cos, np.sin)], axis=1)
        own += _residual_squares(smooth, turning) / np.sum(turning ** 2) / len(rings)
        before, after = (_residual_squares(columns, y[ring]) for columns in (smooth, np.hstack([smooth, turning])))
        noise = after / (len(ring) - smooth.shape[1] - turning.shape[1])
        explained += before - after - 2 * len(_HARMONICS) * noise
        error += 4 * len(_HARMONICS) * noise ** 2       # of chi squared, the variance
    if own < _OWN_SHARE:
        return few
    differs = explained > max(_SURE_OF_HARMONICS * np.sqrt(error), _EFFECT ** 2 * np.sum(y ** 2))
    return not differs, f"Measured at {count:,} rotations, which agree: taken as isotropic"


def _residual_squares(columns: FloatArray, y: FloatArray) -> float:
    """The sum of squares that a linear combination of columns leaves."""
    return float(np.sum((y - columns @ np.linalg.lstsq(columns, y, rcond=None)[0]) ** 2))
