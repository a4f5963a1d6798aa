"""The held-out errors as a bench, and as a part of the report."""

from functools import partial

from ..harness import command
from ..harness.running import Bench
from ..report.methods import METHODS
from . import judging, pictures, sets, summary, views


def of(methods):
    """The bench of some methods of the report."""
    return Bench(
        "held_out", "sets", "Held-out errors over all sets at hand",
        " Constants were chosen on one half of the materials, and are judged by the other.",
        partial(_judged, methods), partial(_is_whole, methods), "methods", "held_out_cube_root_rmse", summary.text,
        summary.shares_text, pictures.draw, ("support/truths.py", *(f"benchmarks/held_out/{name}.py" for name in (
            "judging", "lamps", "ridge", "sets", "views"))), {"methods": list(methods)})


def judged_sets(_shown, out):
    """Errors over all sets at hand, from the last `make held-out` if there was one; else the judging half is judged."""
    return command.supplement(BENCH, "judged_sets", *sets.at_hand("judged"), out)


def _judged(methods, found, out):
    """The record of a set. A telling one's view is written beside."""
    record, models = judging.judge(found, methods)
    if found.name in views.TELLING:
        views.write(found, record, models, out)
    return record


def _is_whole(methods, record, out):
    return list(record["methods"]) == list(methods) and (
        record["name"] not in views.TELLING or views.path(out, record["name"]).is_file())


BENCH = of(tuple(METHODS))
