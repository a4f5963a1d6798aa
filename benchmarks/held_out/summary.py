"""The results in tables: how often Standard predicts best, and by how much it loses where it does not."""

import math

from support.evidence import show as show_text
from support.evidence import show_table

from ..harness.running import Bench, ratio
from . import judging, pictures
from .pictures import OWN
from .sets import FAMILIES, HALVES

NEAR = 1.1                  # times the best of all methods
_PLACES = "held_out", "truth"
_WORST = 5                  # ratios to tell


def shares(records, place="held_out"):
    """Of how many of the sets Standard is best, by the records of `judging.judge`; None where no set has a truth.

    sets, and of them: smallest_cube_root, the share in which Standard has the smallest error by the cube root;
    near_cube_root, that in which it is at most NEAR times the best; smallest_rmse; worst, the sets in which Standard is
    behind by the cube root and its ratio to the best, (name, ratio), the worst first; and largest_bytes, of Standard a
    channel.
    """
    ratios = {error: {record["name"]: found for record in records if not math.isnan(found := ratio(
        record["methods"], OWN, record["methods"].keys() - {OWN}, f"{place}_{error}"))}
              for error in ("rmse", "cube_root_rmse")}
    count = len(ratios["rmse"])
    if not count:
        return None

    def share(error, limit):
        return sum(found <= limit for found in ratios[error].values()) / count

    behind = [(name, found) for name, found in ratios["cube_root_rmse"].items() if found > 1]
    return {"sets": count, "smallest_cube_root": share("cube_root_rmse", 1),
            "near_cube_root": share("cube_root_rmse", NEAR), "smallest_rmse": share("rmse", 1),
            "worst": sorted(behind, key=lambda each: -each[1]),
            "largest_bytes": max(bytes_per_channel(record) or 0 for record in records
                                 if record["name"] in ratios["rmse"])}


def bytes_per_channel(record):
    """Bytes of Standard for each channel that it stores; None where it failed."""
    total = record["methods"][OWN]["bytes"]
    return None if total is None else total / record["channels"]


def show(results):
    for place in _PLACES:
        rows = []
        for half, family, records in _groups(results["sets"]):
            if found := shares(records, place):
                rows.append((half, family, found["sets"], *(_percent(found[key]) for key in (
                    "smallest_cube_root", "near_cube_root", "smallest_rmse")), round(found["largest_bytes"]),
                    _worst(found["worst"])))
        if rows:
            show_table(f"held-out-{place.replace('_', '-')}", (
                "half", "family", "sets", "smallest, cube root", f"within {NEAR} of the best", "smallest, RMSE",
                "most bytes a channel", "behind by the cube root, times the best"), rows)
    judged = shares([record for record in results["sets"] if record["half"] == "judged"])
    if judged:
        show_text("held-out-share", f"in {_percent(judged['smallest_cube_root'])} of {judged['sets']} sets; within "
                                    f"{NEAR} of the best in {_percent(judged['near_cube_root'])}")


def _groups(records):
    """(half, family, records) for each of both, and for the families of a half together, "all"."""
    for half in HALVES:
        of_half = [record for record in records if record["half"] == half]
        for family in (*FAMILIES, "all"):
            found = [record for record in of_half if family in ("all", record["family"])]
            if found:
                yield half, family, found


def _worst(behind):
    told = ", ".join(f"{name} {'failed' if math.isinf(found) else f'{found:#.3g}'}" for name, found in behind[:_WORST])
    rest = len(behind) - _WORST
    return (told or "nowhere") + (f", and {rest} more" if rest > 0 else "")


def _percent(share):
    return f"{100 * share:.0f} %"


# here, and not in `__main__`, for worker processes import it
BENCH = Bench("held_out", "sets", judging.judge, "methods", "held_out_cube_root_rmse", show, pictures.draw,
              ("support/truths.py", "benchmarks/held_out"))
