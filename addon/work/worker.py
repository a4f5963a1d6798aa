"""The process that does long work: python worker.py PACKAGE ROOT FOLDER.

Python threads that outlive a script crash Blender. So work goes to this process, which has the modules of the extension
under the same names, but no bpy. It reads pickled pairs (number, function) from standard input, calls
function(report), and writes (result, exception) to FOLDER/number.done and the progress to FOLDER/number.progress. It
ends at the end of its standard input.
"""

import importlib
import os
import pickle
import sys
import time
import types
from pathlib import Path

_INTERVAL = 0.05            # s, between two reports of the same doing


def serve(package: str, folder: Path) -> None:
    """Do work until the input ends."""
    progress = importlib.import_module(f"{package}.fitter.progress")
    write_progress = importlib.import_module(f"{package}.addon.work.job").write_progress
    while True:
        try:
            number, function = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        told = 0.0, ""

        def tell(fraction: float, doing: str, path: Path = folder / f"{number}.progress") -> None:
            nonlocal told
            now = time.monotonic()
            if doing != told[1] or now - told[0] > _INTERVAL:
                told = now, doing
                write_progress(path, fraction, doing)

        answer: tuple[object, Exception | None]
        try:
            with progress.listening(tell):
                answer = function(progress.report), None
        except Exception as error:      # the job raises it again, or reports it
            answer = None, error
        part = folder / f"{number}.part"
        part.write_bytes(_pickled(answer))
        os.replace(part, folder / f"{number}.done")


def _pickled(answer: tuple[object, Exception | None]) -> bytes:
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
    del sys.path[0]                     # this file's folder: its modules must not be importable by their bare names
    install_packages(sys.argv[1], Path(sys.argv[2]))
    serve(sys.argv[1], Path(sys.argv[3]))
