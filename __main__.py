"""The command line of the bpy module, without Blender's executable: ``python -m measured_brdf convert|render|starter``.

In a checkout with any folder name: ``python . convert ...``.
"""

import contextlib
import importlib.util
import os
import runpy
import shutil
import sys
import traceback
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import NoReturn, cast


def main() -> int:
    """Load this folder as the package that Blender makes of it, and run one command."""
    root = Path(__file__).resolve().parent
    runpy.run_path(str(root / "fitter" / "interrupts.py"))["end_at_once"]()     # until what takes long is imported
    spec = cast(ModuleSpec, importlib.util.spec_from_file_location("measured_brdf", root / "__init__.py",
                                                                   submodule_search_locations=[str(root)]))
    package = sys.modules["measured_brdf"] = importlib.util.module_from_spec(spec)
    if spec.loader is not None:
        spec.loader.exec_module(package)
    package.register()
    try:
        from measured_brdf.addon.work import blender_process, command

        blender_process.end_with_parent()
        exit_code: int = command.main(_arguments())
        return exit_code
    finally:
        package.unregister()


def _arguments() -> list[str]:
    """The arguments of the command: with Blender's own executable, those after "--"."""
    if "--python" in sys.argv:
        return sys.argv[sys.argv.index("--") + 1:]
    return sys.argv[1:]


def _leave(exit_code: int) -> NoReturn:
    """End this process with an exit code, at once: at an end of its own, Blender 4.2 as a module crashes, and 4.5 waits
    forever for a thread."""
    import bpy

    session = Path(bpy.app.tempdir)
    if session.name.startswith("blender_"):         # else it is the folder of all temporary files
        shutil.rmtree(session, ignore_errors=True)
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError):          # who reads it may have gone
            stream.flush()
    os._exit(exit_code)


if __name__ == "__main__":
    try:
        _leave(main())
    except SystemExit as end:                       # of arguments that are wrong
        _leave(int(end.code or 0))
    except BaseException:
        traceback.print_exc()
        _leave(1)
