"""Converts folders of measurements to an asset library, with several processes. Up-to-date materials are kept.

This runs in a Blender without another open file (`blender_process`, or the command line). A library has parts of at
most `library_file.MATERIALS_PER_FILE` materials. They are opened, changed and saved one after the other, so that memory
does not grow with the number of measurements.
"""

import os
import re
import time
from collections import defaultdict
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import bpy

from ... import fitter
from ...fitter.arrays import SingleArray
from ...fitter.colours import DEFAULT_COLOURS
from ...fitter.quality.describe import open_questions
from ...fitter.storage.files import remove_stale_parts
from ..core.annotations import Arguments, not_none
from ..core.libraries import assets, library_file
from ..core.shading import material as materials
from ..core.storage import paths
from ..core.storage.edits import edit_arguments
from ..core.storage.outcomes import Outcome
from ..core.storage.properties import Choices, fit_arguments, quality_summary
from ..core.storage.reading import load_arguments
from ..work import process, tasks
from ..work.command import Row
from ..work.discovery import Failure, Source
from ..work.job import Job

PROCESSES = max((os.cpu_count() or 1) - 1, 1)
_POLL_INTERVAL = 0.02       # s, between two looks at the processes


class _Task(NamedTuple):
    """A material to make, or to fit again if `replaced` names one in the open part; `edit` is what users adjusted.

    `rendering` is that of a new material, and of one for which another was asked before; else users may have chosen it.
    """

    path: str
    sample: str
    key: str
    rendering: str
    replaced: str = ""
    edit: Arguments | None = None


class _Entry(NamedTuple):
    """A measured material in a part of the library."""

    part: Path
    name: str
    key: str
    filepath: str
    sample: str
    is_used: bool
    is_asset: bool
    is_named_after_data: bool
    edit: Arguments
    row: Row


_Job = Job[tuple[Outcome, SingleArray]]
_Planned = Mapping[Path | None, Sequence[_Task]]
"""Tasks by part; None for those that go into any part with room."""


def convert(context: bpy.types.Context, sources: Sequence[Source], failures: Sequence[Failure], choices: Choices,
            path: str | Path, processes: int = PROCESSES, force: bool = False, prune: bool = False,
            colours: str = DEFAULT_COLOURS) -> Generator[tuple[float, str], None, list[Row]]:
    """Write an asset library, in steps: yields (fraction, doing), and returns the rows, of which those that failed say
    why.

    `path` is the .blend, the first part of the library. Outdated materials in it are fitted again in place, new ones
    are added, and everything else stays, also what was made of files that are among the `failures`; with `prune`,
    unused materials of an earlier run go whose measurements are not among these nor the `sources`. Fits are saved in a
    folder beside it, so that an interrupted run can continue. `filepath` and `sample` of the choices are set to those
    of each material, and `colours` is the space of the files that will use them. With `force`, a file that is not a
    library is kept under another name; else, as where it may not be replaced, LibraryError or OSError is raised, and
    nothing has changed.
    """
    path, how = Path(path), {**load_arguments(choices), "colours": colours}
    with library_file.writing(path, force):
        parts = library_file.parts(path)
        entries = [entry for part in parts for entry in _entries_in(part)]
        unread = list(failures)
        rows: list[Row] = []
        planned, stale = _plan(sources, how, choices, entries, unread, rows)
        rows += [Row(_name(name, sample), f"failed: {error}") for name, sample, error in unread]
        given = {(Path(source.path).name, source.sample) for source in (*sources, *unread)}
        removed: defaultdict[Path, list[str]] = defaultdict(list)
        for entry in stale:
            file = Path(entry.filepath).name
            if given & {(file, entry.sample), (file, "")}:      # not read ("" for all samples), or a copy by a user
                continue
            if prune and not entry.is_used:
                removed[entry.part].append(entry.name)
            rows.append(Row(entry.name, f"{'removed' if prune and not entry.is_used else 'kept'}: its measurements are "
                                        "not among the files given"))
        yield from _write_parts(context, path, parts, planned, removed, entries, choices, how, processes, rows)
    return rows


def _entries_in(part: Path) -> list[_Entry]:
    """The materials in a part that `convert` made."""
    library_file.open_part(part)
    entries = [_Entry(part, item.name, item.measured_brdf.asset_key, paths.absolute(item),
                    item.measured_brdf.sample, item.users > item.use_fake_user, item.asset_data is not None,
                    _is_named_after_data(item), edit_arguments(item), row(item, "up to date"))
             for item in library_file.list_measured() if item.measured_brdf.asset_key]
    library_file.close()
    return entries


def _plan(sources: Sequence[Source], how: Arguments, choices: Choices, entries: Sequence[_Entry],
          failures: list[Failure], rows: list[Row]) -> tuple[_Planned, list[_Entry]]:
    """The tasks, and the entries whose measurements are not among the sources.

    Appends to `rows` the materials that are up to date, and to `failures` the files that cannot be read.
    """
    planned: defaultdict[Path | None, list[_Task]] = defaultdict(list)
    todo: list[_Task] = []
    wanted: set[str] = set()
    current = {entry.key: entry for entry in reversed(entries)}
    for path, sample in sources:
        try:
            samples = fitter.load(path, sample or None, **how)
        except ValueError as error:
            failures.append(Failure(path, sample, error))
            continue
        key_of_fit = tasks.fit_key(samples.name, tasks.digest(samples), fit_arguments(choices))
        key = tasks.asset_key(key_of_fit, choices.rendering)
        wanted.add(key)
        if key in current:
            known = current[key].row
            rows.append(known._replace(doubts=(*known.doubts, *open_questions(samples))))
        else:
            todo.append(_Task(path, sample, key, choices.rendering))
    left = [entry for entry in entries if entry.key not in wanted]
    for place in (os.path.abspath, os.path.basename):       # of the same file, else of one of the same name
        for task in todo[:]:
            same = (entry for entry in left if (place(entry.filepath), entry.sample) == (place(task.path), task.sample))
            # users may have made copies: prefer an asset, and one that has not been renamed
            outdated = max(same, key=lambda entry: (entry.is_asset, entry.is_named_after_data), default=None)
            if outdated is not None:
                left.remove(outdated)
                todo.remove(task)
                rendering = "" if outdated.key.endswith(f" {task.rendering}") else task.rendering
                planned[outdated.part].append(task._replace(replaced=outdated.name, edit=outdated.edit,
                                                            rendering=rendering))
    planned[None] = todo
    return planned, left


def _write_parts(context: bpy.types.Context, path: Path, parts: Sequence[Path], planned: _Planned,
                 removed: Mapping[Path, Sequence[str]], entries: Sequence[_Entry], choices: Choices, how: Arguments,
                 processes: int, rows: list[Row]) -> Iterator[tuple[float, str]]:
    total = sum(map(len, planned.values()))
    done, waiting = 0, [*planned.get(None, ())]
    folder = path.with_suffix(".fits")
    remove_stale_parts(folder)         # none is being written: the library is locked
    existing, is_written = iter(parts), False
    while (old := next(existing, None)) or waiting:
        is_new = old is None
        part = old or library_file.next_part(path)
        unwanted = removed.get(part, ())
        held = sum(entry.part == part for entry in entries) - len(unwanted)
        room = max(library_file.MATERIALS_PER_FILE - held, 0)
        todo, waiting = [*planned.get(part, ()), *waiting[:room]], waiting[room:]
        if not todo and not unwanted:
            continue
        if is_new:
            library_file.close()
        opened = None if is_new else library_file.open_part(part)
        for name in unwanted:
            materials.remove(bpy.data.materials[name])
        made: list[str] = []
        for step in _do_tasks(todo, how, fit_arguments(choices), folder, processes,
                              partial(_make_material, context, choices, made, rows)):
            yield (done + step) / total, f"{done + step} of {total} fitted"
        done += len(todo)
        if made or unwanted:
            yield done / max(total, 1), f"Writing {part.name}"
            library_file.save_part(part, opened)
            is_written = True
        else:
            library_file.close()
    if is_written:
        assets.write_catalogue(path.parent)


def _do_tasks(todo: Sequence[_Task], how: Arguments, arguments: Arguments, folder: Path, processes: int,
              function: Callable[[_Task, _Job], object]) -> Iterator[int]:
    """Do tasks in worker processes, and call `function` with each finished job: yields how many are done."""
    waiting = [*reversed(todo)]
    idle: list[process.Worker] = []
    running: list[tuple[_Job, _Task, process.Worker]] = []
    try:
        while waiting or running:
            for item in running[:]:
                job, task, worker = item
                if job.poll():
                    running.remove(item)
                    idle.append(worker)
                    function(task, job)
            while waiting and len(running) < processes:
                task = waiting.pop()
                job = Job(partial(tasks.asset, task.path, task.sample, arguments, str(folder), how=how,
                                  edit=task.edit))
                worker = idle.pop() if idle and idle[-1].is_alive() else process.Worker()
                worker.begin(job)
                running.append((job, task, worker))
            yield len(todo) - len(waiting) - len(running)
            time.sleep(_POLL_INTERVAL)
    finally:
        for worker in [*idle, *(worker for _, _, worker in running)]:
            worker.kill()


def _make_material(context: bpy.types.Context, choices: Choices, made: list[str], rows: list[Row], task: _Task,
                   job: _Job) -> None:
    if job.error is None:
        outcome, picture = not_none(job.result)
        choices.filepath, choices.sample = task.path, task.sample
        try:
            if task.replaced:
                item = bpy.data.materials[task.replaced]
                remembered, is_named = assets.remember(item), _is_named_after_data(item)
                materials.assign(item, outcome, choices, context)
                if task.rendering:
                    materials.use_rendering(item, task.rendering)
                if remembered is not None:      # else a user has removed the asset mark
                    assets.renew(item, remembered, picture)
                if is_named:
                    item.name = outcome.measured.name
            else:
                item = materials.create(outcome, choices, context)
                assets.mark(item, picture)
        except (RuntimeError, ValueError) as error:
            job.error = error
        else:
            item.measured_brdf.asset_key = task.key
            made.append(item.name)
            rows.append(row(item, "fitted", outcome.questions))
    if job.error is not None:
        rows.append(Row(_name(task.path, task.sample), f"failed: {job.error}"))


def _is_named_after_data(item: bpy.types.Material) -> bool:
    return re.fullmatch(rf"{re.escape(item.measured_brdf.name_of_data)}(\.\d{{3}})?", item.name) is not None


def row(item: bpy.types.Material, status: str, questions: Sequence[str] = ()) -> Row:
    """The row of a measured material. Its doubts are a fit that is judged bad, and questions about its measurements."""
    settings = item.measured_brdf
    judged = quality_summary(settings)
    return Row(item.name, status, settings.coefficients, settings.bytes, settings.rmse,
               (*([judged.line] if judged.is_bad else []), *questions))


def _name(path: str, sample: str) -> str:
    return f"{Path(path).name} {sample}".strip()
