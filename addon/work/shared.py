"""What the worker processes of one Blender have worked out, so that none does again what another has done, or is doing.

A result is a file in a folder that `process` makes, and that goes with it. Whoever works one out holds its lock; others
wait for it, and tell its progress. This module must not import bpy.
"""

import contextlib
import hashlib
import os
import pickle
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from ...fitter import progress
from ...fitter.storage.files import hold_lock, replace_file
from .job import Job, read_progress, write_progress

_Result = TypeVar("_Result")

WORKERS_FOLDER = "MEASURED_BRDF_WORKERS_FOLDER"
"""The environment variable of a process that a Blender has started, which names the folder. Only workers share."""
_KEPT_RESULTS = 32          # results, a few MB each
_WAIT = 0.05                # s


def once(key: str, work: Callable[[], _Result]) -> _Result:
    """The result of work, from the folder if any process has done it before; what it raises is not kept."""
    if WORKERS_FOLDER not in os.environ:
        return work()
    name = hashlib.sha256(key.encode()).hexdigest()[:24]
    path = Path(os.environ[WORKERS_FOLDER], f"{name}.result")
    with _hold_result(path):
        with contextlib.suppress(OSError):      # not there, or just forgotten by another process
            os.utime(path)
            known: _Result = pickle.loads(path.read_bytes())
            return known
        with progress.listen_also(lambda fraction, doing: write_progress(_progress_path(path), fraction, doing)):
            result = work()
        with contextlib.suppress(OSError), replace_file(path) as stream:
            pickle.dump(result, stream)
    forget_oldest(path.parent, "*.result", _KEPT_RESULTS)
    return result


@contextlib.contextmanager
def _hold_result(path: Path) -> Iterator[None]:
    """Hold the lock of a result; tell the progress of the process that has it until then."""
    with contextlib.ExitStack() as held:
        while True:
            try:
                held.enter_context(hold_lock(path))
                break
            except BlockingIOError:
                other = Job[Any](None)
                read_progress(_progress_path(path), other)
                progress.report(other.fraction, other.doing)
                time.sleep(_WAIT)
            except OSError:     # there is no lock to be had: two processes may do the same work
                break
        yield


def _progress_path(path: Path) -> Path:
    return path.with_suffix(".progress")


def forget_oldest(folder: Path, pattern: str, kept: int) -> None:
    """Remove the files of a pattern in a folder but those that were written or used last."""
    with contextlib.suppress(OSError):      # another process may be at it, too
        for path in sorted(folder.glob(pattern), key=lambda each: each.stat().st_mtime_ns)[:-kept]:
            path.unlink(missing_ok=True)
