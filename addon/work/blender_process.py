"""A second Blender, without a window, that changes .blend files; the open file is not touched.

It runs a command of `command`, which writes its progress and its result into files of a folder (`Report`).
"""

import json
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

import bpy

from ...fitter.storage.files import replace_file
from . import process, shared
from .job import Job, read_progress, write_progress
from .process import WorkerError
from .worker import leave

_ROOT = Path(__file__).parents[2]
_LAST_LINES = 5             # of the log, for the error message where a Blender ended without a result


class CommandError(RuntimeError):
    """A command failed; the message says why."""


class Report:
    """Tells the process that started a command its progress, and its result (anything that JSON holds)."""

    def __init__(self, folder: str | Path) -> None:
        self._folder = Path(folder)

    def progress(self, fraction: float, doing: str) -> None:
        write_progress(self._folder / "progress", fraction, doing)

    def result(self, value: Any) -> None:
        with replace_file(self._folder / "result.json", "w") as stream:
            json.dump(value, stream)


class BlenderProcess(process.ChildProcess):
    """A process that runs one command; a worker of `process.Job`."""

    def __init__(self, arguments: tuple[object, ...]) -> None:
        super().__init__()
        # whatever it leaves if it is killed lies in the folder of this Blender, too
        environment = {"PYTHONPATH": "", **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), self._folder.name)}
        with open(Path(self._folder.name, "log"), "wb") as log:
            self._start([*_command_line(), "--report-to", self._folder.name, *map(str, arguments)], environment,
                        stdout=log, stderr=log)

    def poll(self, job: Job[Any]) -> None:
        """Update the job's progress, and its result once the process has ended."""
        ended = not self.is_alive()         # before reading: then everything it wrote is there
        read_progress(Path(self._folder.name, "progress"), job)
        if ended:
            job.finished = time.monotonic()
            try:
                job.result = result = json.loads(Path(self._folder.name, "result.json").read_text("utf-8"))
                if "error" in result:
                    job.error = CommandError(result["error"])
            except (OSError, ValueError):
                log = Path(self._folder.name, "log").read_text("utf-8", "replace").strip().splitlines()
                said = ": " + " / ".join(log[-_LAST_LINES:]) if log else ""
                job.error = WorkerError(f"Blender ended early, with exit code {self._process.returncode}{said}")
            self.kill()


class Command:
    """A command as the work of an operator."""

    def __init__(self, *arguments: object) -> None:
        self._arguments = arguments

    def start(self) -> Job[Any]:
        job = Job[Any](None)
        job.worker = BlenderProcess(self._arguments)
        return job

    def run(self) -> Any:
        job = self.start()
        try:
            while not job.poll():
                time.sleep(0.02)
        finally:
            job.cancel()
        if job.error is not None:
            raise job.error
        return job.result


def end_with_parent() -> None:
    """If this Blender is a `BlenderProcess`, let it end with the one that has started it, whatever ends that."""
    folder = os.environ.pop(shared.WORKERS_FOLDER, None)
    if folder is not None:
        threading.Thread(target=_wait, args=(folder,), daemon=True).start()


def _wait(folder: str) -> None:
    os.read(0, 1)                   # nothing is ever written
    leave(folder)


def _command_line() -> list[str]:
    """How to start a Blender like this one: its executable, or Python if Blender is a module."""
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python",
                str(_ROOT / "__main__.py"), "--"]
    return [sys.executable, *bpy.app.python_args, str(_ROOT / "__main__.py")]
