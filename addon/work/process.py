"""Worker processes, so that Blender's window stays responsive.

A worker is a process that does one `Job` at a time. Each has a name; `start` gives a job to the operators' worker.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any, TypeVar, cast

import bpy

from . import shared
from .job import Job, read_progress

_Result = TypeVar("_Result")

ENDED_EARLY = "The fitting process has ended early: it was killed, or memory ran out"
_WORKER_SCRIPT = Path(__file__).with_name("worker.py")
_PACKAGE = __package__.rpartition(".addon")[0]


class WorkerError(RuntimeError):
    """The worker process ended early: it was killed, or memory ran out."""


class Worker:
    """A process that does one job at a time, and the folder into which it writes its answers."""

    def __init__(self) -> None:
        self._folder = temporary()
        root = Path(__file__).parents[2]
        # -P: modules beside the script must not be importable by their bare names
        command = [sys.executable, *bpy.app.python_args, "-P", str(_WORKER_SCRIPT), _PACKAGE, str(root),
                   self._folder.name]
        # several workers share the processors with Blender, so each uses one
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", shared.WORKERS_FOLDER: folder()}
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, env=environment,
                                         creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0))
        self._input = cast(IO[bytes], self._process.stdin)
        self._count = 0

    def begin(self, job: Job[Any]) -> None:
        """Give the process a job."""
        self._count += 1
        job.worker, job.number = self, self._count
        with contextlib.suppress(OSError):          # the process has died: `poll` will say so
            pickle.dump((job.number, job.function), self._input)
            self._input.flush()

    def poll(self, job: Job[Any]) -> None:
        """Update the job's progress, and its result once it has one."""
        ended = not self.is_alive()                 # before reading: then everything it wrote is there
        done = Path(self._folder.name, f"{job.number}.done")
        if done.exists():
            job.finished = time.monotonic()
            try:
                job.result, job.error = pickle.loads(done.read_bytes())
                done.unlink()
            except Exception as error:              # unpickling runs code of any class, which may raise anything
                job.error = error
        elif ended:
            job.error, job.finished = WorkerError(ENDED_EARLY), time.monotonic()
        else:
            read_progress(Path(self._folder.name, f"{job.number}.progress"), job)

    def is_alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End the process."""
        self._process.kill()
        self._input.close()
        self._process.wait()
        self._folder.cleanup()


_workers: dict[str, Worker] = {}
_folder: "tempfile.TemporaryDirectory[str] | None" = None


def start(function: Callable[[], _Result]) -> Job[_Result]:
    """Begin function() in the operators' worker."""
    job = Job(function)
    worker("operator").begin(job)
    return job


class Calculation:
    """A function as the work of an operator; the function and its result can be pickled."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function

    def start(self) -> Job[Any]:
        """Begin in the operators' worker."""
        return start(self._function)

    def run(self) -> Any:
        """Call the function here and now."""
        return self._function()


def worker(name: str) -> Worker:
    """The worker of this name; started if none is alive."""
    if name not in _workers or not _workers[name].is_alive():
        _workers[name] = Worker()
    return _workers[name]


def folder() -> str:
    """The temporary folder of this Blender: for what workers have worked out, and for `temporary` ones.

    It goes with Blender; if that is killed, the processes that it has started remove it.
    """
    global _folder
    if _folder is None:
        # a worker may be writing into it; it removes what is left
        _folder = tempfile.TemporaryDirectory(prefix="measured_brdf_", ignore_cleanup_errors=True)
    return _folder.name


def temporary() -> "tempfile.TemporaryDirectory[str]":
    """A new folder in that of this Blender."""
    return tempfile.TemporaryDirectory(dir=folder())


def unregister() -> None:
    """End all workers."""
    global _folder
    for each in _workers.values():
        each.kill()
    _workers.clear()
    if _folder is not None:
        _folder.cleanup()
    _folder = None
