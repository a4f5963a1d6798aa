"""Extrapolation of a field outside the measured domain: with the colour at its edge, and no growth of its own.

A Gaussian process continues the field above the prior along its slope, in each channel for itself: extrapolated
highlights turn yellow or magenta. Here each extrapolated pair of directions has the differences between channels of a
measured pair with the same half vector, so that a highlight is compared with itself. The mean over channels is the
continued one; of many samples, whose lattices know no process, no larger than that of the measured pair.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, Directions, FloatArray, select_directions, unit_vectors
from ..coordinates import direction_sampling
from ..samples import HORIZON, Samples
from ..shader_constants import LEAST_LENGTH

_EXTRAPOLATED_DIRECTIONS = 4000  # at which the field of many samples is extrapolated
_BISECTIONS = 20            # of bisection
_FAR = np.radians(3)        # over which the colour of a process becomes that of the last angles
_MARGIN = np.radians(0.5)   # beyond the last angle that counts as measured


class MeasuredDomain(NamedTuple):
    """How far measurements go: the larger and the smaller of the largest angles of both directions, radians."""

    larger: float
    smaller: float


def measured_domain(samples: Samples) -> MeasuredDomain:
    """The measured domain of samples, from the largest polar angles of both directions."""
    smaller, larger = sorted((float(samples.theta_i.max()), float(samples.theta_o.max())))
    return MeasuredDomain(larger + _MARGIN, smaller + _MARGIN)


def is_extrapolated(theta_i: FloatArray, theta_o: FloatArray, limits: MeasuredDomain) -> BoolArray:
    """Whether pairs of directions lie outside the measured domain; by reciprocity either may be the light's."""
    return np.asarray((np.maximum(theta_i, theta_o) > limits.larger) | (np.minimum(theta_i, theta_o) > limits.smaller))


def is_extrapolated_in_any(theta_i: FloatArray, theta_o: FloatArray, limits: Iterable[MeasuredDomain]) -> BoolArray:
    """Whether pairs of directions, (n,) radians each, lie outside the measured domain of any of several materials."""
    found = [is_extrapolated(theta_i, theta_o, each) for each in limits]
    return np.any([np.zeros(len(theta_i), dtype=bool), *found], axis=0)


def sample_extrapolated(limits: MeasuredDomain, isotropic: bool) -> Directions:
    """Directions outside the measured domain, at most `_EXTRAPOLATED_DIRECTIONS` of them: four (n,) arrays, radians."""
    every = direction_sampling.sample_directions(_EXTRAPOLATED_DIRECTIONS, isotropic)
    return select_directions(every, is_extrapolated(every[0], every[2], limits))


def clamp_to_domain(pairs: Directions, limits: MeasuredDomain) -> Directions:
    """The nearest measured pairs of the same half vectors, by bisection of the difference angle: four (n,), radians."""
    first, second = unit_vectors(*pairs[:2]), unit_vectors(*pairs[2:])
    half = first + second
    length = np.linalg.norm(half, axis=1, keepdims=True)
    half = np.where(length > LEAST_LENGTH, half / np.maximum(length, LEAST_LENGTH), [0.0, 0.0, 1.0])
    # a half vector outside the domain moves to its edge, toward the normal
    flat = np.hypot(half[:, 0], half[:, 1])
    tilt = np.minimum(np.arctan2(flat, half[:, 2]), limits.smaller)
    half = np.column_stack([half[:, :2] * (np.sin(tilt) / np.maximum(flat, LEAST_LENGTH))[:, None], np.cos(tilt)])
    # the difference vector, perpendicular to the half vector
    apart = (first - second) / 2
    sine = np.linalg.norm(apart, axis=1, keepdims=True)
    apart = apart - half * (apart * half).sum(axis=1, keepdims=True)
    apart /= np.maximum(np.linalg.norm(apart, axis=1, keepdims=True), LEAST_LENGTH)
    low, high = np.zeros(len(half)), np.arcsin(np.minimum(sine[:, 0], 1))

    def pair_at(angle: FloatArray) -> Directions:
        both = [np.cos(angle)[:, None] * half + sign * np.sin(angle)[:, None] * apart for sign in (1, -1)]
        angles = [(np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2]), np.arctan2(w[:, 1], w[:, 0])) for w in both]
        return *angles[0], *angles[1]

    # the largest difference angle within the domain
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        theta_i, _, theta_o, _ = pair_at(middle)
        out = is_extrapolated(theta_i, theta_o, limits)
        low, high = np.where(out, low, middle), np.where(out, middle, high)
    theta_i, phi_i, theta_o, phi_o = pair_at(low)
    return np.minimum(theta_i, HORIZON), phi_i, np.minimum(theta_o, HORIZON), phi_o


def extrapolation_distance(theta_i: FloatArray, theta_o: FloatArray, limits: MeasuredDomain) -> FloatArray:
    """The distance from the measured domain, (n,): from 0 at its edge to 1 at `_FAR`, so that there is no kink."""
    larger = np.maximum(theta_i, theta_o) - limits.larger
    smaller = np.minimum(theta_i, theta_o) - limits.smaller
    return np.clip(np.maximum(larger, smaller) / _FAR, 0, 1)


def transfer_colour(there: FloatArray, continued: FloatArray) -> FloatArray:
    """The continued field with the differences between channels of another: (n, channels) each."""
    return there + continued.mean(axis=1, keepdims=True) - there.mean(axis=1, keepdims=True)


def extrapolate(continued: FloatArray, there: FloatArray) -> FloatArray:
    """The extrapolated field: the smaller of that at the clamped directions and the continued one, with the colour of
    the first, (n, channels) each.

    Examples
    --------
    >>> extrapolate(np.array([[0.0, 1.0], [3.0, 5.0]]), np.array([[1.0, 2.0], [1.0, 2.0]])).tolist()
    [[0.0, 1.0], [1.0, 2.0]]
    """
    return np.minimum(transfer_colour(there, continued), there)
