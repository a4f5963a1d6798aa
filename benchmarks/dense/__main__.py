"""Judge dense measurements: print what holds, and write `results.json` and a picture to a folder.

python -m benchmarks.dense [--materials NAME...] [--jobs N] [--resume] [--out FOLDER]
"""

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

from ..harness import running
from . import materials
from .summary import BENCH


def main():
    options = running.parser(BENCH, __doc__).parse_args()
    running.main(BENCH, *materials.at_hand(options.names), options)


if __name__ == "__main__":
    main()
