"""Jobs, and the worker processes that do them, so that Blender's window stays responsive.

A worker is a process that does one job at a time. Each has a name; `start` gives a job to the operators' worker.
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
from typing import IO, Any, Generic, Protocol, TypeVar, cast

import bpy

from ..annotations import Report
from .tasks import silent

_Result = TypeVar("_Result")

ENDED_EARLY = "The fitting process has ended early: it was killed, or memory ran out"
_PACKAGE = __package__.rpartition(".addon")[0]


class WorkerError(RuntimeError):
    """The worker process ended early: it was killed, or memory ran out."""


class AnyWorker(Protocol):
    """Where a job runs: a `Worker`, or a `blender_process.BlenderProcess`."""

    def poll(self, job: "Job[Any]") -> None:
        """Update the job's progress, and its result once it has one."""

    def kill(self) -> None:
        """End the process."""


class Job(Generic[_Result]):
    """A piece of work, its progress and its result.

    Attributes
    ----------
    function : callable, or None
        Takes `report(fraction, doing)`. The function and its result can be pickled. None for a Blender process.
    worker : AnyWorker, or None
        None until the job begins.
    number : int
        Of the job, for its `Worker`.
    fraction, doing : float, str
        The progress.
    result, error
        What the function returned, or the exception that it raised.
    finished : float, or None
        When, by `time.monotonic`.
    asked : float
        When a panel last asked for the result.
    """

    def __init__(self, function: Callable[[Report], _Result] | None) -> None:
        self.function = function
        self.worker: AnyWorker | None = None
        self.number = 0
        self.fraction, self.doing = 0.0, "Starting"
        self.result: _Result | None = None
        self.error: Exception | None = None
        self.finished: float | None = None
        self.asked = 0.0

    def poll(self) -> bool:
        """Update progress and result: whether the job is finished."""
        if self.worker is not None and self.finished is None:
            self.worker.poll(self)
        return self.finished is not None

    def cancel(self) -> None:
        """End the work, and its process."""
        if self.worker is not None and self.finished is None:
            self.worker.kill()


class Work(Protocol):
    """What an operator does in another process: a `Calculation`, or a `blender_process.Command`."""

    def start(self) -> Job[Any]:
        """Begin in another process."""

    def run(self) -> Any:
        """Wait for the result, or raise the error."""


def read_progress(path: Path, job: Job[Any]) -> None:
    """Update a job with the progress that its process wrote."""
    with contextlib.suppress(OSError, ValueError):      # not there yet, or half written
        fraction, job.doing = path.read_text("utf-8").split(" ", 1)
        job.fraction = float(fraction)


class Worker:
    """A process that does one job at a time, and the folder into which it writes its answers."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="measured_brdf_")
        root = Path(__file__).parents[2]
        script = str(Path(__file__).with_name("worker.py"))
        command = [sys.executable, *bpy.app.python_args, script, _PACKAGE, str(root), self._folder.name]
        # several workers share the processors with Blender, so each uses one
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
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


def start(function: Callable[[Report], _Result]) -> Job[_Result]:
    """Begin function(report) in the operators' worker."""
    job = Job(function)
    worker("operator").begin(job)
    return job


class Calculation(Generic[_Result]):
    """A function as the work of an operator; the function and its result can be pickled."""

    def __init__(self, function: Callable[[Report], _Result]) -> None:
        self._function = function

    def start(self) -> Job[_Result]:
        """Begin in the operators' worker."""
        return start(self._function)

    def run(self) -> _Result:
        """Call the function here and now."""
        return self._function(silent)


def worker(name: str) -> Worker:
    """The worker of this name; started if none is alive."""
    if name not in _workers or not _workers[name].is_alive():
        _workers[name] = Worker()
    return _workers[name]


def unregister() -> None:
    """End all workers."""
    for found in _workers.values():
        found.kill()
    _workers.clear()
