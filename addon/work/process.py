"""Worker processes, so that Blender's window stays responsive: each has a name, and does one `Job` at a time."""

import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, Any, cast

import bpy

from . import shared
from .job import Job, read_progress

ENDED_EARLY = "The fitting process has ended early: it was killed, or memory ran out"
_WORKER_SCRIPT = Path(__file__).with_name("worker.py")
_PACKAGE = __package__.rpartition(".addon")[0]


class WorkerError(RuntimeError):
    """The worker process ended early: it was killed, or memory ran out."""


class ChildProcess:
    """A process that this Blender has started, and the temporary folder into which it writes."""

    def __init__(self) -> None:
        self._folder = temporary()

    def _start(self, command: Sequence[str], environment: dict[str, str], **streams: Any) -> None:
        """Run a command with these variables in its environment, and the streams of `subprocess.Popen`."""
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, **streams,
                                         creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                                         env=os.environ | {shared.WORKERS_FOLDER: folder()} | environment)
        self._input = cast(IO[bytes], self._process.stdin)

    def is_alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        self._process.kill()
        self._input.close()
        self._process.wait()
        self._folder.cleanup()


class Worker(ChildProcess):
    """A process that does one job at a time, and writes its answers into its folder."""

    def __init__(self) -> None:
        super().__init__()
        root = Path(__file__).parents[2]
        # -P: modules beside the script must not be importable by their bare names
        command = [sys.executable, *bpy.app.python_args, "-P", str(_WORKER_SCRIPT), _PACKAGE, str(root),
                   self._folder.name]
        # several workers share the processors with Blender, so each uses one
        self._start(command, {"OPENBLAS_NUM_THREADS": "1"})
        self._count = 0

    def begin(self, job: Job[Any]) -> None:
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


_workers: dict[str, Worker] = {}
_folder: "tempfile.TemporaryDirectory[str] | None" = None


class Calculation:
    """A function as the work of an operator; the function and its result can be pickled."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self._function = function

    def start(self) -> Job[Any]:
        job = Job(self._function)
        worker("operator").begin(job)
        return job

    def run(self) -> Any:
        return self._function()


def worker(name: str) -> Worker:
    """The worker of this name; started if none is alive."""
    if name not in _workers or not _workers[name].is_alive():
        _workers[name] = Worker()
    return _workers[name]


def folder() -> str:
    """The temporary folder of this Blender, with which it goes; if that is killed, its processes remove it."""
    global _folder
    if _folder is None:
        # a worker may be writing into it; it removes what is left
        _folder = tempfile.TemporaryDirectory(prefix="measured_brdf_", ignore_cleanup_errors=True)
    return _folder.name


def temporary() -> "tempfile.TemporaryDirectory[str]":
    return tempfile.TemporaryDirectory(dir=folder())


def unregister() -> None:
    global _folder
    for each in _workers.values():
        each.kill()
    _workers.clear()
    if _folder is not None:
        _folder.cleanup()
    _folder = None
