"""What the steps of an import cost: processor seconds on one core, of the preset Standard.

``python -m benchmarks.imports [FILE ...]`` takes two Cornell files and two of RGL by default, and the fewest seconds of
several runs of each. ``--vs CHECKOUT`` alternates with another checkout of the repository and prints the ratios of its
seconds to those of this one.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from functools import wraps
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them

import fitter
from fitter.cycles import node_mixture
from fitter.methods import energy, gaussian_process, lattices, prior

FILES = ("cornell/krylon_blue_RGB.astm", "cornell/garnet_red_RGB.astm", "cornell/cayman.astm", "rgl/chm_mint_rgb.bsdf")
RUNS = 5
STEPS = {"prior": [(prior, "candidates")], "search": [(gaussian_process.Search, "maximise"), (lattices, "likelihoods")],
         "lattices": [(lattices, "fit_to_field"), (lattices, "fit_to_samples")],
         "energy": [(energy, "conserve_energy")], "closures": [(node_mixture, "node_mixtures")]}


def seconds(path):
    """Processor seconds of each step of an import of a file, and of all but reading it."""
    samples, spent = fitter.load(path), dict.fromkeys(STEPS, 0.0)

    def timed(step, work):
        @wraps(work)
        def again(*args, **options):
            start = time.process_time()
            try:
                return work(*args, **options)
            finally:
                spent[step] += time.process_time() - start
        return again

    originals = [(owner, name, getattr(owner, name), step) for step, places in STEPS.items() for owner, name in places]
    try:
        for owner, name, work, step in originals:
            setattr(owner, name, timed(step, work))
        start = time.process_time()
        node_mixture.node_mixtures(fitter.fit(samples, **fitter.PRESETS["Standard"]))
        return {**spent, "all": time.process_time() - start}
    finally:
        for owner, name, work, _ in originals:
            setattr(owner, name, work)


def seconds_in(checkout, path):
    """`seconds` of a process in a checkout; one that has not this module runs this file."""
    command = [sys.executable, __file__, "--once", path]
    made = subprocess.run(command, cwd=checkout, env={**os.environ, "PYTHONPATH": str(checkout)}, check=True,
                          capture_output=True, text=True)
    return json.loads(made.stdout)


def main():
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--vs", type=Path, metavar="CHECKOUT")
    parser.add_argument("--once", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.once:
        seconds(options.files[0])           # what is made once for all files
        print(json.dumps(seconds(options.files[0])))
        return
    from support import synthetic
    from support.checkout import ROOT
    from support.evidence import table

    data = synthetic.measurements_or_synthetic()[0]
    checkouts = [ROOT] if options.vs is None else [ROOT, options.vs.resolve()]
    rows = []
    for path in options.files or [data / name for name in FILES]:
        runs = [[seconds_in(each, path.resolve()) for each in checkouts] for _ in range(RUNS)]
        here, *there = ({step: min(run[number][step] for run in runs) for step in (*STEPS, "all")}
                        for number in range(len(checkouts)))
        rows.append((path.name, *(f"{value:.2f}" for value in here.values())))
        rows.extend((f"times {options.vs}", *(f"{each[step] / max(here[step], 1e-9):.2f}" for step in here))
                    for each in there)
    print(table(("processor seconds", *STEPS, "all"), rows))


if __name__ == "__main__":
    main()
