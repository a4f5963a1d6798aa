"""Work off the window's process, so that it stays alive: see `worker`.

`start` runs one piece of work at once, for operators. `ask` answers panels: answers are kept by key, and what is
missing is worked out in another process, in the order in which panels draw it, as long as they show it.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections import OrderedDict
from pathlib import Path

import bpy

from .tasks import silent

_KEPT = 64                  # answers; the oldest are forgotten
_INTERVAL = 0.1             # s, between two looks at the workers
_REDRAW = 0.5               # s, between two redraws while they work
_UNWANTED = 2.0             # s, after which a question is dropped that no panel has asked again
_ENDED_EARLY = "The fitting process has ended early: it was killed, or memory ran out"
_PACKAGE = __package__.rpartition(".addon")[0]
_answers = OrderedDict()    # key: the job that was finished last, or else the one that is under way
_workers = {}               # name: Worker
_drawn = 0.0                # when the panels were last told to draw


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
        command = [sys.executable, *bpy.app.python_args, str(root / "addon" / "jobs" / "worker.py"), _PACKAGE, str(root),
                   self._folder.name]
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
            job.error, job.finished = WorkerError(_ENDED_EARLY), time.monotonic()
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
    _worker("operator").begin(job)
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


class _Lane:
    """Questions that wait for one worker: (key, job, then), in the order in which they were asked first."""

    def __init__(self, name):
        self.name, self.queue, self.running = name, [], None

    def pending(self):
        """All questions without an answer."""
        return [*self.queue, self.running] if self.running else self.queue

    def drop_unwanted(self, now):
        """Forget what no panel shows any more."""
        for item in self.pending()[:]:
            key, job, _ = item
            if now - job.asked < _UNWANTED:
                continue
            if _answers.get(key) is job:
                del _answers[key]
            if item is self.running:
                self.running = None
                job.cancel()
            else:
                self.queue.remove(item)

    def tend(self):
        """Take an answer and pass on the next question: whether there was an answer."""
        answered = self.running is not None and self.running[1].poll()
        if answered:
            _keep(*self.running)
            self.running = None
        if self.running is None and self.queue:
            self.running = self.queue.pop(0)
            _worker(self.name).begin(self.running[1])
        return answered


_lanes = {name: _Lane(name) for name in ("read", "fit", "slow")}


def ask(key, function, lane="fit", then=None, max_age=None):
    """The Job that answers a question, finished or not. Whoever wants an answer goes on asking until it is there.

    Parameters
    ----------
    key : hashable
        The question.
    function : callable
        As `Job` takes it.
    lane : {"read", "fit", "slow"}
        Questions wait only for others of their lane.
    then : callable, optional
        Takes the finished job.
    max_age : float, optional
        Seconds after which the question is asked anew; until that is answered, the old answer stands.
    """
    lane, now = _lanes[lane], time.monotonic()
    job = _answers.get(key)
    for other, waiting, _ in lane.pending():
        if other == key:
            waiting.asked = now
            return job
    if job is not None and job.finished is not None:
        _answers.move_to_end(key)
        if max_age is None or now - job.finished < max_age:
            return job
    new = Job(function)
    new.asked = now
    if job is None:
        job = _answers[key] = new
    lane.queue.append((key, new, then))
    if not bpy.app.timers.is_registered(_tend):
        bpy.app.timers.register(_tend, persistent=True)
    return job


def known(key):
    """The answer to a question, or None where there is none yet."""
    return _answers[key].result if key in _answers else None


def answer_all():
    """Answer every question now, in this process: for scripts, where no timer runs."""
    for lane in _lanes.values():
        while lane.queue:
            key, job, then = lane.queue.pop(0)
            job.result, job.finished = job.function(silent), time.monotonic()
            _keep(key, job, then)


def redraw():
    """Draw the editors that show measured materials anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def _tend():
    """See to the lanes: a timer, until there is nothing left to do."""
    global _drawn
    now = time.monotonic()
    answered = False
    for lane in _lanes.values():
        lane.drop_unwanted(now)
        answered |= lane.tend()
    if answered or now - _drawn > _REDRAW:      # a panel that is drawn asks again for what it shows
        _drawn = now
        redraw()
    return _INTERVAL if any(lane.running for lane in _lanes.values()) else None


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
    for lane in _lanes.values():
        lane.queue, lane.running = [], None
    _answers.clear()
    if bpy.app.timers.is_registered(_tend):
        bpy.app.timers.unregister(_tend)
    for worker in _workers.values():
        worker.kill()
    _workers.clear()
