"""Folders of measurements into an asset library, on several processes; what has been done before is not done again.

This runs in a Blender that has no other file open (`blender_process`, or the command line). It opens the parts of the
library one after the other, each of at most `library_file.MATERIALS_PER_FILE` materials, and writes each as soon as it
is complete. So memory does not grow with the number of measurements.
"""

import os
import re
from collections import defaultdict
from functools import partial
from pathlib import Path
from typing import NamedTuple

import bpy

from ... import fitter
from ..jobs import process, tasks
from ..materials import material as materials
from ..materials.properties import fit_arguments
from . import assets, library_file

DONE = ("fitted", "up to date", "rendered", "saved")       # what a row's status says where all is well
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


class _Task(NamedTuple):
    """A material to make, or to make anew where `replaced` names one in the open part."""

    path: str
    sample: str
    key: str
    replaced: str = ""


class _Entry(NamedTuple):
    """A measured material that a part of the library holds."""

    part: Path
    name: str
    key: str
    filepath: str
    sample: str
    is_used: bool
    is_asset: bool
    is_named_after_data: bool
    row: Row


def convert(context, sources, failures, choices, path, processes=PROCESSES, force=False, prune=False):
    """Write an asset library: a generator of Progress which returns rows; it does not wait, so whoever runs it should.

    Parameters
    ----------
    context : bpy.types.Context
    sources : list of (path, sample)
    failures : list of (path, sample, exception)
        Files that could not be read: what the library has of them is kept.
    choices : properties.FitChoices
        `filepath` and `sample` are set to those of each material.
    path : path-like
        The .blend to write, the first part of the library. What is in it stays: materials that are out of date are
        fitted again in place, new ones are added. Fits are kept in a folder beside it, so that an interrupted run goes
        on where it was.
    processes : int
    force : bool
        Put a file that is not a library aside instead of refusing to replace it.
    prune : bool
        Remove materials of an earlier run whose measurements are not among the sources or failures, unless something
        in the file uses them.

    Returns
    -------
    list of Row
        The status of those that failed says why.

    Raises
    ------
    library.LibraryError, OSError
        If the file may not be replaced; nothing has been changed then.
    """
    path = Path(path)
    with library_file.writing(path, force):
        parts = library_file.parts(path)
        entries = [entry for part in parts for entry in _survey(part)]
        failures, rows = list(failures), []
        planned, stale = _plan(sources, fit_arguments(choices), entries, failures, rows)
        rows += [Row(_name(name, sample), f"failed: {error}") for name, sample, error in failures]
        given = {(Path(name).name, sample) for name, sample, *_ in [*sources, *failures]}
        removed = defaultdict(list)
        for entry in stale:
            file = Path(entry.filepath).name
            if given & {(file, entry.sample), (file, "")}:      # unread, "" for all of its samples, or a user's copy
                continue
            if prune and not entry.is_used:
                removed[entry.part].append(entry.name)
            rows.append(Row(entry.name, f"{'removed' if prune and not entry.is_used else 'kept'}: its measurements are "
                                        "not among the files given"))
        yield from _write_parts(context, path, parts, planned, removed, entries, choices, processes, rows)
    return rows


def _survey(part):
    """The measured materials of a part that `convert` made: a list of _Entry."""
    library_file.open_part(part)
    found = [_Entry(part, item.name, item.measured_brdf.asset_key, item.measured_brdf.filepath,
                    item.measured_brdf.sample, item.users > item.use_fake_user, item.asset_data is not None,
                    _is_named_after_data(item), row(item, "up to date"))
             for item in library_file.measured() if item.measured_brdf.asset_key]
    library_file.close()
    return found


def _plan(sources, arguments, entries, failures, rows):
    """What is to be done: tasks by part (None for those that go anywhere), and entries that no source stands for.

    Rows of what is up to date, and failures of what cannot be read, are appended to the lists given.
    """
    planned, todo, wanted = defaultdict(list), [], set()
    current = {entry.key: entry for entry in reversed(entries)}
    for path, sample in sources:
        try:
            samples = fitter.load(path, sample or None)
        except ValueError as error:
            failures.append((path, sample, error))
            continue
        key = tasks.asset_key(tasks.fit_key(samples.name, tasks.digest(samples), arguments))
        wanted.add(key)
        if key in current:
            rows.append(current[key].row)
        else:
            todo.append(_Task(path, sample, key))
    left = [entry for entry in entries if entry.key not in wanted]
    for same in (_is_same_file, _has_same_name):
        for task in todo[:]:
            # of several, copies that users made among them, the one that has not been renamed, and is an asset
            found = max((entry for entry in left if same(task, entry)), key=_is_original, default=None)
            if found is not None:
                left.remove(found)
                todo.remove(task)
                planned[found.part].append(task._replace(replaced=found.name))
    planned[None] = todo
    return planned, left


def _is_original(entry):
    return entry.is_asset, entry.is_named_after_data


def _is_same_file(task, entry):
    return (task.path, task.sample) == (entry.filepath, entry.sample)


def _has_same_name(task, entry):
    return (Path(task.path).name, task.sample) == (Path(entry.filepath).name, entry.sample)


def _write_parts(context, path, parts, planned, removed, entries, choices, processes, rows):
    """Change and write one part after the other: a generator of Progress."""
    total = sum(map(len, planned.values()))
    done, waiting = 0, planned[None]
    folder = path.with_suffix(".fits")
    existing, is_written = iter(parts), False
    while (part := next(existing, None)) or waiting:
        is_new = part is None
        part = part or library_file.next_part(path)
        held = sum(entry.part == part for entry in entries) - len(removed[part])
        room = max(library_file.MATERIALS_PER_FILE - held, 0)
        todo, waiting = [*planned[part], *waiting[:room]], waiting[room:]
        if not todo and not removed[part]:
            continue
        if is_new:
            library_file.close()
        opened = None if is_new else library_file.open_part(part)
        for name in removed[part]:
            materials.remove(bpy.data.materials[name])
        made = []
        for step in _in_parallel(todo, fit_arguments(choices), folder, processes,
                                 partial(_make, context, choices, made, rows)):
            yield Progress((done + step) / total, f"{done + step} of {total} fitted")
        done += len(todo)
        if made or removed[part]:
            yield Progress(done / max(total, 1), f"Writing {part.name}")
            library_file.save_part(part, opened)
            is_written = True
        else:
            library_file.close()
    if is_written:
        assets.write_catalogue(path.parent)


def _in_parallel(todo, arguments, folder, processes, function):
    """Work out assets, and give each to a function as it comes, in whatever order: a generator of how many are done."""
    waiting, workers, running = todo[::-1], [], []
    try:
        while waiting or running:
            for job, task in running[:]:
                if job.poll():
                    running.remove((job, task))
                    workers.append(job.worker)
                    function(task, job)
            while waiting and len(running) < processes:
                task = waiting.pop()
                job = process.Job(partial(tasks.asset, task.path, task.sample, arguments, str(folder)))
                worker = workers.pop() if workers and workers[-1].is_alive() else process.Worker()
                worker.begin(job)
                running.append((job, task))
            yield len(todo) - len(waiting) - len(running)
    finally:
        for worker in [*workers, *(job.worker for job, _ in running)]:
            worker.kill()


def _make(context, choices, made, rows, task, job):
    """Make the material of a finished task in the open part."""
    if job.error is None:
        outcome, picture = job.result
        choices.filepath, choices.sample = task.path, task.sample
        try:
            if task.replaced:
                item = bpy.data.materials[task.replaced]
                remembered, is_named = assets.remember(item), _is_named_after_data(item)
                materials.assign(item, outcome, choices, context)
                if remembered is not None:      # else a user has taken the mark away
                    assets.renew(item, remembered, picture)
                if is_named:
                    item.name = outcome.samples.name
            else:
                item = materials.create(outcome, choices, context)
                assets.mark(item, picture)
        except (RuntimeError, ValueError) as error:
            job.error = error
        else:
            item.measured_brdf.asset_key = task.key
            made.append(item.name)
            rows.append(row(item, "fitted"))
    if job.error is not None:
        rows.append(Row(_name(task.path, task.sample), f"failed: {job.error}"))


def _is_named_after_data(item):
    """Whether nobody gave a material another name."""
    return re.fullmatch(rf"{re.escape(item.measured_brdf.name_of_data)}(\.\d{{3}})?", item.name) is not None


def row(item, status):
    """What there is to say of a measured material."""
    settings = item.measured_brdf
    return Row(item.name, status, settings.coefficients, settings.bytes, settings.rmse)


def _name(path, sample):
    return f"{Path(path).name} {sample}".strip()
