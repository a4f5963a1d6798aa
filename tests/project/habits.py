"""A day with the installed extension, in a process of its own: habits.py ZIP FOLDER.

FOLDER holds ten files of measurements, 0.astm to 9.astm, of which 9.astm is broken. Prints DONE at the end.
"""

import sys
import time
from pathlib import Path
from types import SimpleNamespace

import bpy

package, folder = sys.argv[1], Path(sys.argv[2])
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
assert bpy.ops.extensions.package_install_files(
    filepath=package, repo="user_default", enable_on_install=True) == {"FINISHED"}
addon = sys.modules["bl_ext.user_default.measured_brdf.addon"]
CHEAP = {"diffuse_level": 2, "specular_level": 4, "compression": 80.0}


def counts():
    return {name: len(getattr(bpy.data, name)) for name in ("materials", "texts", "node_groups")}


def drop(*names):
    """As Blender does for files that are dropped onto the window."""
    bpy.ops.measured_brdf.import_data("INVOKE_DEFAULT", directory=str(folder), files=[{"name": name} for name in names],
                                      **CHEAP)


def settings(material):
    """What a material keeps; the path of its measurements, which is relative in a saved file, as what it means."""
    measured, path = material.measured_brdf, addon.core.storage.paths.absolute(material)
    return {"filepath": path} | {name: getattr(measured, name) for name in (
        "digest", "coefficients", "diffuse_level", "specular_level", "compression", "name_of_data")}


# import by drop
bpy.ops.measured_brdf.enable_osl()
bpy.ops.mesh.primitive_cube_add()
bpy.ops.ed.undo_push(message="before")
before = counts()
drop("0.astm", "1.astm")
bpy.ops.ed.undo_push(message="import")
assert counts()["materials"] == before["materials"] + 2
assert bpy.context.object.active_material.name == "paint 0"

# undo, redo
bpy.ops.ed.undo()
assert counts() == before
bpy.ops.ed.redo()
assert bpy.context.object.active_material.name == "paint 0"
material = bpy.data.materials["paint 0"]

# cancel, first in the other process, then here
cls = addon.importing.import_data.MEASUREDBRDF_OT_import_data


class Drop(addon.work.making.MakesMaterials):
    """The operator, driven by events that are made here."""

    work, _paths = cls.work, cls._paths
    preset, diffuse_level, specular_level, compression = "Paper", 2, 4, 80.0
    options = SimpleNamespace(is_invoke=False)
    properties = SimpleNamespace(is_property_set=lambda name: name == "preset")
    directory, files = str(folder), [SimpleNamespace(name="2.astm"), SimpleNamespace(name="3.astm")]
    _timer = None

    def __getattr__(self, name):
        """Any other property has its default."""
        known = bpy.ops.measured_brdf.import_data.get_rna_type().properties
        if name not in known:
            raise AttributeError(name)
        return known[name].default

    def report(self, *_):
        """Nobody reads it."""


def event(kind):
    return SimpleNamespace(type=kind, value="PRESS")


context = SimpleNamespace(object=None, scene=bpy.context.scene, workspace=None,
                          evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
                          window_manager=SimpleNamespace(event_timer_remove=lambda timer: None))
before = counts()
attempt = Drop()
attempt._begin(attempt.work(context))
assert attempt.modal(context, event("TIMER")) == {"PASS_THROUGH"}
assert attempt.modal(context, event("ESC")) == {"CANCELLED"}
assert counts() == before
attempt._begin(attempt.work(context))
while attempt._steps is None:
    assert attempt.modal(context, event("TIMER")) == {"PASS_THROUGH"}
    time.sleep(0.02)
assert attempt.modal(context, event("ESC")) == {"CANCELLED"}
assert counts() == before
attempt._begin(attempt.work(context))
while attempt.modal(context, event("TIMER")) == {"PASS_THROUGH"}:
    time.sleep(0.02)
assert counts()["materials"] == before["materials"] + 2

material = bpy.data.materials["paint 0"]

# save and reload
kept = settings(material)
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "saved.blend"))
bpy.ops.wm.open_mainfile(filepath=str(folder / "saved.blend"))
assert settings(bpy.data.materials["paint 0"]) == kept

# batch
command = addon.work.command
out = folder / "library" / "library.blend"
assert command.main(["convert", str(folder), "-o", str(out), "--preset", "Paper", "--diffuse-level", "2",
                     "--specular-level", "4"]) == 1
with bpy.data.libraries.load(str(out), assets_only=True) as (source, _):
    assert len(source.materials) == 9

bpy.ops.preferences.addon_disable(module="bl_ext.user_default.measured_brdf")
print("DONE", bpy.app.version_string)
