"""``python -m fitter report``: the paper's claims as tables and plots, on real data.

`tables`, `comparison`, `pareto` and `times` compute, `markdown` writes, `plots` and `slices` draw (matplotlib, an
optional extra). Plots are left out where matplotlib is not installed, and the report says so. What needs a renderer
is not made here: `write` is handed it as `Supplement`s.
"""

import json
import multiprocessing
import operator
import os
import platform
import time
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..files import replacing
from ..formats import list_samples, load
from . import comparison, markdown, pareto, plots, slices, tables, times

LEVELS = range(8)
BILEVEL = ((1, 6, 90), (3, 6, 90), (4, 6, 95), (4, 6, 99))
# materials shown in plots and the main tables, where they are at hand
FEATURED = ("felt", "leather", "aluminum foil", "Krylon Blue", "Garnet Red", "Cayman Metallic")
_FEATURED_ELSE = 4          # so many of the first, where none of these are


class Supplement(NamedTuple):
    """A part of the report that is made elsewhere."""

    key: str
    """What it is called in results.json."""
    text: str
    """Markdown, from a heading of the second rank on."""
    data: object
    """What results.json holds of it."""


def measurements(paths):
    """All measurements in some files: every sample of a CURET file, and each other file's one."""
    for path in paths:
        numbers = [number for number, _ in list_samples(path)] or [None]
        for number in numbers:
            yield load(path, number)


def featured(samples):
    """The measurements that plots and the main tables show: a list of Samples, one a name."""
    by_name = {}
    for measured in samples:
        by_name.setdefault(measured.name, measured)
    return [by_name[name] for name in FEATURED if name in by_name] or list(by_name.values())[:_FEATURED_ELSE]


def write(paths, out, levels=LEVELS, progress=lambda done, total, name: None, grid=pareto.GRID, calls=times.CALLS,
          supplements=(), jobs=1):
    """Write `results.md`, `tables.md`, `results.json` and, with matplotlib, PNG plots to a folder.

    Parameters
    ----------
    paths : list of path-like
        Files of measurements.
    out : path-like
        The folder, made where it is not there.
    levels : sequence of int
        Levels of plain MBA to report.
    progress : callable
        Told (done, total, name) before each step.
    grid : sequence of (D, S, C)
        What the table of speed and size against error holds.
    calls : int
        How often each method is evaluated for its time.
    supplements : sequence of callables
        Each takes a list of Samples and the folder, into which it may draw, and returns a `Supplement`.
    jobs : int
        Processes that share the materials.

    Returns
    -------
    dict
        What results.json holds.
    """
    start, worked = time.perf_counter(), _processor_seconds()
    out = Path(out)
    samples = list(measurements(paths))
    shown = featured(samples)
    total, done = len(samples) + 2 * len(shown) + 1 + len(supplements), 0

    def step(name):
        nonlocal done
        progress(done, total, name)
        done += 1

    results = {"machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
               "levels": list(levels), "featured": [[of.name, of.source] for of in shown],
               "errors": [], "comparison": [], "where": [], "pareto": [], "ringing": []}
    tasks = [(f"{of.name}: ringing, Pareto", partial(_of_shown, of, grid)) for of in shown]
    tasks += [(of.name, partial(_of_each, of, levels)) for of in samples]
    with _mapping(jobs) as each:
        found = iter(each(operator.call, [task for _, task in tasks]))
        for name, _ in tasks:
            step(name)
            for key, rows in next(found).items():
                results[key] += rows
    results |= {"storage": tables.storage(samples[0]), "claims": tables.claims(results["errors"]),
                "compressed": tables.compressed(results["errors"])}
    step("evaluation times")
    results["times"] = {"material": shown[0].name, "calls": calls, "rows": times.table(shown[0], calls)}
    out.mkdir(parents=True, exist_ok=True)
    pictures = plots.draw(results, out)
    for measured in shown:
        step(f"{measured.name}: plots")
        pictures += slices.draw_polar(measured, out)
    pictures += slices.draw_histograms(shown, out)
    added = []
    for supplement in supplements:
        step(supplement.__name__.replace("_", " "))
        added.append(supplement(shown, out))
    progress(total, total, "")
    results |= {part.key: part.data for part in added}
    results |= {"seconds": time.perf_counter() - start, "processor_seconds": _processor_seconds() - worked}
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    for name, text in (("results.md", markdown.main(results, pictures, [part.text for part in added])),
                       ("tables.md", markdown.details(results, pictures))):
        with replacing(out / name, "w") as stream:
            stream.write(text)
    return results


def _of_each(samples, levels):
    """What the report holds of every measurement: rows by table."""
    return {"errors": tables.errors(samples, levels, BILEVEL), "comparison": comparison.compare(samples),
            "where": [tables.where(samples)]}


def _of_shown(samples, grid):
    """What it holds of those that are shown: rows by table."""
    return {"ringing": tables.ringing_by_level(samples), "pareto": pareto.table(samples, grid)}


def _processor_seconds():
    """Of this process and those that it has waited for."""
    return sum(os.times()[:4])


@contextmanager
def _mapping(jobs):
    """`map`, or its like over several processes, started afresh: Blender's threads would not survive a fork."""
    if jobs == 1:
        yield map
    else:
        with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
            yield pool.map
