"""``make dense``: judge dense measurements, print what holds, and write `dense.md`, `results.json` and a picture."""

import argparse
import os
import sys
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

from fitter.files import replacing

from . import materials, run, sheet, summary
from .supplement import FOLDER


def main(arguments=None):
    """Judge the materials that the command names."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.dense", description=__doc__.splitlines()[0])
    parser.add_argument("--materials", nargs="+", default=(), metavar="NAME",
                        help="only those whose names contain one of these; all by default")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes, default: %(default)s")
    parser.add_argument("--resume", action="store_true", help="go on with an interrupted run of the same code")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder to write, default: %(default)s")
    options = parser.parse_args(arguments)
    found, left_out = materials.at_hand(options.materials)
    for reason in left_out:
        print(f"left out: {reason}")
    if not found:
        sys.exit("no material of these names is at hand")
    results = run.run(found, options.out, options.jobs, options.resume, left_out,
                      lambda line: print(line, flush=True))
    with replacing(options.out / "dense.md", "w") as stream:
        stream.write(f"# Dense measurements\n\nCommit {results['commit']}.\n\n"
                     + summary.text(results, sheet.draw(results, options.out)))
    records = results["materials"]
    print(f"\n{summary.all_rows(records)}\n{summary.medians(records)}\n{summary.wishes_text(records)}\n"
          f"{options.out}/dense.md, in {results['seconds']:.0f} s of processors")


if __name__ == "__main__":
    main()
