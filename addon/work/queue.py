"""Questions of panels, which worker processes answer in the order in which panels ask, for as long as they ask."""

import time
from collections.abc import Callable, Hashable
from typing import Any, NamedTuple, TypeVar

import bpy

from .job import Job
from .process import worker
from .recent import Recent

_Answer = TypeVar("_Answer")
_Then = Callable[[Job[Any]], object] | None

_INTERVAL = 0.1             # s, between two polls of the workers
_REDRAW = 0.5               # s, between two redraws while they work
_UNWANTED = 2.0             # s, after which a question is dropped that no panel has asked again
_answers: Recent[Hashable, Job[Any]] = Recent(64)       # by key: the last finished job, else the pending one
_drawn = 0.0                # when the panels were last redrawn


class _Question(NamedTuple):
    key: Hashable
    job: Job[Any]
    then: _Then         # is called with it when it has one


class _Lane:
    """Questions that wait for the same worker, in the order in which they were first asked."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.queue: list[_Question] = []
        self.running: _Question | None = None

    def pending(self) -> list[_Question]:
        return [*self.queue, self.running] if self.running else self.queue

    def drop(self, question: _Question) -> None:
        """Drop a question; a worker that is answering it ends."""
        if _answers.get(question.key) is question.job:
            del _answers[question.key]
        if question is self.running:
            self.running = None
            question.job.cancel()
        else:
            self.queue.remove(question)

    def drop_unwanted(self, now: float) -> None:
        for question in self.pending()[:]:
            if now - question.job.asked >= _UNWANTED:
                self.drop(question)

    def poll(self) -> bool:
        """Store an answer and start the next question: whether there was an answer."""
        answered = self.running is not None and self.running.job.poll()
        if self.running is not None and answered:
            _keep(self.running)
            self.running = None
        if self.running is None and self.queue:
            self.running = self.queue.pop(0)
            worker(self.name).begin(self.running.job)
        return answered


_lanes = {name: _Lane(name) for name in ("read", "fit", "slow")}


def ask(key: Hashable, function: Callable[[], _Answer], lane: str = "fit", then: _Then = None,
        max_age: float | None = None) -> Job[_Answer]:
    """The job that answers a question, finished or not. Callers ask again until there is an answer.

    Questions wait only for others of their lane: "read", "fit" or "slow". `then` is called with the finished job. After
    `max_age` seconds the question is asked again; the old answer is returned until there is a new one.
    """
    chosen, now = _lanes[lane], time.monotonic()
    job = _answers.get(key)
    for question in chosen.pending():
        if question.key == key:
            question.job.asked = now
            return job if job is not None else question.job
    if job is not None and job.finished is not None:
        _answers[key] = job             # used last
        if max_age is None or now - job.finished < max_age:
            return job
    new = Job(function)
    new.asked = now
    if job is None:
        job = _answers[key] = new
    chosen.queue.append(_Question(key, new, then))
    if not bpy.app.timers.is_registered(_poll):
        bpy.app.timers.register(_poll, persistent=True)
    return job


def forget(is_unwanted: Callable[[Hashable], bool]) -> None:
    """Drop the questions that wait and are not wanted any more, by their keys; one that is being answered is left."""
    for lane in _lanes.values():
        for question in [each for each in lane.queue if is_unwanted(each.key)]:
            lane.drop(question)


def redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()
            elif area.type == "VIEW_3D":                # the sidebar alone: its view would be drawn anew
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def _poll() -> float | None:
    """Poll all lanes: a timer, which runs until there is nothing to do."""
    global _drawn
    now = time.monotonic()
    answered = False
    for lane in _lanes.values():
        lane.drop_unwanted(now)
        answered |= lane.poll()
    if answered or now - _drawn > _REDRAW:      # a redrawn panel asks again for what it shows
        _drawn = now
        redraw()
    return _INTERVAL if any(lane.running for lane in _lanes.values()) else None


def _keep(question: _Question) -> None:
    key, job, then = question
    _answers[key] = job
    if then is not None and job.error is None:
        then(job)


def unregister() -> None:
    for lane in _lanes.values():
        lane.queue, lane.running = [], None
    _answers.clear()
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
