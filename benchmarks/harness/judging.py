"""Errors of models at samples, and at directions all over where the truth is known; models that fail are recorded.

Samples beyond `STEEPEST` are fitted to but not judged by: RGL's at 90 degrees are its authors' extrapolation, of which
a few would decide every RMSE.
"""

import time

import numpy as np

from fitter.quality.cross_validation import cube_root

STEEPEST = 85.0             # degrees
DIRECTIONS = 20_000
_MIRROR, _RETRO = DIRECTIONS // 3, DIRECTIONS // 6      # how many are near these
_OFFSETS = 0.2, 15.0        # degrees from them: as many from .2 to .4 as from 7 to 14
_SEED = 18
KINDS = ("rmse", "cube_root_rmse", "cube_root_mae")


def errors(place, theta_o, truth, found, kinds=KINDS):
    """Errors of values (n, channels), over all directions and channels: {place_kind: error}.

    RMSE in 1/sr, and RMSE and *mean* absolute difference of the cube roots of cosine-weighted values, in 1/sr to the
    power 1/3. Raises ArithmeticError where one is not a finite number.
    """
    cubes = cube_root(theta_o, found) - cube_root(theta_o, truth)
    known = {"rmse": float(np.sqrt(np.mean((found - truth) ** 2))),
             "cube_root_rmse": float(np.sqrt(np.mean(cubes ** 2))), "cube_root_mae": float(np.abs(cubes).mean())}
    if not np.isfinite([*known.values()]).all():
        raise ArithmeticError(f"not a finite number, {place}")
    return {f"{place}_{kind}": known[kind] for kind in kinds}


def attempted(measure, unknown):
    """The row that `measure` returns, with seconds of the processor unless it has some.

    Where it fails, the keys `unknown` are None and "failed" says why: a long run goes on, and tells.
    """
    start = time.process_time()
    try:
        row = measure()
    except Exception as error:
        row = dict.fromkeys(unknown) | {"failed": repr(error)}
    return {"seconds": time.process_time() - start} | row


def are_judged(samples):
    """Which samples are not beyond STEEPEST: (n,) bool."""
    return np.maximum(samples.theta_i, samples.theta_o) < np.radians(STEEPEST) + 1e-4


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
