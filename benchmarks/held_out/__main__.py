"""``make held-out``: judge sets, print the shares, and write `held_out.md`, `results.json` and pictures to a folder."""

import argparse
import os
import sys
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the sets

from fitter.files import replacing
from fitter.report.methods import METHODS

from . import pictures, run, sets, summary
from .supplement import FOLDER


def main(arguments=None):
    """Judge the sets that the command names."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.held_out", description=__doc__.splitlines()[0])
    parser.add_argument("--sets", nargs="+", default=(), metavar="NAME",
                        help="only those whose names contain one of these; all by default")
    parser.add_argument("--half", choices=(*sets.HALVES, "all"), default="judged", help="default: %(default)s")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes, default: %(default)s")
    parser.add_argument("--resume", action="store_true", help="go on with an interrupted run of the same code")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write, default: %(default)s")
    options = parser.parse_args(arguments)
    found, left_out = sets.at_hand(options.half)
    found = sets.named(found, options.sets)
    for reason in left_out:
        print(f"left out: {reason}")
    if not found:
        sys.exit("no set of these names is at hand")
    results = run.run(found, list(METHODS), options.out, options.jobs, options.resume, left_out,
                      lambda line: print(line, flush=True))
    drawn = pictures.draw(results, options.out)
    with replacing(options.out / "held_out.md", "w") as stream:
        stream.write(f"# Held-out errors over all sets at hand\n\nCommit {results['commit']}.\n\n"
                     + summary.text(results, drawn))
    print(f"\n{summary.shares_text(results)}\n{options.out}/held_out.md, in {results['seconds']:.0f} s")


if __name__ == "__main__":
    main()
