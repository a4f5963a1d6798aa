"""Whether this Blender supports OSL, and where it keeps the parts of the compiler."""

import functools
import importlib.util
import sys
from importlib.machinery import PathFinder
from pathlib import Path

import bpy

NO_OSL = ("This Blender was built without OSL (Open Shading Language): measured materials are rendered by ordinary "
          "nodes, approximately. For exact ones, use a Blender from blender.org")


@functools.cache
def reason_unavailable() -> str:
    """Why OSL shaders cannot be compiled here; empty if they can. Cached, because panels ask at every redraw."""
    make_importable("OpenImageIO")      # oslquery imports it
    make_importable("oslquery")
    try:
        import _cycles
    except ImportError:
        return "Cycles is not available in this Blender"
    without_compiler = not getattr(_cycles, "with_osl", False) or not hasattr(_cycles, "osl_compile")
    without_query = bpy.app.version >= (4, 5, 0) and importlib.util.find_spec("oslquery") is None
    return NO_OSL if without_compiler or without_query else ""


def enable(scene: bpy.types.Scene) -> None:
    setattr(scene.render, "engine", "CYCLES")       # noqa: B010  the stubs know EEVEE only
    scene.cycles.shading_system = True


def make_importable(name: str) -> None:
    """Load a module that Blender has but, as a Python module itself, does not find: it lies in Blender's own folder."""
    if importlib.util.find_spec(name) is not None:
        return
    folders = Path(bpy.utils.resource_path("LOCAL")).glob("python/lib/python3.*/site-packages")
    spec = PathFinder.find_spec(name, sorted(map(str, folders)))
    if spec is not None and spec.loader is not None:
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
