"""Jobs: pieces of work for another process, with their progress and result.

This module must not import bpy. Python keeps subscripted types such as `Job[Data]` until it exits, with their modules;
bpy 4.2 as a module crashes if something keeps it that long.
"""

import contextlib
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

_Result = TypeVar("_Result")
_SURE = 0.08                # of the work, done before it is said how long the rest takes,
_SOON = 3                   # s; and since when it runs, before which nobody asks


@dataclass(eq=False)
class Job(Generic[_Result]):
    """A piece of work, which can be pickled and tells `fitter.progress` how far it is, its progress and its result."""

    function: Callable[[], _Result] | None      # None for a Blender process
    worker: Any = None                  # the `process.ChildProcess` where it runs; None until it begins
    number: int = 0                     # of the job, for its `Worker`
    fraction: float = 0.0
    doing: str = "Starting"
    result: _Result | None = None
    error: Exception | None = None      # that the function raised
    finished: float | None = None       # when, by `time.monotonic`
    asked: float = 0.0                  # when a panel last asked for the result
    _began: float | None = None

    def time_left(self, now: float) -> str:
        """How long the rest takes at the pace since the first call, in words; empty while too little is known."""
        if self._began is None:
            self._began = now
        elapsed = now - self._began
        if self.finished is not None or elapsed < _SOON or not _SURE <= self.fraction < 1:
            return ""
        return f"about {_time_words(elapsed * (1 - self.fraction) / self.fraction)} left"

    def poll(self) -> bool:
        if self.worker is not None and self.finished is None:
            self.worker.poll(self)
        return self.finished is not None

    def cancel(self) -> None:
        if self.worker is not None and self.finished is None:
            self.worker.kill()


class Work(Protocol):
    """What an operator does in another process: a `process.Calculation`, or a `blender_process.Command`."""

    def start(self) -> Job[Any]: ...

    def run(self) -> Any: ...


def _time_words(seconds: float) -> str:
    if seconds >= 90:
        return f"{round(seconds / 60)} min"
    step = 5 if seconds > 10 else 1
    return f"{max(math.ceil(seconds / step), 1) * step} s"


def read_progress(path: Path, job: Job[Any]) -> None:
    with contextlib.suppress(OSError, ValueError):      # not there yet
        fraction, job.doing = path.read_text("utf-8").split(" ", 1)
        job.fraction = float(fraction)


def write_progress(path: Path, fraction: float, doing: str) -> None:
    """Put the progress where `read_progress` finds it, the whole or nothing of it."""
    part = path.with_name(f"{path.name}.part")
    with contextlib.suppress(OSError):      # Windows replaces no file that is being read: the next report will do
        part.write_text(f"{fraction} {doing}", "utf-8", "backslashreplace")      # names may be any bytes
        os.replace(part, path)
