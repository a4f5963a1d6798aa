"""``make report``: the paper's claims and methods side by side, on all measurements at hand or on those that are named.

python -m benchmarks.report [FILE...] [--out build/report]

Writes `results.json`, `results.md` and pictures, and prints the tables. The rendered picture needs Blender.
"""

import argparse
import contextlib
import io
import json
import multiprocessing
import operator
import os
import platform
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import chain
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"    # before NumPy starts them: a process for each core has the materials

import numpy as np

from fitter import DatasetError
from fitter.cli import show_progress
from fitter.formats import list_samples, load
from fitter.storage.files import replace_file
from support import checkout

from . import figures, markdown, plots, tables

LEVELS = range(8)
BILEVEL = ((1, 6, 90), (3, 6, 90), (4, 6, 95), (4, 6, 99))
FEATURED = ("felt", "leather", "aluminum foil", "Krylon Blue", "Garnet Red", "Cayman Metallic")
_FEATURED_ELSE = 4          # number of materials to feature if none of these is there
_CLAIMED = 4, 6             # levels of which the paper claims something for every material


def measured(paths):
    """All materials in files: every sample of a CURET file, and the only one of each other file."""
    for path in paths:
        for number in [number for number, _ in list_samples(path)] or [None]:
            yield load(path, number)


def featured(samples):
    """The materials of the plots and the main tables; of several with one name, the first."""
    by_name = {}
    for each in samples:
        by_name.setdefault(each.name, each)
    return [by_name[name] for name in FEATURED if name in by_name] or list(by_name.values())[:_FEATURED_ELSE]


def write(paths, out):
    """Write `results.json`, `results.md` and the plots to a folder, and return what is in the first.

    A file that cannot be read is a `DatasetError`, and nothing is written then.
    """
    samples = list(measured(paths))
    shown = featured(samples)
    results: tables.Results = {
        "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
        "levels": list(LEVELS), "featured": [[of.name, of.source] for of in shown]}
    tasks = [partial(tables.errors, of, *((LEVELS, BILEVEL) if any(of is each for each in shown) else (_CLAIMED, ())))
             for of in samples]
    tasks += [partial(tables.compare, of) for of in samples]
    rows = []
    with ProcessPoolExecutor(mp_context=multiprocessing.get_context("spawn")) as pool:   # Blender's threads fork badly
        for found in pool.map(operator.call, tasks):
            show_progress(len(rows), len(tasks), found[0]["material"])
            rows.append(found)
    show_progress(len(tasks), len(tasks), "")
    results["errors"], results["comparison"] = (
        list(chain.from_iterable(found)) for found in (rows[:len(samples)], rows[len(samples):]))
    results["claims"] = tables.claims(results["errors"])
    results["storage"] = tables.storage(samples[0])
    results["times"] = {"material": shown[0].name, "calls": tables.CALLS, "rows": tables.times(shown[0])}
    out.mkdir(parents=True, exist_ok=True)
    plots.draw(results, out)
    results["renders"] = figures.undetectable(shown[min(3, len(shown) - 1)], out)
    with replace_file(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    told = io.StringIO()
    with contextlib.redirect_stdout(told):
        markdown.show(results)
    with replace_file(out / "results.md", "w") as stream:
        stream.write(f"# Results\n\n{results['machine']}\n\n{told.getvalue()}")
    return results


def at_hand():
    folder = checkout.measurements()
    paths = folder / "curet" / "abrdf.dat", *sorted((folder / "cornell").glob("*"))
    return [path for path in paths if path.is_file()]


def main():
    parser = argparse.ArgumentParser(prog="python -m benchmarks.report", description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", metavar="FILE", help="measurements; all samples of a CURET file")
    parser.add_argument("--out", type=Path, default="build/report", help="folder to write, default: %(default)s")
    options = parser.parse_args()
    files = options.files or at_hand()
    if not files:
        sys.exit(f"no measurements in {checkout.measurements()}; set MEASURED_BRDF_DATA")
    start = time.perf_counter()
    try:
        results = write(files, options.out)
    except DatasetError as error:
        sys.exit(f"error: {error}")
    markdown.show(results)
    print(f"{options.out}/results.json, in {time.perf_counter() - start:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    checkout.extension().register()
    main()
