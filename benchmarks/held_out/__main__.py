"""``make held-out``: judge sets, print the shares, and write `results.json` and a picture to a folder."""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the sets

from ..harness import running
from ..report.methods import METHODS
from . import judging, pictures, sets, summary


def _judged(found, out):
    """The record of a set. A telling one's spheres are written beside."""
    record, models = judging.judge(found, tuple(METHODS))
    if found.name in pictures.TELLING:
        pictures.write(found, models, out)
    return record


def _is_whole(record, out):
    return record["name"] not in pictures.TELLING or pictures.path(out, record["name"]).is_file()


BENCH = running.Bench("held_out", "sets", _judged, _is_whole, "methods", "held_out_cube_root_rmse", summary.show,
                      pictures.draw, ("support/truths.py", "benchmarks/held_out"))


def main(arguments=None):
    """Judge the sets that the command names."""
    parser = running.parser(BENCH, __doc__)
    parser.add_argument("--half", choices=(*sets.HALVES, "all"), default="judged", help="default: %(default)s")
    options = parser.parse_args(arguments)
    running.main(BENCH, *sets.at_hand(options.half, options.names), options)


if __name__ == "__main__":
    main()
