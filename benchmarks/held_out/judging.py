"""The errors of methods on one set: at samples held out, and where the truth is known, at directions all over.

A set of up to `SMALL` samples is predicted in five folds, each from the other four. Of a larger set, one fold of the
five is predicted, so that it stays affordable. All else, the errors against a truth, the bytes and the pictures, is of
the fit that did not see the first fold: of four fifths of the samples.

Samples beyond `STEEPEST` are fitted to but not judged by: RGL's at 90 degrees are its authors' extrapolation, of which
a few would decide every RMSE.
"""

import time

import numpy as np

from fitter.quality import cross_validation
from fitter.report.methods import METHODS
from fitter.samples import distinct_channels, subset

SMALL = 300                 # samples
STEEPEST = 85.0             # degrees
DIRECTIONS = 20_000
_MIRROR, _RETRO = DIRECTIONS // 3, DIRECTIONS // 6      # how many are near these
_OFFSETS = 0.2, 15.0        # degrees from them: as many from .2 to .4 as from 7 to 14
_SEED = 18
ERRORS = tuple(f"{place}_{error}" for place in ("held_out", "truth") for error in ("rmse", "cube_root_rmse"))


def judge(found, methods):
    """Fit methods to a set, and measure them.

    Parameters
    ----------
    found : JudgedSet
    methods : sequence of str
        Names in `METHODS`.

    Returns
    -------
    record : dict
        name, family, half; samples, judged (how many were predicted), folds, channels (distinct ones), and methods:
        for each its `ERRORS` (those of the truth None where there is none), bytes of all channels, and seconds of the
        processor. A method that failed has None for its errors, and says why in "failed".
    models : dict
        The fit of each method, but of those that failed, to the samples without the first fold.
    """
    samples, truth = found.open()
    parts = cross_validation.folds(len(samples))
    parts = parts[:1] if len(samples) > SMALL else parts
    record = {"name": found.name, "family": found.family, "half": found.half, "samples": len(samples),
              "judged": sum(len(_judged(samples, part)) for part in parts), "folds": len(parts),
              "channels": len(distinct_channels(samples)[0].channels), "methods": {}}
    models = {}
    for name in methods:
        start = time.process_time()
        try:
            row, models[name] = _measure(samples, truth, parts, METHODS[name])
        except Exception as error:              # a long run goes on, and tells
            row = dict.fromkeys((*ERRORS, "bytes")) | {"failed": repr(error)}
        record["methods"][name] = row | {"seconds": time.process_time() - start}
    return record, models


def seen_of(samples):
    """What the models of `judge` are fitted to: the samples without the first fold."""
    return _without(samples, cross_validation.folds(len(samples))[0])


def directions():
    """The directions at which a truth is compared: (theta_i, phi_i, theta_o, phi_o), each (DIRECTIONS,), radians.

    A third lies about the mirror direction, a sixth about the light's, and the rest is spread evenly over both polar
    angles and the azimuth; none is beyond STEEPEST.
    """
    random = np.random.default_rng(_SEED)
    most = np.radians(STEEPEST)
    kept = np.zeros((0, 3))
    for count, azimuth in ((_MIRROR, np.pi), (_RETRO, 0.0)):
        many = 2 * count
        theta_i = most * random.random(many)
        away = np.radians(_OFFSETS[0] * (_OFFSETS[1] / _OFFSETS[0]) ** random.random(many))
        theta_o, phi_o = _turned(theta_i, azimuth, away, 2 * np.pi * random.random(many))
        kept = np.concatenate([kept, np.column_stack([theta_i, theta_o, phi_o])[theta_o < most][:count]])
    rest = random.random((DIRECTIONS - len(kept), 3)) * (most, most, np.pi)
    theta_i, theta_o, phi_o = np.concatenate([kept, rest]).T
    return theta_i, 0 * theta_i, theta_o, phi_o


def _turned(theta, phi, away, around):
    """The directions at an angle `away` from (theta, phi), at an angle `around` it: theta and phi (n,)."""
    x, y, z = np.sin(away) * np.cos(around), np.sin(away) * np.sin(around), np.cos(away)
    x, z = np.cos(theta) * x + np.sin(theta) * z, np.cos(theta) * z - np.sin(theta) * x
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x) + phi


def _measure(samples, truth, parts, make):
    """The row of a method, and its model."""
    predicted = np.empty(samples.values.shape)
    first = None
    for part in parts:
        model = make(_without(samples, part))
        predicted[part] = model.evaluate(*subset(samples, part).directions)
        first = model if first is None else first
    judged = np.concatenate([_judged(samples, part) for part in parts])
    errors = cross_validation.errors(subset(samples, judged), predicted[judged])
    row = {"held_out_rmse": errors.rmse, "held_out_cube_root_rmse": errors.cube_root_rmse,
           **_against(truth, first), "bytes": first.nbytes}
    broken = [name for name in ERRORS if row[name] is not None and not np.isfinite(row[name])]
    if broken:
        raise ArithmeticError(f"not a finite number: {', '.join(broken)}")
    return row, first


def _against(truth, model):
    """Errors against the truth at `directions`."""
    if truth is None:
        return {"truth_rmse": None, "truth_cube_root_rmse": None}
    at = directions()
    exact, found = truth.evaluate(*at), model.evaluate(*at)
    cubes = cross_validation.cube_root(at[2], found) - cross_validation.cube_root(at[2], exact)
    return {"truth_rmse": float(np.sqrt(np.mean((found - exact) ** 2))),
            "truth_cube_root_rmse": float(np.sqrt(np.mean(cubes ** 2)))}


def _without(samples, part):
    seen = np.ones(len(samples), dtype=bool)
    seen[part] = False
    return subset(samples, seen)


def _judged(samples, part):
    """The indices among `part` of samples that are not beyond STEEPEST."""
    highest = np.maximum(samples.theta_i[part], samples.theta_o[part])
    return part[highest < np.radians(STEEPEST) + 1e-4]
