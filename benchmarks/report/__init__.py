"""``python -m fitter report``: tables and plots that compare the paper's claims with results on real data.

`tables`, `comparison` and `times` compute the tables; `findings` and `markdown` write the text; `plots` and `slices`
draw. The parts that need a renderer are made elsewhere, and are given to `write` as functions that return a
`Supplement`.
"""

import json
import multiprocessing
import operator
import os
import platform
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fitter.cli import show_progress
from fitter.files import replacing
from fitter.formats import list_samples, load
from fitter.samples import Samples

from . import comparison, markdown, plots, slices, tables, times
from .rows import Results, Row

LEVELS = range(8)
BILEVEL = ((1, 6, 90), (3, 6, 90), (4, 6, 95), (4, 6, 99))
# materials of the plots and the main tables, if they are among the files
FEATURED = ("felt", "leather", "aluminum foil", "Krylon Blue", "Garnet Red", "Cayman Metallic")
_FEATURED_ELSE = 4          # number of materials to feature if none of these is there


class Supplement(NamedTuple):
    """A part of the report that is made elsewhere."""

    key: str
    """Its key in results.json."""
    text: str
    """Markdown, which begins with a heading of the second level."""
    data: object
    """Its value in results.json."""


MakeSupplement = Callable[[list[Samples], Path], Supplement]
"""Makes a part of the report of the featured materials; it may draw pictures into the folder."""


def measurements(paths: Iterable[str | Path]) -> Iterator[Samples]:
    """All materials in files: every sample of a CURET file, and the only one of each other file."""
    for path in paths:
        numbers: list[int | None] = [number for number, _ in list_samples(path)]
        for number in numbers or [None]:
            yield load(path, number)


def featured(samples: Iterable[Samples]) -> list[Samples]:
    """The materials of the plots and the main tables; of several with one name, the first.

    Examples
    --------
    >>> from dataclasses import replace
    >>> felt = Samples([0], [0], [0], [0], [[0.2]], name="felt")
    >>> [material.name for material in featured([replace(felt, name="moss"), felt, felt])]
    ['felt']
    """
    by_name: dict[str, Samples] = {}
    for measured in samples:
        by_name.setdefault(measured.name, measured)
    return [by_name[name] for name in FEATURED if name in by_name] or list(by_name.values())[:_FEATURED_ELSE]


def write(paths: Sequence[str | Path], out: str | Path, levels: Sequence[int] = LEVELS,
          progress: Callable[[int, int, str], None] = lambda done, total, name: None, calls: int = times.CALLS,
          supplements: Sequence[MakeSupplement] = (), jobs: int = 1) -> Results:
    """Write `results.md`, `results.json` and PNG plots to a folder.

    Parameters
    ----------
    paths : list of path-like
        Files of measurements.
    out : path-like
        The folder; it is created if necessary.
    levels : sequence of int
        Levels of plain MBA to report.
    progress : callable
        Called with (done, total, name) before each step.
    calls : int
        Number of evaluations of each method for the table of times.
    supplements : sequence of callables
        Each takes the featured samples and the folder, into which it may draw, and returns a `Supplement`.
    jobs : int
        Number of processes among which the materials are divided.

    Returns
    -------
    dict
        The contents of results.json.

    Raises
    ------
    DatasetError
        If a file cannot be read; nothing is written then.
    """
    start, worked = time.perf_counter(), _processor_seconds()
    out = Path(out)
    samples = list(measurements(paths))
    shown = featured(samples)
    total, done = len(samples) + len(shown) + 1 + len(supplements), 0

    def step(name: str) -> None:
        nonlocal done
        progress(done, total, name)
        done += 1

    results: Results = {
        "machine": f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.machine()}",
        "levels": list(levels), "featured": [[of.name, of.source] for of in shown],
        "errors": [], "comparison": [], "where": [], "ringing": []}
    tasks: list[tuple[str, Callable[[], dict[str, list[Row]]]]] = [
        (f"{of.name}: ringing", partial(_of_featured, of)) for of in shown]
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
    plots.draw(results, out)
    polar = [slices.draw_polar(measured, out) for measured in dict.fromkeys((shown[0], shown[-1]))]
    parts = []
    for supplement in supplements:
        step(getattr(supplement, "__name__", "supplement").replace("_", " "))
        parts.append(supplement(shown, out))
    progress(total, total, "")
    results |= {part.key: part.data for part in parts}
    results |= {"seconds": time.perf_counter() - start, "processor_seconds": _processor_seconds() - worked}
    with replacing(out / "results.json", "w") as stream:
        json.dump(results, stream, indent=1)
    with replacing(out / "results.md", "w") as stream:
        stream.write(markdown.main(results, polar, [part.text for part in parts]))
    return results


def run(files: Sequence[str | Path], out: str | Path, levels: Sequence[int] | None = None,
        supplements: Sequence[MakeSupplement] = ()) -> None:
    """Write a report with a progress bar, and print how the paper's claim holds; arguments as for `write`."""
    results = write(files, out, levels or LEVELS, show_progress, supplements=supplements, jobs=os.cpu_count() or 1)
    for claim in results["claims"]:
        print(f"{claim['material']:20} better baseline / level 6: {claim['level_6_factor']:7.2f}   "
              f"/ level 4: {claim['level_4_factor']:5.2f}")
    print(f"{out}/results.md, in {results['seconds']:.0f} s")


def _of_each(samples: Samples, levels: Sequence[int]) -> dict[str, list[Row]]:
    """The rows of every material, by table."""
    return {"errors": tables.errors(samples, levels, BILEVEL), "comparison": comparison.compare(samples),
            "where": [tables.where(samples)]}


def _of_featured(samples: Samples) -> dict[str, list[Row]]:
    """The additional rows of featured materials, by table."""
    return {"ringing": tables.ringing_by_level(samples)}


def _processor_seconds() -> float:
    """Processor time of this process and of its finished children, seconds."""
    return sum(os.times()[:4])


@contextmanager
def _mapping(jobs: int) -> Iterator[Callable[..., Iterable[Any]]]:
    """`map`, or the `map` of a pool of processes. They are spawned, as Blender's threads do not survive a fork."""
    if jobs == 1:
        yield map
    else:
        with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
            yield pool.map
