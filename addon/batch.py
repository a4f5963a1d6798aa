"""Folders of measurements into an asset library, on several processes; what has been done before is not done again."""

import os
from functools import partial
from pathlib import Path
from typing import NamedTuple

import bpy

from .. import fitter
from . import assets, background, work
from . import material as materials
from .properties import fit_arguments

PROCESSES = max(os.cpu_count() - 1, 1)


class Row(NamedTuple):
    """What became of one material."""

    name: str
    status: str
    coefficients: int = 0
    nbytes: int = 0
    rmse: float = float("nan")


class Progress(NamedTuple):
    """How far a batch is."""

    fraction: float
    doing: str


def convert(context, sources, failures, choices, path, processes=PROCESSES):
    """Write an asset library: a generator of Progress which returns rows; it does not wait, so whoever runs it should.

    Parameters
    ----------
    context : bpy.types.Context
    sources : list of (path, sample)
    failures : list of (path, sample, exception)
        Files that could not be read.
    choices : properties.FitChoices
        `filepath` and `sample` are set to those of each material.
    path : path-like
        The .blend to write. Materials of an earlier run that are up to date are kept, others removed. Fits are kept
        in a folder beside it, so that an interrupted run goes on where it was.
    processes : int

    Returns
    -------
    list of Row
        The status of those that failed says why.
    """
    arguments = fit_arguments(choices)
    made, kept = [], _load(path)
    rows = [Row(Path(name).name, f"failed: {error}") for name, _, error in failures]
    todo = []
    try:
        for source in sources:
            try:
                samples = fitter.load(source[0], source[1] or None)
            except ValueError as error:
                rows.append(Row(_name(*source), f"failed: {error}"))
                continue
            key = work.asset_key(samples.name, work.digest(samples), arguments)
            if key in kept:
                made.append(kept.pop(key))
                rows.append(row(made[-1], "up to date"))
            else:
                todo.append((*source, key))
        if todo or kept:
            for item in kept.values():
                materials.remove(item)
            kept = {}
            function = partial(_make, context, choices, made, rows)
            yield from _in_parallel(todo, arguments, Path(path).with_suffix(".fits"), processes, function)
            if made:
                yield Progress(1.0, "Writing the library")
                assets.write(made, path)
    finally:
        for item in [*made, *kept.values()]:
            materials.remove(item)
    return rows


def _in_parallel(todo, arguments, folder, processes, function):
    """Work out assets, and give each to a function as it comes, in whatever order: a generator of Progress."""
    waiting, workers, running, total = todo[::-1], [], [], len(todo)
    try:
        while waiting or running:
            for job, source in running[:]:
                if job.poll():
                    running.remove((job, source))
                    workers.append(job.worker)
                    function(source, job)
            while waiting and len(running) < processes:
                source = waiting.pop()
                job = background.Job(partial(work.asset, *source[:2], arguments, str(folder)))
                worker = workers.pop() if workers and workers[-1].is_alive() else background.Worker()
                worker.begin(job)
                running.append((job, source))
            done = total - len(waiting) - len(running)
            yield Progress(done / total, f"{done} of {total} fitted")
    finally:
        for worker in [*workers, *(job.worker for job, _ in running)]:
            worker.kill()


def _make(context, choices, made, rows, source, job):
    path, sample, key = source
    if job.error is None:
        outcome, picture = job.result
        choices.filepath, choices.sample = path, sample
        try:
            item = materials.create(outcome, choices, context)
        except RuntimeError as error:
            job.error = error
        else:
            item.measured_brdf.asset_key = key
            assets.mark(item, picture)
            made.append(item)
            rows.append(row(item, "fitted"))
    if job.error is not None:
        rows.append(Row(_name(path, sample), f"failed: {job.error}"))


def _load(path):
    """The measured materials of a library, appended: {key: material}."""
    if not Path(path).is_file():
        return {}
    with bpy.data.libraries.load(str(path), link=False) as (source, target):
        target.materials = source.materials
    return {item.measured_brdf.asset_key: item for item in target.materials if materials.is_measured(item)}


def row(item, status):
    settings = item.measured_brdf
    return Row(item.name, status, settings.coefficients, settings.bytes, settings.rmse)


def _name(path, sample):
    return f"{Path(path).name} {sample}".strip()
