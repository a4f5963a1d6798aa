"""The process that does long work: python -P worker.py PACKAGE ROOT FOLDER.

Python threads that outlive a script crash Blender. So work goes to this process, which has the modules of the extension
under the same names, but no bpy. It reads pickled pairs (number, function) from standard input, writes (result,
exception) to FOLDER/number.done and the progress to FOLDER/number.progress, and ends with its input, as Blender does.
"""

import importlib
import os
import pickle
import queue
import shutil
import signal
import sys
import threading
import time
import traceback
import types
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

_REPORT_INTERVAL = 0.05     # s, between two reports of the same doing
_ATTEMPTS, _REMOVAL_PAUSE = 20, 0.05  # to remove folders in which other processes may just write; s


def serve(package: str, folder: Path) -> None:
    progress = importlib.import_module(f"{package}.fitter.progress")
    write_progress = importlib.import_module(f"{package}.addon.work.job").write_progress
    common = os.environ[importlib.import_module(f"{package}.addon.work.shared").WORKERS_FOLDER]
    jobs: queue.SimpleQueue[tuple[int, Callable[..., object]]] = queue.SimpleQueue()
    threading.Thread(target=_receive, args=(jobs, common), daemon=True).start()
    while True:
        number, function = jobs.get()
        told = 0.0, ""

        def tell(fraction: float, doing: str, path: Path = folder / f"{number}.progress") -> None:
            nonlocal told
            now = time.monotonic()
            if doing != told[1] or now - told[0] > _REPORT_INTERVAL:
                told = now, doing
                write_progress(path, fraction, doing)

        answer: tuple[object, Exception | None]
        try:
            with progress.listen(tell):
                answer = function(), None
        except Exception as error:      # the job raises it again, or reports it
            answer = None, error
        part = folder / f"{number}.part"
        try:
            part.write_bytes(_pickle(answer))
        except OSError as error:        # a full disk has room for this
            part.write_bytes(_pickle((None, OSError(error.errno, error.strerror, str(folder)))))
        os.replace(part, folder / f"{number}.done")


def _receive(jobs: "queue.SimpleQueue[tuple[int, Callable[..., object]]]", common: str) -> None:
    """Pass on the jobs that arrive; at the end of the input, end the process, which may be in the middle of one."""
    with open(0, "rb", closefd=False) as stream:        # Python cannot end while a thread waits in its own sys.stdin
        try:
            while True:
                jobs.put(pickle.load(stream))
        except EOFError:
            leave(common)
        except Exception:
            traceback.print_exc()
            os._exit(1)


def leave(folder: str) -> NoReturn:
    """Remove the folder of a Blender that has ended, and end this process, whatever its threads do."""
    for _ in range(_ATTEMPTS):
        shutil.rmtree(folder, ignore_errors=True)
        if not Path(folder).exists():
            break
        time.sleep(_REMOVAL_PAUSE)
    os._exit(1)


def _pickle(answer: tuple[object, Exception | None]) -> bytes:
    try:
        return pickle.dumps(answer)
    except Exception as error:          # some exceptions of other libraries cannot be pickled
        return pickle.dumps((None, RuntimeError(f"{answer[1] or answer[0]!r}: {error}")))


def install_packages(package: str, root: Path) -> None:
    """Make the modules of the extension importable under the names that they have in Blender, without its __init__."""
    parts = package.split(".")
    for end in range(1, len(parts) + 1):
        _install(".".join(parts[:end]), root)
    for folder in (root / "addon", *(each for each in (root / "addon").iterdir() if each.is_dir())):
        _install(".".join((package, *folder.relative_to(root).parts)), folder)


def _install(name: str, folder: Path) -> None:
    module = types.ModuleType(name)
    module.__path__ = [str(folder)]
    sys.modules[name] = module


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_IGN)        # of the terminal: the process that gives work says what ends
    install_packages(sys.argv[1], Path(sys.argv[2]))
    serve(sys.argv[1], Path(sys.argv[3]))
