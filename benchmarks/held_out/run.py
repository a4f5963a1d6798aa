"""Many sets judged by several processes; an interrupted run can be continued.

Each finished set is a line of `progress.jsonl` in the folder, and all of them at last are `results.json`. Every line
says which code made it, by a digest of the sources that its numbers depend on: a run that continues takes over no line
of other code.
"""

import hashlib
import json
import multiprocessing
import platform
import subprocess
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import partial

import numpy as np

from fitter.files import replacing
from support.checkout import ROOT

from . import judging, views

# what the errors depend on
_SOURCES = ("fitter/*.py", *(f"fitter/{name}/**/*.py" for name in (
    "coordinates", "formats", "lattice", "methods", "model", "quality", "report/baselines")),
    "fitter/report/methods.py", "support/truths.py", "benchmarks/held_out/*.py")
# and of these, what they do not depend on
_NO_SOURCES = {"fitter/cli.py", *(f"benchmarks/held_out/{name}.py" for name in (
    "__init__", "__main__", "pictures", "run", "summary", "supplement"))}


def run(sets, methods, out, jobs=1, resume=False, left_out=(), progress=print):
    """Judge sets, and write `results.json` to a folder.

    Parameters
    ----------
    sets : sequence of JudgedSet
    methods : sequence of str
        Names in the report's METHODS.
    out : Path
        It is created if necessary.
    jobs : int
        Processes among which the sets are divided.
    resume : bool
        Take over what an earlier, interrupted run in this folder has finished with the same code and methods.
    left_out : sequence of str
        Why some sets are not there, for the record.
    progress : callable
        Told what is finished, in words.

    Returns
    -------
    dict
        The contents of results.json: commit, code, machine, seconds, methods, left_out and sets, the records of
        `judging.judge` in the order of `sets`.
    """
    start, code = time.perf_counter(), digest()
    out.mkdir(parents=True, exist_ok=True)
    lines = out / "progress.jsonl"
    finished = _finished(lines, code, methods, out) if resume else {}
    with replacing(lines, "w") as stream:
        stream.writelines(json.dumps(record) + "\n" for record in finished.values())
    wanted = [each for each in sets if each.name not in finished]
    if len(wanted) < len(sets):
        progress(f"{len(sets) - len(wanted)} of {len(sets)} sets were finished before")
    with open(lines, "a", encoding="utf-8") as stream:
        work = partial(_judged, methods=tuple(methods), out=out, code=code)
        for number, record in enumerate(each_of(work, wanted, jobs), start=1):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            finished[record["name"]] = record
            progress(f"[{len(sets) - len(wanted) + number}/{len(sets)}] {told(record)}")
    results = {"commit": commit(), "code": code, "seconds": time.perf_counter() - start,
               "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
               "methods": list(methods), "left_out": list(left_out), "sets": [finished[each.name] for each in sets]}
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    return results


def told(record):
    """A finished set in a line: its held-out errors by the cube root, and how long it took."""
    found = ", ".join(f"{name} " + ("failed" if "failed" in row else f"{row['held_out_cube_root_rmse']:.3g}")
                      for name, row in record["methods"].items())
    return f"{record['name']}: {found}; {sum(row['seconds'] for row in record['methods'].values()):.0f} s"


def digest(sources=_SOURCES, without=_NO_SOURCES):
    """A digest of the sources that the errors depend on: patterns of paths, and those of them that do not count."""
    names = {path.relative_to(ROOT).as_posix() for pattern in sources for path in ROOT.glob(pattern)} - set(without)
    found = hashlib.sha256()
    for name in sorted(names):
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


def _finished(path, code, methods, out):
    """The records of an earlier run with the same code and methods, by set; without telling sets that lost their view.
    """
    records = {}
    for record in recorded(path):
        viewed = record["name"] not in views.TELLING or views.path(out, record["name"]).is_file()
        if record["code"] == code and list(record["methods"]) == list(methods) and viewed:
            records[record["name"]] = record
    return records


def _judged(found, methods, out, code):
    """The record of a set. A telling one's view is written beside."""
    record, models = judging.judge(found, methods)
    if found.name in views.TELLING:
        views.write(found, record, models, out)
    return record | {"code": code}


def each_of(work, sets, jobs):
    """The results of the work on each set, as they come. Processes are spawned: Blender's threads survive no fork."""
    if jobs == 1:
        yield from map(work, sets)
        return
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        waiting = [pool.submit(work, each) for each in sets]
        try:
            for future in as_completed(waiting):
                yield future.result()
        finally:
            for future in waiting:
                future.cancel()
