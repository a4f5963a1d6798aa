"""On which device Cycles renders a scene, and whether it evaluates the shaders of measured materials there.

docs/devices.md tells what Cycles does on which device. Handlers ask after each change of a scene: Cycles lists devices
only where a scene wants another than the CPU, and once a session for each type.
"""

import argparse
import functools
import sys

import bpy

CPU = "CPU"
OPTIX = "OPTIX"
WITH_OSL = CPU, OPTIX
_NO_DEVICE = "", "NONE"
_AND_CPU = "+CPU"


def effective_device(scene: bpy.types.Scene) -> str:
    """The type of device that renders a scene, "CPU", "CUDA", "OPTIX", "HIP", "METAL" or "ONEAPI": the CPU too where
    none of the type chosen in the preferences is in use."""
    requested = _read_requested_device(tuple(sys.argv))
    if requested:
        return requested.removesuffix(_AND_CPU)
    settings = getattr(scene, "cycles", None)
    if settings is None or settings.device != "GPU":
        return CPU
    addon = bpy.context.preferences.addons.get("cycles")
    preferences = getattr(addon, "preferences", None)
    kind = getattr(preferences, "compute_device_type", "")
    if kind in _NO_DEVICE:
        return CPU
    used = {device.id for device in preferences.devices if device.use}
    return CPU if used.isdisjoint(_available(kind)) else str(kind)


def renders_on_gpu(scene: bpy.types.Scene) -> bool:
    """Whether a scene is rendered on a GPU, where few closures fit."""
    return effective_device(scene) != CPU


@functools.cache
def _available(kind: str) -> frozenset[str]:
    import _cycles

    return frozenset(device[2] for device in _cycles.available_devices(kind) if device[1] == kind)


@functools.cache
def _read_requested_device(arguments: tuple[str, ...]) -> str:
    own = arguments[arguments.index("--") + 1:] if "--" in arguments else ()      # not Blender's, but Cycles'
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--cycles-device", nargs="?")
    return (parser.parse_known_args(own)[0].cycles_device or "").upper()
