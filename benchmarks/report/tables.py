"""The numbers of the report, as lists of dictionaries."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from fitter import fit
from fitter.model import Reflectance
from fitter.model.fit import notation
from fitter.quality import cross_validation, physics
from fitter.quality.metrics import error_metrics
from fitter.samples import Samples

from .methods import BASELINES, METHODS, MakeModel, levels

Row = dict[str, Any]
"""A row of a table, by column: numbers and text, as JSON takes them."""
Results = dict[str, Any]
"""What results.json holds: tables, which are lists of rows, and facts about the run."""
Choice = tuple[int, int, float]
"""(D, S, C)"""

CALLS = 100_000             # of each timed evaluation
METHODS_TIMED: dict[str, MakeModel] = (
    {notation(level): levels(level) for level in range(3, 8)}
    | {notation(*choice): levels(*choice) for choice in ((4, 5, 95), (4, 6, 95), (4, 7, 95))}
    | {name: METHODS[name] for name in ("Standard", *BASELINES)})
_REPEATS, _REPEATS_COMPARED = 9, 3

# Kameya and Lewis 2002, Table 1: control points and bytes of a compressed fit of one channel
PAPER_TABLE_1 = {(3, 6, 90): (31_407, 426_647), (3, 6, 95): (16_369, 366_495),
                 (4, 6, 90): (36_935, 448_759), (4, 6, 95): (21_897, 388_607)}


def errors(samples: Samples, plain: Sequence[int], compressed: Sequence[Choice]) -> list[Row]:
    """Errors of plain MBA by level, of compressed fits, and of the two baselines: the paper's Figures 1 and 6.

    Rows of material, source, method, coefficients (of a channel), bytes (of all channels), rmse, mae, mre.
    """
    methods = {notation(level): levels(level) for level in plain}
    methods |= {notation(*choice): levels(*choice) for choice in compressed}
    methods |= {name: METHODS[name] for name in BASELINES}
    rows = []
    for method, make in methods.items():
        model = make(samples)
        found = error_metrics(samples.values, model.evaluate(*samples.directions))
        rows.append({"material": samples.name, "source": samples.source, "method": method,
                     "coefficients": model.coefficient_count, "bytes": model.nbytes, **found._asdict()})
    return rows


def storage(samples: Samples) -> list[Row]:
    """Control points and bytes of one channel, ours and those of the paper's Table 1."""
    grey = replace(samples, values=samples.values[:, :1], channels=("grey",))
    rows = []
    for choice, (coefficients, size) in PAPER_TABLE_1.items():
        found = fit(grey, *choice)
        rows.append({"fit": notation(*choice), "coefficients": found.coefficient_count, "bytes": found.nbytes,
                     "paper_coefficients": coefficients, "paper_bytes": size})
    return rows


def claims(rows: list[Row]) -> list[Row]:
    """Whether the paper's claim of section 3.4 holds, for each material.

    The claim: level 6 is more accurate than both baselines by a factor of at least 4, and level 4 is comparable, taken
    as within a factor of 2 of the better baseline. Of the rows of `errors`: material, source, level_6_factor and
    level_4_factor (RMSE of the better baseline over ours), level_6_holds and level_4_holds; none without these levels.

    Examples
    --------
    >>> rmse = {"level 4": 0.4, "level 6": 0.1, "Koenderink 8": 0.5, "Lafortune 3": 0.6}
    >>> claim, = claims([{"material": "felt", "source": "", "method": name, "rmse": rmse[name]} for name in rmse])
    >>> claim["level_6_factor"], claim["level_6_holds"], claim["level_4_factor"], claim["level_4_holds"]
    (5.0, True, 1.25, True)
    """
    by_material: dict[tuple[str, str], dict[str, float]] = {}
    for row in rows:
        by_material.setdefault((row["material"], row["source"]), {})[row["method"]] = row["rmse"]
    found = []
    for (material, source), rmse in by_material.items():
        if {"level 4", "level 6"} <= rmse.keys():
            best = min(rmse[name] for name in BASELINES)
            fine, coarse = (best / rmse[f"level {level}"] if rmse[f"level {level}"] else math.inf for level in (6, 4))
            found.append({"material": material, "source": source, "level_6_factor": fine, "level_4_factor": coarse,
                          "level_6_holds": fine >= 4, "level_4_holds": coarse >= 0.5})
    return found


def compare(samples: Samples) -> list[Row]:
    """Compare all `METHODS` on samples.

    One row a method: material, source, method, coefficients (of a channel), bytes (of all channels); rmse, mae, mre and
    cube_root_rmse at the samples; held_out_rmse and held_out_cube_root_rmse; reciprocity_error, negative_fraction and
    negative_energy; fit_seconds, and evaluate_microseconds for one pair of directions in NumPy, both in processor time.
    """
    pairs = physics.direction_pairs()
    rows = []
    for name, make in METHODS.items():
        start = time.process_time()
        model = make(samples)
        fitted = time.process_time()
        evaluation, = interleaved({name: partial(model.evaluate, *pairs)}, _REPEATS_COMPARED).values()
        held_out = cross_validation.cross_validate(samples, make)
        rows.append({"material": samples.name, "source": samples.source, "method": name,
                     "coefficients": model.coefficient_count, "bytes": model.nbytes, **at_samples(samples, model),
                     "held_out_rmse": held_out.rmse, "held_out_cube_root_rmse": held_out.cube_root_rmse,
                     **physics.measure(model, pairs)._asdict(), "fit_seconds": fitted - start,
                     "evaluate_microseconds": 1e6 * evaluation / len(pairs[0])})
    return rows


def at_samples(samples: Samples, model: Reflectance) -> Row:
    """Errors at the samples: rmse, mae, mre and cube_root_rmse, the RMSE of the cube root of cosine-weighted values."""
    values = model.evaluate(*samples.directions)
    cubes = [cross_validation.cube_root(samples.theta_o, of) for of in (values, samples.values)]
    return {**error_metrics(samples.values, values)._asdict(),
            "cube_root_rmse": float(np.sqrt(np.mean((cubes[0] - cubes[1]) ** 2)))}


def times(samples: Samples) -> list[Row]:
    """Nanoseconds of one evaluation in NumPy by each method, of an array of `CALLS`: the paper's Figure 2."""
    models: dict[str, Reflectance] = {name: make(samples) for name, make in METHODS_TIMED.items()}
    pairs = physics.direction_pairs(CALLS)
    found = interleaved({name: partial(model.evaluate, *pairs) for name, model in models.items()}, _REPEATS)
    return [{"method": name, "nanoseconds": 1e9 * seconds / CALLS} for name, seconds in found.items()]


def interleaved(work: Mapping[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """The least processor time of each function, seconds. They are called in turn; the first call does not count.

    Other work of the machine can only lengthen a time, so that the least is nearest to the function's own.
    """
    seconds: dict[str, list[float]] = {name: [] for name in work}
    for turn in range(repeats + 1):
        for name, run in work.items():
            start = time.process_time()
            run()
            if turn:
                seconds[name].append(time.process_time() - start)
    return {name: min(times) for name, times in seconds.items()}
