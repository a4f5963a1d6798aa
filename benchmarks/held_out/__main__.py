"""``make held-out``: judge sets, print the shares, and write `results.json` and a picture to a folder."""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the sets

from ..harness import running
from . import sets
from .summary import BENCH


def main():
    parser = running.parser(BENCH, __doc__)
    parser.add_argument("--half", choices=(*sets.HALVES, "all"), default="judged", help="default: %(default)s")
    options = parser.parse_args()
    running.main(BENCH, *sets.at_hand(options.half, options.names), options)


if __name__ == "__main__":
    main()
