"""Work off the main thread, so that the window stays alive. What is done here must not touch bpy.

`start` runs one piece of work in a thread of its own, for operators. `ask` answers panels: results are kept by key, and
what is missing is worked out by one thread, the latest question first.
"""

import threading
import time
from collections import OrderedDict

import bpy

_KEPT = 64                  # results; the oldest are forgotten
_PENDING = 12               # questions; a slider that is dragged asks many, which nobody waits for later
_jobs = OrderedDict()       # key: the latest finished job, or the one under way
_queue = []                 # (key, job), the next to be done last
_finished = []              # (job, what to do on the main thread)
_lock = threading.Lock()
_worker = None


class Cancelled(Exception):  # noqa: N818, as concurrent.futures.CancelledError
    """Raised within a piece of work by `Job.report`, once it is no longer wanted."""


class Job:
    """A piece of work and what has become of it.

    Attributes
    ----------
    fraction : float
    doing : str
        How far it is, and at what.
    result, error
        What the function returned, or the exception that it raised.
    finished : float, or None
        When, by `time.monotonic`.
    unwanted : bool
        Whether it has been cancelled.
    """

    def __init__(self, function):
        self._function, self.unwanted = function, False
        self.fraction, self.doing = 0.0, ""
        self.result = self.error = self.finished = None

    def report(self, fraction, doing):
        """Say how far the work is; called by the work itself, between its steps."""
        if self.unwanted:
            raise Cancelled
        self.fraction, self.doing = fraction, doing

    def cancel(self):
        """Let the work end at its next step; its result is dropped."""
        self.unwanted = True

    def run(self):
        """Do the work, in whatever thread this is."""
        try:
            self.result = self._function(self.report)
        except Cancelled:
            pass
        except Exception as error:      # whoever asked decides what it means
            self.error = error
        self.finished = time.monotonic()


def start(function):
    """Run function(report) in a thread of its own: its Job."""
    job = Job(function)
    threading.Thread(target=job.run, daemon=True).start()
    return job


def ask(key, function, then=None, max_age=None):
    """The Job that answers a question, finished or not.

    Parameters
    ----------
    key : hashable
        The question.
    function : callable
        Takes `Job.report`, returns the answer.
    then : callable, optional
        Takes the finished job, on the main thread.
    max_age : float, optional
        Seconds after which the question is asked anew; until then, and until it is answered, the old answer stands.
    """
    global _worker
    with _lock:
        job = _jobs.get(key)
        fresh = job is not None and (job.finished is None or max_age is None
                                     or time.monotonic() - job.finished < max_age)
        if fresh or any(asked == key for asked, *_ in _queue):
            _jobs.move_to_end(key)
            return job
        new = Job(function)
        _queue.append((key, new, then))
        if job is None:
            job = _jobs[key] = new
        for dropped, *_ in _queue[:-_PENDING]:
            if _jobs[dropped].finished is None:
                del _jobs[dropped]
        del _queue[:-_PENDING]
        if _worker is None:
            _worker = threading.Thread(target=_work, daemon=True)
            _worker.start()
    if not bpy.app.background and not bpy.app.timers.is_registered(_tell):
        bpy.app.timers.register(_tell, first_interval=0.1, persistent=True)
    return job


def forget():
    """Drop all questions and answers."""
    with _lock:
        for job in [*_jobs.values(), *(job for _, job, _ in _queue)]:
            job.cancel()
        _jobs.clear(), _queue.clear(), _finished.clear()


def redraw():
    """Draw the editors that show measured materials anew."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


def _work():
    global _worker
    while True:
        with _lock:
            if not _queue:
                _worker = None
                return
            key, job, then = _queue.pop()
        job.run()
        with _lock:
            if key in _jobs:
                _jobs[key] = job
                _jobs.move_to_end(key)
                _finished.append((job, then))
            while len(_jobs) > _KEPT:
                _jobs.popitem(last=False)


def _tell():
    """Hand over what has been finished, on the main thread, until there is no more."""
    with _lock:
        told, busy = _finished[:], _worker is not None
        _finished.clear()
    for job, then in told:
        if then is not None and job.error is None:
            then(job)
    if told:
        redraw()
    return 0.1 if busy else None


def unregister():
    forget()
    if bpy.app.timers.is_registered(_tell):
        bpy.app.timers.unregister(_tell)
