"""Work off the window's process, so that it stays alive: see `worker`.

`start` runs one piece of work at once, for operators. `ask` answers panels: answers are kept by key, and what is
missing is worked out in another process, the latest question first.
"""

import pickle
import subprocess
import sys
import tempfile
import time
from collections import OrderedDict
from pathlib import Path

import bpy

from .work import silent

_KEPT = 64                  # answers; the oldest are forgotten
_PENDING = 12               # questions; a slider that is dragged asks many, which nobody waits for later
_INTERVAL = 0.1             # s
_PACKAGE = __package__.rpartition(".")[0]
_answers = OrderedDict()    # key: the job that was finished last, or else the one that is under way
_queue = []                 # (key, job, then), the next one last
_asked = None               # the one that is being answered
_workers = {}               # "operator" and "panel": Worker


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
    finished : float, or None
        When, by `time.monotonic`.
    """

    def __init__(self, function):
        self.function, self.worker = function, None
        self.fraction, self.doing = 0.0, "Starting"
        self.result = self.error = self.finished = None

    def poll(self):
        """Take what the worker has said meanwhile: whether the work is finished."""
        if self.worker is not None and self.finished is None:
            self.worker.poll(self)
        return self.finished is not None

    def cancel(self):
        """End the work, wherever it is."""
        if self.worker is not None and self.finished is None:
            self.worker.kill()


class Worker:
    """A process that does one piece of work at a time, and the folder through which it answers."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="measured_brdf_")
        root = Path(__file__).parents[1]
        self._process = subprocess.Popen(
            [sys.executable, *bpy.app.python_args, str(root / "addon" / "worker.py"), _PACKAGE, str(root),
             self._folder.name],
            stdin=subprocess.PIPE, creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0))
        self._count = 0

    def begin(self, job):
        self._count += 1
        job.worker, job.number = self, self._count
        pickle.dump((job.number, job.function), self._process.stdin)
        self._process.stdin.flush()

    def poll(self, job):
        done = Path(self._folder.name, f"{job.number}.done")
        try:
            if done.exists():
                job.result, job.error = pickle.loads(done.read_bytes())
                job.finished = time.monotonic()
                done.unlink()
            elif not self.is_alive():
                job.error, job.finished = RuntimeError("The fitting process has ended early"), time.monotonic()
            else:
                fraction, job.doing = Path(self._folder.name, f"{job.number}.progress").read_text("utf-8").split(" ", 1)
                job.fraction = float(fraction)
        except (OSError, ValueError):
            pass                        # not there yet, or half written: next time

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
    _worker("operator").begin(job)
    return job


def finished():
    """A Job that has been done already, where there is nothing to do."""
    job = Job(None)
    job.finished = time.monotonic()
    return job


def ask(key, function, then=None, max_age=None):
    """The Job that answers a question, finished or not.

    Parameters
    ----------
    key : hashable
        The question.
    function : callable
        As `Job` takes it.
    then : callable, optional
        Takes the finished job.
    max_age : float, optional
        Seconds after which the question is asked anew; until that is answered, the old answer stands.
    """
    job = _answers.get(key)
    if job is not None:
        _answers.move_to_end(key)
        fresh = job.finished is None or max_age is None or time.monotonic() - job.finished < max_age
        if fresh or any(asked[0] == key for asked in [*_queue, _asked or (None,)]):
            return job
    new = Job(function)
    if job is None:
        job = _answers[key] = new
    _queue.append((key, new, then))
    for dropped, *_ in _queue[:-_PENDING]:
        if _answers[dropped].finished is None:
            del _answers[dropped]
    del _queue[:-_PENDING]
    if not bpy.app.timers.is_registered(_tend):
        bpy.app.timers.register(_tend, persistent=True)
    return job


def answer_all():
    """Answer every question now, in this process: for scripts, where no timer runs."""
    while _queue:
        key, job, then = _queue.pop()
        job.result, job.finished = job.function(silent), time.monotonic()
        _keep(key, job, then)


def redraw():
    """Draw the editors that show measured materials anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def _tend():
    """Take answers, and pass on the next question: a timer, until there are no more."""
    global _asked
    if _asked is not None and _asked[1].poll():
        _keep(*_asked)
        _asked = None
        redraw()
    if _asked is None and _queue:
        _asked = _queue.pop()
        _worker("panel").begin(_asked[1])
    return None if _asked is None else _INTERVAL


def _keep(key, job, then):
    _answers[key] = job
    _answers.move_to_end(key)
    while len(_answers) > _KEPT:
        _answers.popitem(last=False)
    if then is not None and job.error is None:
        then(job)


def _worker(name):
    if name not in _workers or not _workers[name].is_alive():
        _workers[name] = Worker()
    return _workers[name]


def unregister():
    global _asked
    _asked = None
    _queue.clear(), _answers.clear()
    if bpy.app.timers.is_registered(_tend):
        bpy.app.timers.unregister(_tend)
    for worker in _workers.values():
        worker.kill()
    _workers.clear()
