"""Each slice of the addon can be deleted, with its name in `addon/__init__.py`: everything else works without it."""

import re
import shutil

import pytest

from support.checkout import ROOT, run_python

SLICES = ("adjust", "baking", "compare", "importing", "inspect", "library", "mix", "photographs", "starter")
WHOLE = ("__init__.py", "blender_manifest.toml", "addon", "fitter", "osl")
SCRIPT = """
import importlib.util, sys, traceback
from pathlib import Path
from types import SimpleNamespace
import bpy
from support import kept
from support.drawn import draw
from support.operators import default_choices

def loaded(root):
    for name in [name for name in sys.modules if name.partition(".")[0] == "measured_brdf"]:
        del sys.modules[name]
    spec = importlib.util.spec_from_file_location("measured_brdf", root / "__init__.py",
                                                  submodule_search_locations=[str(root)])
    package = sys.modules["measured_brdf"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    return package

def use(file, gone, root):
    from measured_brdf.addon.core import checks
    from measured_brdf.addon.core.storage import edits
    from measured_brdf.addon.core.shading import material
    from measured_brdf.addon.core.blender import osl_support
    from measured_brdf.addon.work import command, tasks

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
        if panel.is_registered and panel.__module__.startswith("measured_brdf.") \
                and getattr(panel, "poll", lambda _: True)(context):
            draw(panel, material=one)           # an operator that is not there raises

file, *names = sys.argv[1:]
for gone, root in zip(names[::2], map(Path, names[1::2])):
    package = loaded(root)
    kept.keep_all()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    package.register()
    try:
        use(file, gone, root)
    except Exception:
        print(f"without {gone}:", file=sys.stderr)
        traceback.print_exc()
    else:
        print("WORKS without", gone)
    package.unregister()
    assert not dir(bpy.ops.measured_brdf)
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


@pytest.fixture(scope="module")
def done(tmp_path_factory, glossy, write_astm):
    """One Blender that has worked without each slice in turn: what two slices share is found in no other way."""
    folder = tmp_path_factory.mktemp("slices")
    file = write_astm(folder / "glossy.astm", glossy)
    parts = [str(each) for name in SLICES for each in (name, without(name, folder / name))]
    return run_python("-c", SCRIPT, file, *parts, timeout=None)


@pytest.mark.parametrize("name", SLICES)
def test_everything_else_works_without_a_slice(name, done):
    assert f"WORKS without {name}\n" in done.stdout, done.stderr
