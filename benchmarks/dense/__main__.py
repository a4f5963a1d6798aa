"""``make dense``: judge dense measurements, print what holds, and write `dense.md`, `results.json` and a picture."""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

from ..harness import command
from . import materials
from .bench import BENCH


def main(arguments=None):
    """Judge the materials that the command names."""
    options = command.parser(BENCH, __doc__).parse_args(arguments)
    command.judge(BENCH, *materials.at_hand(options.names), options)


if __name__ == "__main__":
    main()
