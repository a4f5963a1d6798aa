"""A .blend with a measured material, saved in one Blender and opened in another, for `tools.test_matrix`.

python -m tools.blend_file save|open FILE prints what it finds as a line of JSON.
"""

import json
import os
import sys
from pathlib import Path

from support import checkout
from support.stage import add_lamp, add_sphere, black_scene, render
from tools import fuzz

CHOICES = ("sample", "diffuse_level", "specular_level", "compression")


def main():
    """Do one of the two."""
    task, path = sys.argv[1], Path(sys.argv[2])
    checkout.extension().register()
    print("\n" + json.dumps({"save": _save, "open": _open}[task](path)), flush=True)
    os._exit(0)         # bpy 4.2 as a module does not survive an end of its own (`support.stage.EXITS`)


def _save(path):
    import bpy

    scene = black_scene(32, 32, samples=64, span=2)
    add_lamp("POINT", 100, (2, 1, 4), shadow_soft_size=0)
    add_sphere()
    measurements = path.with_suffix(".astm")
    measurements.write_bytes(fuzz.seeds()["astm, made"])
    bpy.ops.measured_brdf.import_data(filepath=str(measurements), diffuse_level=3, specular_level=5, compression=90.0)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return _found(scene)


def _open(path):
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(path))
    found = _found(bpy.context.scene)
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    return found | {"refitted": _found(bpy.context.scene)["mean"]}


def _found(scene):
    settings = next(item.active_material for item in scene.objects if item.type == "MESH").measured_brdf
    return {"mean": float(render(scene)[..., :3].mean()), "choices": [getattr(settings, name) for name in CHOICES]}


if __name__ == "__main__":
    main()
