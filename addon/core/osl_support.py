"""Whether this Blender supports OSL, and where it keeps the parts of the compiler."""

import functools
import importlib.util
import sys
from pathlib import Path

import bpy

NO_OSL = ("This Blender was built without OSL (Open Shading Language): measured materials are rendered by closure "
          "nodes, approximately. For exact ones, use a Blender from blender.org")


@functools.cache
def missing() -> str:
    """Why OSL shaders cannot be compiled here; empty if they can. Cached, because panels ask at every redraw."""
    add_module_path("oslquery")
    try:
        import _cycles
    except ImportError:
        return "Cycles is not available in this Blender"
    without_compiler = not getattr(_cycles, "with_osl", False) or not hasattr(_cycles, "osl_compile")
    without_query = bpy.app.version >= (4, 5, 0) and importlib.util.find_spec("oslquery") is None
    return NO_OSL if without_compiler or without_query else ""


def enable(scene: bpy.types.Scene) -> None:
    """Let Cycles render the scene with OSL."""
    setattr(scene.render, "engine", "CYCLES")       # noqa: B010  the stubs know EEVEE only
    scene.cycles.shading_system = True


def add_module_path(name: str) -> None:
    """Make a module that Blender has importable: Blender as a Python module has it in a folder that is not on the path.
    """
    if importlib.util.find_spec(name) is not None:
        return
    local = Path(bpy.utils.resource_path("LOCAL"))
    for folder in sorted(local.glob("python/lib/python3.*/site-packages")):
        if any(folder.glob(f"{name}*")):
            sys.path.append(str(folder))
