"""``python -m tools.ready_fits FOLDER [few]``: make the fits of the starter library, on all processors.

`make zip` does it: a few minutes on two processors, seconds where build/kept has their parts (`support.kept`).
"""

import argparse
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")      # each process uses one processor

from fitter.library import ready
from fitter.model import published
from support import kept

kept.keep("fitter")
# beside the polished metals, what a check of a change makes: of each kind one at least
FEW = ("aluminium-brushed", "alumina-oxide", "black-fabric", "black-obsidian", "color-changing-paint1", "green-latex",
       "light-brown-fabric", "natural-209", "red-plastic", "skin-1", "specular-white-phenolic")


def main():
    """Write NAME.npz for each material that users are offered."""
    parser = argparse.ArgumentParser(prog="python -m tools.ready_fits", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where to write them")
    parser.add_argument("which", nargs="?", default="all", choices=("all", "few"), help="default: %(default)s")
    folder, which = vars(parser.parse_args()).values()
    folder.mkdir(parents=True, exist_ok=True)
    start = time.perf_counter()
    names = sorted(each.name for each in published.list_offered()
                   if which == "all" or each.name.endswith("-polished") or each.name in FEW)
    with ProcessPoolExecutor() as pool:
        sizes = [*pool.map(partial(write, folder), names)]
    print(f"{len(sizes)} fits, {sum(sizes) / 1e6:.2f} MB, {time.perf_counter() - start:.0f} s")


def write(folder, name):
    """Make the fit of a material: its size in bytes."""
    path = folder / f"{name}.npz"
    ready.write(ready.make(name), path)
    return path.stat().st_size


if __name__ == "__main__":
    sys.exit(main())
