"""Evaluation times in NumPy: the paper's Figure 2."""

import time
from collections.abc import Callable, Collection, Mapping
from functools import partial

import numpy as np

from ..arrays import ArrayLike, FloatArray
from ..coordinates.nusselt import nusselt
from ..lattice import dense
from ..model import Reflectance
from ..model.fit import Fit, notation
from ..quality.physics import direction_pairs
from ..samples import Samples
from .methods import BASELINES, METHODS, levels
from .rows import MakeModel, Row

CALLS = 100_000
REPEATS = 9
LEVELS = range(3, 8)
SPARSE = ((4, 5, 95), (4, 6, 95), (4, 7, 95))
METHODS_TIMED: dict[str, MakeModel] = (
    {notation(level): levels(level) for level in LEVELS} | {notation(*choice): levels(*choice) for choice in SPARSE}
    | {name: METHODS[name] for name in ("Standard", *BASELINES)})


class NdBSpline:
    """A fit by plain MBA, evaluated by SciPy's tensor-product spline with the same control points."""

    def __init__(self, fit: Fit) -> None:
        from scipy.interpolate import NdBSpline

        first, counts = dense.origin(fit.diffuse_level), dense.shape(fit.diffuse_level)
        # control point j weights the B-spline over the knots j - 2 to j + 2, in cells
        knots = tuple(start - 2.0 + np.arange(count + 4) for start, count in zip(first, counts, strict=True))
        self.cells = dense.cells(fit.diffuse_level)
        self.spline = NdBSpline(knots, fit.diffuse.control_points[..., list(fit.columns)].astype(float), 3)

    def evaluate(self, theta_i: ArrayLike, phi_i: ArrayLike, theta_o: ArrayLike, phi_o: ArrayLike) -> FloatArray:
        """The BRDF, 1/sr: angles (n,) in radians to (n, channels) float64."""
        return self.spline(nusselt(theta_i, phi_i, theta_o, phi_o) * self.cells)


def table(samples: Samples, calls: int = CALLS, repeats: int = REPEATS) -> list[Row]:
    """Nanoseconds of one evaluation by each method, and of the level-6 fit by SciPy.

    A method evaluates an array of `calls` pairs of directions. The methods take turns; the least time of each counts.
    """
    models: dict[str, Reflectance] = {name: make(samples) for name, make in METHODS_TIMED.items()}
    level_6 = models["level 6"]
    assert isinstance(level_6, Fit)
    models["level 6 by SciPy's NdBSpline"] = NdBSpline(level_6)
    pairs = direction_pairs(calls)
    found = interleaved({name: partial(model.evaluate, *pairs) for name, model in models.items()}, repeats)
    return [{"method": name, "nanoseconds": 1e9 * seconds / calls} for name, seconds in found.items()]


def interleaved(work: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """The least processor time of each function, seconds. They are called in turn; the first call does not count.

    Other work of the machine can only lengthen a time, so that the least is nearest to the function's own.

    Examples
    --------
    >>> calls = []
    >>> seconds = interleaved({"sum": lambda: calls.append(sum(range(10)))}, repeats=3)
    >>> list(seconds), len(calls), seconds["sum"] >= 0
    (['sum'], 4, True)
    """
    seconds: dict[str, list[float]] = {name: [] for name in work}
    for turn in range(repeats + 1):
        for name, run in work.items():
            start = time.process_time()
            run()
            if turn:
                seconds[name].append(time.process_time() - start)
    return {name: min(times) for name, times in seconds.items()}


def spread(rows: list[Row], names: Collection[str]) -> float | None:
    """By what fraction the slowest of some methods takes longer than the fastest; None for fewer than two rows.

    Examples
    --------
    >>> spread([{"method": "a", "nanoseconds": 20}, {"method": "b", "nanoseconds": 25}], {"a", "b"})
    0.25
    """
    times = [row["nanoseconds"] for row in rows if row["method"] in names]
    return max(times) / min(times) - 1 if len(times) > 1 else None
