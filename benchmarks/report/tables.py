"""The numbers of the report, as lists of dictionaries."""

import math
from collections.abc import Sequence
from dataclasses import replace

from fitter import fit
from fitter.model.fit import notation
from fitter.quality.metrics import error_metrics
from fitter.samples import Samples

from .methods import BASELINES, METHODS, levels
from .rows import Row

Choice = tuple[int, int, float]
"""(D, S, C)"""

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
