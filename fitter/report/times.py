"""Evaluation times in NumPy: the paper's Figure 2."""

import time

import numpy as np

from ..coordinates.nusselt import nusselt
from ..lattice import dense
from ..model.fit import notation
from ..quality.physics import direction_pairs
from .methods import BASELINES, METHODS, levels

CALLS = 100_000
REPEATS = 9
LEVELS = range(3, 8)
SPARSE = ((4, 5, 95), (4, 6, 95), (4, 7, 95))
METHODS_TIMED = {notation(*choice): levels(*choice) for choice in (*((level,) for level in LEVELS), *SPARSE)} | {
    name: METHODS[name] for name in ("Standard", *BASELINES)}


class NdBSpline:
    """A plain MBA fit, evaluated by SciPy's tensor-product spline on the same lattice."""

    def __init__(self, fit):
        from scipy.interpolate import NdBSpline

        first, counts = dense.origin(fit.diffuse_level), dense.shape(fit.diffuse_level)
        # control point j is the B-spline over the knots j - 2 to j + 2, counted in cells
        knots = tuple(start - 2.0 + np.arange(count + 4) for start, count in zip(first, counts, strict=True))
        self.cells = dense.cells(fit.diffuse_level)
        self.spline = NdBSpline(knots, fit.diffuse.control_points[..., list(fit.columns)].astype(float), 3)

    def evaluate(self, theta_i, phi_i, theta_o, phi_o):
        """The BRDF, 1/sr: angles (n,) in radians to (n, channels) float64."""
        return self.spline(nusselt(theta_i, phi_i, theta_o, phi_o) * self.cells)


def table(samples, calls=CALLS, repeats=REPEATS):
    """Nanoseconds a call of each method: a list of dict, the level-6 fit by SciPy among them.

    A call is one pair of directions of an array of `calls`. The methods take turns, and each figure is the least.
    """
    models = {name: make(samples) for name, make in METHODS_TIMED.items()}
    models["level 6 by SciPy's NdBSpline"] = NdBSpline(models["level 6"])
    pairs = direction_pairs(calls)
    found = interleaved({name: lambda model=model: model.evaluate(*pairs) for name, model in models.items()}, repeats)
    return [{"method": name, "nanoseconds": 1e9 * seconds / calls} for name, seconds in found.items()]


def interleaved(work, repeats):
    """Least processor seconds of each of some functions, called in turn, after one call each that is not counted.

    What else the machine does can only add to a time, so that the least is the nearest to the function's own.
    """
    seconds = {name: [] for name in work}
    for turn in range(repeats + 1):
        for name, run in work.items():
            start = time.process_time()
            run()
            if turn:
                seconds[name].append(time.process_time() - start)
    return {name: min(times) for name, times in seconds.items()}


def spread(rows, names):
    """The slowest of some methods over the fastest, less one; None where fewer than two are there."""
    times = [row["nanoseconds"] for row in rows if row["method"] in names]
    return max(times) / min(times) - 1 if len(times) > 1 else None
