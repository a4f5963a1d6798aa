"""What this Blender can do with OSL, and where the compiler's parts lie."""

import functools
import importlib.util
import sys
from pathlib import Path

import bpy

NO_OSL = ("This Blender was built without OSL (Open Shading Language), which measured materials need. "
          "Use a Blender from blender.org, or its LTS builds")


@functools.cache
def missing():
    """Why OSL shaders cannot be compiled here, or an empty string. Looked up once: panels ask at every redraw."""
    _add_module_path()
    try:
        import _cycles
    except ImportError:
        return "Cycles is not available in this Blender"
    without_compiler = not getattr(_cycles, "with_osl", False) or not hasattr(_cycles, "osl_compile")
    without_query = bpy.app.version >= (4, 5, 0) and importlib.util.find_spec("oslquery") is None
    return NO_OSL if without_compiler or without_query else ""


def is_enabled(scene):
    """Whether the scene is rendered by Cycles with OSL."""
    return scene.render.engine == "CYCLES" and scene.cycles.shading_system


def enable(scene):
    """Render the scene by Cycles with OSL."""
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True


def _add_module_path():
    """Let `oslquery` be found: in Blender as a Python module it lies beside it, off the path."""
    if importlib.util.find_spec("oslquery") is not None:
        return
    local = Path(bpy.utils.resource_path("LOCAL"))
    for folder in sorted(local.glob("python/lib/python3.*/site-packages")):
        if any(folder.glob("oslquery*")):
            sys.path.append(str(folder))
