"""Many things judged by several processes; an interrupted run can be continued.

Each finished thing is a line of `progress.jsonl` in the folder, and all of them at last are `results.json`. Every line
says which code made it, by the digest of the files that its numbers depend on: a run that continues takes over no line
of other code.
"""

import argparse
import json
import math
import multiprocessing
import os
import platform
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from fitter.storage.files import replace_file
from support.checkout import ROOT
from support.evidence import FITS, digest

_MEASURED = (*FITS, "benchmarks/report/baselines", "benchmarks/report/methods.py", "benchmarks/harness/judging.py")


@dataclass(frozen=True)
class Bench:
    """Things that are judged alike, and what is shown of it. Other processes can import the functions."""

    name: str                   # of its package and its folder in `build`
    things: str                 # of what it judges, in results.json: "sets"
    judge: Callable             # of a thing and a folder: its record, with a name, once its files are there
    rows: str                   # the entry of a record that has a row for each model
    error: str                  # the error that is told of each row
    show: Callable              # of the results: prints the tables
    draw: Callable              # of the results and their folder: draws pictures into it
    measured: tuple[str, ...]   # files and folders that the numbers depend on, beside the fitter's


def parser(bench, description):
    found = argparse.ArgumentParser(prog=f"python -m benchmarks.{bench.name}", description=description.splitlines()[0])
    found.add_argument(f"--{bench.things}", nargs="+", default=(), metavar="NAME", dest="names",
                       help="only those whose names contain one of these; all by default")
    found.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes, default: %(default)s")
    found.add_argument("--resume", action="store_true", help="go on with an interrupted run of the same code")
    found.add_argument("--out", type=Path, default=ROOT / "build" / bench.name, help="folder, default: %(default)s")
    return found


def main(bench, things, left_out, options):
    """Judge things, which have names, write `results.json` to a folder, and print the tables.

    It holds code, machine, seconds (of processors, over all things), and under the name of its `things` their records,
    in their order. What was left out, and how far it is, goes to standard error.
    """
    for reason in left_out:
        print(f"left out: {reason}", file=sys.stderr)
    if not things:
        sys.exit(f"no {bench.things} of these names are at hand")
    out, code = options.out, digest((*_MEASURED, *bench.measured))
    out.mkdir(parents=True, exist_ok=True)
    lines = out / "progress.jsonl"
    finished = {record["name"]: record for record in recorded(lines)
                if options.resume and record["code"] == code}
    with replace_file(lines, "w") as stream:
        stream.writelines(json.dumps(record) + "\n" for record in finished.values())
    wanted = [each for each in things if each.name not in finished]
    before, start = len(things) - len(wanted), time.perf_counter()
    with open(lines, "a", encoding="utf-8") as stream:
        made = each_of(partial(_judged, bench.judge, out, code), wanted, options.jobs)
        for number, record in enumerate(made, start=1):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            finished[record["name"]] = record
            left = (time.perf_counter() - start) / number * (len(wanted) - number)
            told = ", ".join(f"{name} " + ("failed" if "failed" in row else f"{row[bench.error]:.3g}")
                             for name, row in record[bench.rows].items()
                             if "failed" in row or row[bench.error] is not None)
            print(f"[{before + number}/{len(things)}] {record['name']}: {told}; {record['seconds']:.0f} s, "
                  f"{left:.0f} s to go", file=sys.stderr, flush=True)
    records = [finished[each.name] for each in things]
    results = {"code": code, "seconds": sum(record["seconds"] for record in records),
               "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
               bench.things: records}
    with replace_file(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    bench.draw(results, out)
    bench.show(results)
    print(f"{out}/results.json, in {results['seconds']:.0f} s of processors", file=sys.stderr)


def named(things, names):
    return [each for each in things if not names or any(name.lower() in each.name.lower() for name in names)]


def recorded(path):
    """The records in a file of JSON lines, if it is there. An interrupted run may have left the last incomplete."""
    for line in path.read_text("utf-8").splitlines() if path.is_file() else ():
        try:
            yield json.loads(line)
        except json.JSONDecodeError:
            continue


def each_of(work, things, jobs):
    """The results of the work on each thing, as they come. Processes are spawned: Blender's threads survive no fork."""
    if jobs == 1:
        yield from map(work, things)
        return
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        waiting = [pool.submit(work, each) for each in things]
        try:
            for future in as_completed(waiting):
                yield future.result()
        finally:
            for future in waiting:
                future.cancel()


def ratio(rows, own, rivals, error):
    """The error of one model over the least of its rivals': at most 1 where it is best.

    Infinite where it failed, and not a number where the error of no rival is known.

    Examples
    --------
    >>> rows = {name: {"rmse": error} for name, error in (("Standard", 0.3), ("a", 0.2), ("b", 0.4))}
    >>> round(ratio(rows, "Standard", ("a", "b", "c"), "rmse"), 3)
    1.5
    """
    known = [rows[name][error] for name in rivals if name in rows and rows[name][error] is not None]
    if own not in rows or not known:
        return math.nan
    ours, least = rows[own][error], min(known)
    if ours is None:
        return math.inf
    return ours / least if least else (math.inf if ours else 1.0)


def _judged(judge, out, code, thing):
    start = time.process_time()
    record = judge(thing, out)
    return record | {"seconds": time.process_time() - start, "code": code}
