"""Many things judged by several processes; an interrupted run can be continued.

Each finished thing is a line of `progress.jsonl` in the folder, and all of them at last are `results.json`. Every line
says which code made it, by a digest of the sources that its numbers depend on: a run that continues takes over no line
of other code.
"""

import hashlib
import json
import multiprocessing
import platform
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from fitter.files import replacing
from support.checkout import ROOT

# what the errors of all benches depend on
_SOURCES = ("fitter/*.py", *(f"fitter/{name}/**/*.py" for name in (
    "coordinates", "formats", "lattice", "methods", "model", "quality")),
    "benchmarks/report/baselines/*.py", "benchmarks/report/methods.py", "benchmarks/harness/judging.py")
_NO_SOURCES = {"fitter/cli.py"}


@dataclass(frozen=True)
class Bench:
    """Things that are judged alike, and what is written of it.

    Attributes
    ----------
    name, things : str
        Of its package, its folder in `build` and its page; and of what it judges, in results.json: "sets".
    title, about : str
        The heading of its page and of its part of the report, and what that says of it.
    judge, is_whole : callable
        Of a thing and a folder: its record, with a name, and files beside; of a record and a folder: whether it is of
        this run, and its files are there. Other processes can import them.
    rows, error : str
        The entry of a record that has a row for each model, and the error that is told of each row.
    text, outcome : callable
        Of the results and the names of pictures: the page without a heading; of the results: what matters most.
    draw : callable
        Of the results, their folder and one to draw into (the same by default): the names of pictures; none without
        matplotlib.
    sources : tuple of str
        Paths of the files that the numbers depend on, beside the fitter's.
    facts : dict
        More entries of results.json.
    """

    name: str
    things: str
    title: str
    about: str
    judge: Callable
    is_whole: Callable
    rows: str
    error: str
    text: Callable
    outcome: Callable
    draw: Callable
    sources: tuple[str, ...]
    facts: dict = field(default_factory=dict)

    @property
    def folder(self):
        """Where it writes by default."""
        return ROOT / "build" / self.name


def run(bench, things, out, jobs=1, resume=False, left_out=(), progress=print):
    """Judge things, which have names, and write `results.json` to a folder.

    Parameters
    ----------
    jobs : int
        Processes among which the things are divided.
    resume : bool
        Take over what an earlier, interrupted run in this folder has finished with the same code.
    left_out : sequence of str
        Why some are not there, for the record.
    progress : callable
        Told what is finished, in words.

    Returns
    -------
    dict
        The contents of results.json: commit, code, machine, seconds (of processors, over all things), the `facts` of
        the bench, left_out, and under the name of its `things` their records, in the order of `things`.
    """
    code = digest(bench)
    out.mkdir(parents=True, exist_ok=True)
    lines = out / "progress.jsonl"
    finished = {record["name"]: record for record in recorded(lines)
                if resume and record["code"] == code and bench.is_whole(record, out)}
    with replacing(lines, "w") as stream:
        stream.writelines(json.dumps(record) + "\n" for record in finished.values())
    wanted = [each for each in things if each.name not in finished]
    before, start = len(things) - len(wanted), time.perf_counter()
    if before:
        progress(f"{before} of {len(things)} {bench.things} were finished before")
    with open(lines, "a", encoding="utf-8") as stream:
        for number, record in enumerate(each_of(partial(_judged, bench.judge, out, code), wanted, jobs), start=1):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            finished[record["name"]] = record
            left = (time.perf_counter() - start) / number * (len(wanted) - number)
            progress(f"[{before + number}/{len(things)}] {record['name']}: {_told(record[bench.rows], bench.error)}; "
                     f"{record['seconds']:.0f} s, {left:.0f} s to go")
    records = [finished[each.name] for each in things]
    results = {"commit": commit(), "code": code, "seconds": sum(record["seconds"] for record in records),
               "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
               **bench.facts, "left_out": list(left_out), bench.things: records}
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    return results


def named(things, names):
    """Those whose names contain one of the names; all of them without names."""
    return [each for each in things if not names or any(name.lower() in each.name.lower() for name in names)]


def digest(bench):
    """A digest of the sources that the numbers of a bench depend on."""
    names = {path.relative_to(ROOT).as_posix() for pattern in (*_SOURCES, *bench.sources)
             for path in ROOT.glob(pattern)}
    found = hashlib.sha256()
    for name in sorted(names - _NO_SOURCES):
        found.update(name.encode() + b"\0" + (ROOT / name).read_bytes() + b"\0")
    return found.hexdigest()[:16]


def commit():
    """The commit of the checkout, with "-dirty" where it was changed since; "unknown" without git."""
    try:
        return subprocess.run(["git", "describe", "--always", "--dirty", "--exclude=*"], cwd=ROOT, check=True,
                              capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


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


def _judged(judge, out, code, thing):
    start = time.process_time()
    record = judge(thing, out)
    return record | {"seconds": time.process_time() - start, "code": code}


def _told(rows, error):
    return ", ".join(f"{name} " + ("failed" if "failed" in row else f"{row[error]:.3g}")
                     for name, row in rows.items() if "failed" in row or row[error] is not None)
