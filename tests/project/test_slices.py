"""Each slice of the addon can be deleted, with its name in `addon/__init__.py`: everything else works without it."""

import re
import shutil
import subprocess
import sys

import pytest

from support.checkout import ROOT

SLICES = ("adjust", "baking", "compare", "importing", "inspect", "library", "mix", "photographs", "starter")
WHOLE = ("__init__.py", "blender_manifest.toml", "addon", "fitter", "osl")
SCRIPT = """
import importlib.util, sys
from pathlib import Path
import bpy

root, file, gone = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
spec = importlib.util.spec_from_file_location("measured_brdf", root / "__init__.py",
                                              submodule_search_locations=[str(root)])
package = sys.modules["measured_brdf"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(package)
from support import kept
kept.keep_all()
bpy.ops.wm.read_factory_settings(use_empty=True)
package.register()
from measured_brdf.addon.core import checks, edits, material, osl_support
from measured_brdf.addon.work import command, tasks
from support.drawn import draw
from support.operators import default_choices
from types import SimpleNamespace

bpy.ops.mesh.primitive_cube_add()
osl_support.enable(bpy.context.scene)
choices = default_choices()
choices.filepath, cheap = file, {"diffuse_level": 1, "specular_level": None}
one, other = (material.create(tasks.outcome(file, "", cheap), choices, bpy.context) for _ in range(2))
bpy.context.object.data.materials.append(one)
operators = bpy.ops.measured_brdf
image = bpy.data.images.new("photograph", 8, 8)
photograph = image.filepath_raw = str(root / "photograph.png")
image.save()
work = {
    "adjust": lambda: (setattr(one.measured_brdf_adjustments, "highlight_gain", 0.5), operators.adjust())[1],
    "baking": lambda: operators.bake_pbr(size=4),
    "compare": operators.pin,
    "importing": lambda: operators.import_data(filepath=file, preset="Paper", diffuse_level=1, specular_level=-1),
    "inspect": lambda: operators.inspect.poll() and {"FINISHED"},
    "library": operators.save_asset,
    "mix": lambda: operators.mix(first=one.name, second=other.name),
    "starter": lambda: operators.use_published(name="pvc"),
    "photographs": lambda: operators.measure_photographs(filepath=photograph)}      # it opens another scene
for name, run in work.items():
    if name != gone:
        assert run() == {"FINISHED"}, name
assert bool(edits.edit_arguments(one)) == (gone != "adjust")
checks.check(bpy.context.scene)
assert ("convert" in command.build_parser().format_help()) == (gone != "library")
for panel in bpy.types.Panel.__subclasses__():
    context = SimpleNamespace(material=one, object=bpy.context.object, scene=bpy.context.scene, region=None,
                              space_data=None, preferences=bpy.context.preferences)
    if panel.__module__.startswith("measured_brdf.") and getattr(panel, "poll", lambda _: True)(context):
        draw(panel, material=one)           # an operator that is not there raises
package.unregister()
assert not dir(operators)
print("WORKS")
"""


def without(name, folder):
    """A copy of the extension without a slice: its folder, and its name in two lines."""
    folder.mkdir()
    for part in WHOLE:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / part, folder / part)
    shutil.rmtree(folder / "addon" / name)
    init = folder / "addon" / "__init__.py"
    source, count = re.subn(rf"\b{name}, |, {name}\b", "", init.read_text("utf-8"))
    assert count == 2
    init.write_text(source, "utf-8")
    return folder


@pytest.mark.parametrize("name", SLICES)
def test_everything_else_works_without_a_slice(name, tmp_path, glossy, write_astm):
    """Each starts a Blender: what two slices share is found in no other way."""
    file = write_astm(tmp_path / "glossy.astm", glossy)
    root = without(name, tmp_path / "part")
    done = subprocess.run([sys.executable, "-c", SCRIPT, str(root), str(file), name], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    assert "WORKS" in done.stdout, done.stderr
