"""Evaluation times in NumPy: the paper's Figure 2."""

import time
from collections.abc import Callable, Mapping
from functools import partial

from fitter.model import Reflectance
from fitter.model.fit import notation
from fitter.quality.physics import direction_pairs
from fitter.samples import Samples

from .methods import BASELINES, METHODS, levels
from .rows import MakeModel, Row

CALLS = 100_000
REPEATS = 9
LEVELS = range(3, 8)
SPARSE = ((4, 5, 95), (4, 6, 95), (4, 7, 95))
METHODS_TIMED: dict[str, MakeModel] = (
    {notation(level): levels(level) for level in LEVELS} | {notation(*choice): levels(*choice) for choice in SPARSE}
    | {name: METHODS[name] for name in ("Standard", *BASELINES)})


def table(samples: Samples) -> list[Row]:
    """Nanoseconds of one evaluation by each method.

    A method evaluates an array of `CALLS` pairs of directions. The methods take turns; the least time of each counts.
    """
    models: dict[str, Reflectance] = {name: make(samples) for name, make in METHODS_TIMED.items()}
    pairs = direction_pairs(CALLS)
    found = interleaved({name: partial(model.evaluate, *pairs) for name, model in models.items()}, REPEATS)
    return [{"method": name, "nanoseconds": 1e9 * seconds / CALLS} for name, seconds in found.items()]


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
