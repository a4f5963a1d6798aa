"""The materials judged one after the other, or by several processes; an interrupted run can be continued.

Each finished material is a line of `progress.jsonl` in the folder, with a digest of the code that made it, and its
pictures an .npz; all of them at last are `results.json`.
"""

import json
import platform
import time
from functools import partial

import numpy as np

from fitter.files import replacing

from ..held_out import run as held_out
from . import judging

# what the numbers depend on
_SOURCES = ("fitter/*.py", *(f"fitter/{name}/**/*.py" for name in (
    "coordinates", "formats", "lattice", "methods", "model", "quality", "report/baselines")),
    "support/merl_files.py", "benchmarks/held_out/judging.py", "benchmarks/dense/*.py")
_NO_SOURCES = {"fitter/cli.py", *(f"benchmarks/dense/{name}.py" for name in (
    "__init__", "__main__", "run", "sheet", "summary", "supplement"))}


def run(materials, out, jobs=1, resume=False, left_out=(), progress=print, judge=judging.judge):
    """Judge materials, and write `results.json` to a folder.

    Parameters
    ----------
    materials : sequence of Material
    out : Path
        It is created if necessary.
    jobs : int
        Processes among which the materials are divided.
    resume : bool
        Take over what an earlier run in this folder has finished with the same code.
    left_out : sequence of str
        Why some are not there, for the record.
    progress : callable
        Told what is finished, in words.
    judge : callable
        Of a material; `judging.judge` but in tests.

    Returns
    -------
    dict
        The contents of results.json: commit, code, machine, seconds (of processors, over all materials), left_out, and
        materials, the records of `judging.judge`.
    """
    code = digest()
    out.mkdir(parents=True, exist_ok=True)
    lines = out / "progress.jsonl"
    finished = _finished(lines, code, out) if resume else {}
    with replacing(lines, "w") as stream:
        stream.writelines(json.dumps(record) + "\n" for record in finished.values())
    wanted = [material for material in materials if material.name not in finished]
    before = len(materials) - len(wanted)
    if before:
        progress(f"{before} of {len(materials)} materials were finished before")
    start = time.perf_counter()
    with open(lines, "a", encoding="utf-8") as stream:
        work = partial(_judged, out=out, code=code, judge=judge)
        for number, record in enumerate(held_out.each_of(work, wanted, jobs), start=1):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            finished[record["name"]] = record
            left = (time.perf_counter() - start) / number * (len(wanted) - number)
            progress(f"[{before + number}/{len(materials)}] {told(record)}; {left:.0f} s to go")
    records = [finished[material.name] for material in materials]
    results = {"commit": held_out.commit(), "code": code, "left_out": list(left_out),
               "seconds": sum(record["seconds"] for record in records),
               "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
               "materials": records}
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    return results


def told(record):
    """A finished material in a line: its cube-root RMSE at the samples, and how long it took."""
    found = [f"{name} " + ("failed" if "failed" in row else f"{row['samples_cube_root_rmse']:.3g}")
             for name, row in record["models"].items() if "failed" in row or row["samples_cube_root_rmse"] is not None]
    return f"{record['name']}: {', '.join(found)}; {record['seconds']:.0f} s"


def digest():
    """A digest of the sources that the numbers depend on."""
    return held_out.digest(_SOURCES, _NO_SOURCES)


def pictures(out, name):
    """The pictures of a material that a run wrote: by model, (size, size, 3) float32, scene-linear."""
    with np.load(_path(out, name)) as found:
        return dict(found)


def _path(out, name):
    return out / f"{name}.npz"


def _judged(material, out, code, judge):
    """The record of a material. Its pictures are written beside."""
    record, found = judge(material)
    with replacing(_path(out, material.name), "wb") as stream:
        np.savez_compressed(stream, **found)
    return record | {"code": code}


def _finished(path, code, out):
    """The records of an earlier run with the same code, by material."""
    return {record["name"]: record for record in held_out.recorded(path)
            if record["code"] == code and _path(out, record["name"]).is_file()}
