"""Values toward the horizon that nobody measured: lines that software drew where an instrument had ended, at some 75
degrees, straight to 0 at the horizon, with the last value, or with zeros. They would give every ball a dark rim.

They are told by what no measurement does: in nearly all lines of directions, along theta_o or along theta_i, all values
beyond one angle follow from the value there.
"""

from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..samples import HORIZON, Samples, subset
from .reading import Reading

_FROM_ANGLE = np.radians(50)  # no instrument ends before
_SAME_ANGLE = np.radians(0.01)  # angles that are one
_FEWEST = 4                 # values of a line beyond the angle
_NEARLY_ALL_LINES = 0.95    # of the lines
_MOST_ANGLES = 200          # of a table; more are no table
_EXACT = 1e-5               # of the value there, by which values follow from it
_STRAIGHT = 0.03            # likewise on the way to 0 at 90 degrees; Light Tec's lines are resampled
_BEFORE, _KINK = np.radians(10), 0.15   # how far before the angle, and by how much, a line must differ from that way: a
                            # surface that itself goes to 0 as the cosine does differs by .05 at most
_ENDS = np.radians(89.5)    # the value at the horizon itself may be anything
_CONTINUATIONS = {"zero": "where all are 0", "straight": "on a straight line to 0 at 90 degrees",
                  "constant": "with the value there again"}     # as they are looked for


def remove_unmeasured(samples: Samples, reading: Reading) -> Samples:
    """Samples of a scan or a table, whose lines of directions differ in one polar angle, without those that nobody
    measured, unless `reading` keeps them; `notes` say how many, from where on and why.
    """
    if reading.keep_unmeasured:
        return samples
    kept, notes = np.ones(len(samples), dtype=bool), []
    azimuth = np.mod(samples.phi_o - samples.phi_i, 2 * np.pi)
    for name, along, other in (("theta_o", samples.theta_o, samples.theta_i),
                               ("theta_i", samples.theta_i, samples.theta_o)):
        lines = _lines(other, azimuth)
        end = _end(along[kept], lines[kept], samples.values[kept])
        if end is None:
            continue
        angle, rule = end
        beyond = along > angle + _SAME_ANGLE
        notes.append(f"Left out as not measured: {np.count_nonzero(kept & beyond):,} of {len(samples):,} samples "
                     f"beyond {name} = {np.degrees(angle):.4g} degrees, {_CONTINUATIONS[rule]}")
        kept &= ~beyond
    return samples if not notes else replace(subset(samples, kept), notes=(*samples.notes, *notes))


def _lines(theta: FloatArray, azimuth: FloatArray) -> IntArray:
    """A number for each sample: the same for those in which both angles are the same."""
    steps, turns = (np.rint(angle / _SAME_ANGLE).astype(np.int64) for angle in (theta, azimuth))
    return np.asarray(np.unique(steps * (round(2 * np.pi / _SAME_ANGLE) + 2) + turns, return_inverse=True)[1])


def _end(theta: FloatArray, lines: IntArray, values: FloatArray) -> tuple[float, str] | None:
    """The first angle beyond which nearly all lines follow a rule, radians, and the rule; None if they do not."""
    steps = np.rint(theta / _SAME_ANGLE).astype(np.int64)
    angles = np.unique(steps)
    candidates = angles[(angles * _SAME_ANGLE >= _FROM_ANGLE)][:-_FEWEST]
    if not len(candidates) or len(angles) > _MOST_ANGLES:
        return None
    for rule in _CONTINUATIONS:
        holds = [_nearly_all(lines, steps > step, _follow(rule, theta, steps == step, steps > step, lines, values))
                 for step in candidates]
        # where it holds from the beginning, that is how the surface is: a Lambertian is constant
        if any(holds) and not holds[0]:
            return float(candidates[holds.index(True)] * _SAME_ANGLE), rule
    return None


def _nearly_all(lines: IntArray, beyond: BoolArray, follow: BoolArray) -> bool:
    """Whether nearly all lines have values beyond an angle which all follow: (n,) each."""
    count = np.bincount(lines, beyond)
    wrong = np.bincount(lines, beyond & ~follow)
    tested = count >= _FEWEST
    # a table of few lines proves nothing
    return bool(np.count_nonzero(tested) >= _FEWEST
                and np.count_nonzero(tested & (wrong == 0)) >= _NEARLY_ALL_LINES * np.count_nonzero(tested))


def _follow(rule: str, theta: FloatArray, here: BoolArray, beyond: BoolArray, lines: IntArray,
            values: FloatArray) -> BoolArray:
    """Whether samples follow, by one of `_CONTINUATIONS`, from the value of their line at the angle that is `here`."""
    if rule == "straight":
        return _are_straight(theta, here, beyond, lines, values)
    start = np.full((lines.max() + 1, values.shape[1]), np.nan)     # where a line has no value there
    start[lines[here]] = values[here]
    start = start[lines]
    if rule == "zero":
        return np.asarray((values == 0).all(axis=1) & (start != 0).any(axis=1))
    size = np.abs(start).max(axis=1)
    return np.asarray((size > 0) & (np.abs(values - start).max(axis=1) <= _EXACT * size))


def _are_straight(theta: FloatArray, here: BoolArray, beyond: BoolArray, lines: IntArray,
                  values: FloatArray) -> BoolArray:
    if theta.max() < _ENDS:
        return np.zeros(len(theta), dtype=bool)
    rest = np.maximum(HORIZON - theta, _SAME_ANGLE)
    slope = values.mean(axis=1) / rest
    angle = theta[here][0] if here.any() else 0.0
    inside = beyond & (theta < _ENDS)
    steepness = np.bincount(lines, inside * slope) / np.maximum(np.bincount(lines, inside), 1)
    wanted = steepness[lines]
    follows = np.abs(slope - wanted) <= _STRAIGHT * np.abs(wanted)
    before = np.abs(theta - (angle - _BEFORE)) < _BEFORE / 4
    kinked = np.bincount(lines, before * slope) / np.maximum(np.bincount(lines, before), 1)
    broken = np.abs(kinked - steepness) >= _KINK * np.abs(steepness)
    starts = np.bincount(lines, here & follows) > 0
    return np.asarray((follows | (theta >= _ENDS)) & broken[lines] & starts[lines])
