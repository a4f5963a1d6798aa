"""What the worker processes of one Blender have worked out, so that none does again what another has done, or is doing.

A result is a file in a folder that `process` makes, and that goes with it. Whoever works one out holds a lock; others
wait for it, and tell its progress. The system takes the lock from a process that is killed. This module must not import
bpy.
"""

import contextlib
import hashlib
import os
import pickle
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from ...fitter import progress
from ...fitter.storage.files import replace_file
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
    with open(path.with_suffix(".lock"), "ab") as stream:
        while not _try_to_lock(stream.fileno()):
            other = Job[Any](None)
            read_progress(_progress_path(path), other)
            progress.report(other.fraction, other.doing)
            time.sleep(_WAIT)
        yield                   # closing the file unlocks it


def _progress_path(path: Path) -> Path:
    return path.with_suffix(".progress")


def forget_oldest(folder: Path, pattern: str, kept: int) -> None:
    """Remove the files of a pattern in a folder but those that were written or used last."""
    with contextlib.suppress(OSError):      # another process may be at it, too
        for path in sorted(folder.glob(pattern), key=lambda each: each.stat().st_mtime_ns)[:-kept]:
            path.unlink(missing_ok=True)


# Some file systems have no locks, and say so by another error than that a file is locked: there, two processes may do
# the same work.
if sys.platform == "win32":
    import msvcrt

    def _try_to_lock(file: int) -> bool:
        os.lseek(file, 0, os.SEEK_SET)
        with contextlib.suppress(OSError):
            try:
                msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
            except PermissionError:
                return False
        return True
else:
    import fcntl

    def _try_to_lock(file: int) -> bool:
        with contextlib.suppress(OSError):
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return False
        return True
