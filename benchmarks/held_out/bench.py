"""The bench of the sets. Worker processes import it: they cannot import what stands in `__main__`."""

from ..harness import running
from . import judging, pictures, summary


def _judged(found, out):
    """The record of a set. A telling one's spheres are written beside."""
    record, models = judging.judge(found)
    if found.name in pictures.TELLING:
        pictures.write(found, models, out)
    return record


def _is_whole(record, out):
    return record["name"] not in pictures.TELLING or pictures.path(out, record["name"]).is_file()


BENCH = running.Bench("held_out", "sets", _judged, _is_whole, "methods", "held_out_cube_root_rmse", summary.show,
                      pictures.draw, ("support/truths.py", "benchmarks/held_out"))
