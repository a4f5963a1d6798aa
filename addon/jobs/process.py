"""Work in other processes, so that Blender's window stays alive: see `worker`.

Every named worker is a process that does one job at a time; `start` gives a job to that of the operators.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy

from .tasks import silent

ENDED_EARLY = "The fitting process has ended early: it was killed, or memory ran out"
_PACKAGE = __package__.rpartition(".addon")[0]
_workers = {}               # name: Worker


class WorkerError(RuntimeError):
    """The process that did the work has ended early: killed, or out of memory."""


class Job:
    """A piece of work and what has become of it.

    Attributes
    ----------
    function : callable
        Takes `report(fraction, doing)`; it can be pickled, as can what it returns.
    fraction, doing
        How far it is, and at what.
    result, error
        What the function returned, or the exception that it raised.
    finished, asked : float, or None
        When, by `time.monotonic`.
    """

    def __init__(self, function):
        self.function, self.worker = function, None
        self.fraction, self.doing = 0.0, "Starting"
        self.result = self.error = self.finished = self.asked = None

    def poll(self):
        """Take what the worker has said meanwhile: whether the work is finished."""
        if self.worker is not None and self.finished is None:
            self.worker.poll(self)
        return self.finished is not None

    def cancel(self):
        """End the work, wherever it is."""
        if self.worker is not None and self.finished is None:
            self.worker.kill()


def read_progress(path, job):
    """Tell a job what its process has written last of its progress."""
    with contextlib.suppress(OSError, ValueError):      # not there yet, or half written: next time
        fraction, job.doing = path.read_text("utf-8").split(" ", 1)
        job.fraction = float(fraction)


class Worker:
    """A process that does one piece of work at a time, and the folder through which it answers."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="measured_brdf_")
        root = Path(__file__).parents[2]
        script = str(Path(__file__).with_name("worker.py"))
        command = [sys.executable, *bpy.app.python_args, script, _PACKAGE, str(root), self._folder.name]
        # several of them share the processors with Blender: each is to take one
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
                                         creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0))
        self._count = 0

    def begin(self, job):
        self._count += 1
        job.worker, job.number = self, self._count
        with contextlib.suppress(OSError):          # it has died: `poll` will say so
            pickle.dump((job.number, job.function), self._process.stdin)
            self._process.stdin.flush()

    def poll(self, job):
        ended = not self.is_alive()                 # asked first: what it wrote before its end is there then
        done = Path(self._folder.name, f"{job.number}.done")
        if done.exists():
            job.finished = time.monotonic()
            try:
                job.result, job.error = pickle.loads(done.read_bytes())
                done.unlink()
            except Exception as error:              # of whatever kind: unpickling runs code of the classes
                job.error = error
        elif ended:
            job.error, job.finished = WorkerError(ENDED_EARLY), time.monotonic()
        else:
            read_progress(Path(self._folder.name, f"{job.number}.progress"), job)

    def is_alive(self):
        return self._process.poll() is None

    def kill(self):
        self._process.kill()
        self._process.stdin.close()
        self._process.wait()
        self._folder.cleanup()


def start(function):
    """Begin function(report) in the operators' process: its Job."""
    job = Job(function)
    worker("operator").begin(job)
    return job


class Calculation:
    """A function of `report` as work for `InBackground`: it and its result can be pickled."""

    def __init__(self, function):
        self._function = function

    def start(self):
        """Begin in another process: a `Job`."""
        return start(self._function)

    def run(self):
        """Do it here and now: the result."""
        return self._function(silent)


def worker(name):
    """The worker of this name, begun where there is none alive."""
    if name not in _workers or not _workers[name].is_alive():
        _workers[name] = Worker()
    return _workers[name]


def unregister():
    """End all workers."""
    for found in _workers.values():
        found.kill()
    _workers.clear()
