"""Questions of panels, answered in other processes (`process`).

Answers are kept by key. What is missing is worked out in the order in which panels draw it, as long as they show it.
"""

import time
from collections import OrderedDict

import bpy

from .process import Job, worker
from .tasks import silent

_KEPT = 64                  # answers; the oldest are forgotten
_INTERVAL = 0.1             # s, between two looks at the workers
_REDRAW = 0.5               # s, between two redraws while they work
_UNWANTED = 2.0             # s, after which a question is dropped that no panel has asked again
_answers = OrderedDict()    # key: the job that was finished last, or else the one that is under way
_drawn = 0.0                # when the panels were last told to draw


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
            worker(self.name).begin(self.running[1])
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


def unregister():
    for lane in _lanes.values():
        lane.queue, lane.running = [], None
    _answers.clear()
    if bpy.app.timers.is_registered(_tend):
        bpy.app.timers.unregister(_tend)
