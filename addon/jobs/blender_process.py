"""A second Blender, without a window, that works on .blend files: the open file is not touched.

It runs one of the commands of `command`, which says how far it is and what came of it in files of a folder (`Report`).
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy

from ...fitter.files import replacing
from .process import Job, WorkerError, read_progress

_ROOT = Path(__file__).parents[2]
_LAST_LINES = 5             # of what a Blender said that failed without a report


class CommandError(RuntimeError):
    """A command could not do its work; the message says why."""


class Report:
    """What a command says to whoever started its process: progress, and a result that JSON can hold."""

    def __init__(self, folder):
        self._folder = Path(folder)

    def progress(self, fraction, doing):
        """Say how far the command is, at what."""
        (self._folder / "progress").write_text(f"{fraction} {doing}", "utf-8")

    def result(self, value):
        """Say what came of it."""
        with replacing(self._folder / "result.json", "w") as stream:
            json.dump(value, stream)


class BlenderProcess:
    """A process that runs one command: a worker as `background.Job` knows it."""

    def __init__(self, arguments):
        self._folder = tempfile.TemporaryDirectory(prefix="measured_brdf_")
        with open(Path(self._folder.name, "log"), "wb") as log:
            self._process = subprocess.Popen(
                [*_command_line(), "--report-to", self._folder.name, *map(str, arguments)], stdin=subprocess.DEVNULL,
                stdout=log, stderr=subprocess.STDOUT, creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
                env=os.environ | {"PYTHONPATH": ""})

    def poll(self, job):
        """Tell a job how far the command is, and whether it has ended."""
        ended = not self.is_alive()         # asked first: what it wrote before its end is there then
        read_progress(Path(self._folder.name, "progress"), job)
        if ended:
            job.finished = time.monotonic()
            try:
                job.result = json.loads(Path(self._folder.name, "result.json").read_text("utf-8"))
                if "error" in job.result:
                    job.error = CommandError(job.result["error"])
            except (OSError, ValueError):
                job.error = WorkerError(f"Blender ended early, with exit code {self._process.returncode}"
                                        f"{self._last_words()}")
            self.kill()

    def is_alive(self):
        return self._process.poll() is None

    def kill(self):
        self._process.kill()
        self._process.wait()
        self._folder.cleanup()

    def _last_words(self):
        log = Path(self._folder.name, "log").read_text("utf-8", "replace").strip().splitlines()[-_LAST_LINES:]
        return ": " + " / ".join(log) if log else ""


class Command:
    """A command as work for `InBackground`."""

    def __init__(self, *arguments):
        self._arguments = arguments

    def start(self):
        """Begin: a `background.Job`."""
        job = Job(None)
        job.worker = BlenderProcess(self._arguments)
        return job

    def run(self):
        """Wait for the result; raise what went wrong."""
        job = self.start()
        try:
            while not job.poll():
                time.sleep(0.02)
        finally:
            job.cancel()
        if job.error is not None:
            raise job.error
        return job.result


def _command_line():
    """What starts the commands in a Blender like this one: its executable, or Python where Blender is a module."""
    if bpy.app.binary_path:
        return [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python",
                str(_ROOT / "__main__.py"), "--"]
    return [sys.executable, *bpy.app.python_args, str(_ROOT / "__main__.py")]
