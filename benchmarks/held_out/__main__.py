"""``make held-out``: judge sets, print the shares, and write `held_out.md`, `results.json` and pictures to a folder."""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the sets

from ..harness import command
from . import sets
from .bench import BENCH


def main(arguments=None):
    """Judge the sets that the command names."""
    parser = command.parser(BENCH, __doc__)
    parser.add_argument("--half", choices=(*sets.HALVES, "all"), default="judged", help="default: %(default)s")
    options = parser.parse_args(arguments)
    command.judge(BENCH, *sets.at_hand(options.half, options.names), options)


if __name__ == "__main__":
    main()
