"""The process in which long work is done: python worker.py PACKAGE ROOT FOLDER.

Blender is not made for Python threads that outlive a script: they crash it. So work goes to a process that has the
extension's modules by the same names, but no bpy. Pieces of work arrive on standard input, pickled, as (number,
function); function(report) is called, and FOLDER/number.done holds (result, exception) once it is there. How far the
work is stands in FOLDER/number.progress. The process ends with its standard input.
"""

import os
import pickle
import sys
import types
from pathlib import Path


def serve(folder):
    """Do work until there is no more."""
    while True:
        try:
            number, function = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        progress = folder / f"{number}.progress"

        def report(fraction, doing, progress=progress):
            progress.write_text(f"{fraction} {doing}", "utf-8")

        try:
            answer = function(report), None
        except Exception as error:      # whoever asked decides what it means
            answer = None, error
        part = folder / f"{number}.part"
        part.write_bytes(_pickled(answer))
        os.replace(part, folder / f"{number}.done")


def _pickled(answer):
    try:
        return pickle.dumps(answer)
    except Exception as error:          # exceptions of other libraries need not be picklable
        return pickle.dumps((None, RuntimeError(f"{answer[1] or answer[0]!r}: {error}")))


def be(package, root):
    """Make the modules of the extension importable by the names that they have in Blender, without its __init__."""
    parts = package.split(".")
    for end in range(1, len(parts) + 1):
        module = types.ModuleType(".".join(parts[:end]))
        module.__path__ = [str(root)]
        sys.modules[module.__name__] = module
    addon = types.ModuleType(f"{package}.addon")
    addon.__path__ = [str(root / "addon")]
    sys.modules[addon.__name__] = addon


if __name__ == "__main__":
    del sys.path[0]                     # the folder of this file: its modules are not to be found by their bare names
    be(sys.argv[1], Path(sys.argv[2]))
    serve(Path(sys.argv[3]))
