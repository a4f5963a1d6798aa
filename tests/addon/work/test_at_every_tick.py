"""Users undo, redo, delete and open other files at every tick of an operator's timer."""

import time
from types import SimpleNamespace

import bpy
import pytest
from measured_brdf.addon.importing import fit, import_data
from measured_brdf.addon.library import operators as assets
from measured_brdf.addon.work import making, modal, process

from support.blend_state import state
from support.cases import release
from support.operators import methods
from support.stage import black_scene

CHOICES = {"preset": "Paper", "diffuse_level": 1, "specular_level": -1, "compression": 80.0, "use_tolerance": False,
           "tolerance": 1.0, "filepath": "", "sample": "", "rendering": "AUTO", "angles": "auto", "quantity": "auto",
           "illuminant": "D65", "isotropic": "auto", "symmetry": "auto", "encoding": "raw",
           "keep_unmeasured": False, "columns": "", "target": 0, "slot": -1, "others": ""}
TICKS = 4                   # as many as the longest of these operators takes, once its process is done


@pytest.fixture(scope="module")
def folder(tmp_path_factory, glossy, write_astm):
    path = tmp_path_factory.mktemp("measurements")
    for name in ("a", "b", "c"):
        write_astm(path / f"{name}.astm", glossy, name)
    return path


def driven(cls, base, **attributes):
    """An operator of a class, driven by the test instead of by a window."""
    made = type("Driven", (base,), methods(cls))()
    made.reports = []
    made.report = lambda kind, text: made.reports.append((kind, text))
    of_blender = {"_timer": None, "options": SimpleNamespace(is_invoke=False),
                  "properties": SimpleNamespace(is_property_set=lambda name: True)}
    for name, value in (CHOICES | of_blender | attributes).items():
        setattr(made, name, value)
    return made


def tick(operator):
    context = SimpleNamespace(object=bpy.context.object, scene=bpy.context.scene, material=None, workspace=None,
                              evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
                              window_manager=SimpleNamespace(event_timer_remove=lambda timer: None))
    return operator.modal(context, SimpleNamespace(type="TIMER", value="NOTHING"))


def undo():
    bpy.ops.ed.undo()


def undo_and_redo():
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()


def delete():
    bpy.data.batch_remove([*bpy.data.materials, *bpy.data.node_groups, *bpy.data.texts, *bpy.data.objects])
    bpy.data.orphans_purge()


def open_another():
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


DISTURBANCES = (undo, undo_and_redo, delete, open_another)


def run(operator, disturb, at):
    """Run to the end with an interruption in between; the results of all ticks."""
    job = process.Job(None)          # what its process would do is done here: quicker, and the same ticks each time
    job.result, job.finished = operator.work(bpy.context).run(), time.monotonic()
    operator._begin(SimpleNamespace(start=lambda: job))
    results = []
    while not results or results[-1] == {"PASS_THROUGH"}:
        if len(results) == at:
            disturb()
        results.append(tick(operator))
    return results


def scene(folder):
    """A cube with a measured material, and three steps to undo."""
    black_scene(16, 16, samples=1, span=1)
    bpy.ops.ed.undo_push(message="empty")
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.ed.undo_push(message="cube")
    assert bpy.ops.measured_brdf.import_data(filepath=str(folder / "a.astm"), diffuse_level=1,
                                             specular_level=-1) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="material")


def importing(folder):
    return driven(import_data.MEASUREDBRDF_OT_import_data, import_data.MakesMaterials, directory=str(folder),
                  files=[SimpleNamespace(name=f"{name}.astm") for name in "abc"])


def fitting(_folder):
    bpy.context.object.active_material.measured_brdf.diffuse_level = 2
    return driven(fit.MEASUREDBRDF_OT_fit, modal.InBackground, preset="AS_CHOSEN")


def assert_whole():
    """Every measured material has its shader, every shader its material, and Blender can save the file."""
    groups = {tree.name for tree in bpy.data.node_groups if "Measured BRDF Shader" in tree.nodes and tree.users}
    used = set()
    for item in bpy.data.materials:
        if item.measured_brdf.coefficients:
            node = next(node for node in item.node_tree.nodes if node.type == "GROUP")
            assert node.node_tree.nodes["Measured BRDF Shader"].bytecode
            used.add(node.node_tree.name)
    assert used == groups


@pytest.mark.parametrize("at", range(TICKS))
@pytest.mark.parametrize("disturb", DISTURBANCES)
def test_an_import_of_several_files_survives(blender, folder, disturb, at):
    scene(folder)
    operator = importing(folder)
    results = run(operator, disturb, at)
    assert_whole()
    happened = len(results) > at
    if not happened:
        return
    if disturb is open_another:
        assert results[-1] == {"CANCELLED"}
        assert not bpy.data.materials
    else:
        assert results[-1] == {"FINISHED"}, operator.reports
        made = [item for item in bpy.data.materials if item.measured_brdf.coefficients and item.users]
        assert sorted(item.name[0] for item in made) == ["a", "b", "c"]


@pytest.mark.parametrize("at", range(2))         # it has one piece less than files that are imported
@pytest.mark.parametrize("disturb", DISTURBANCES)
def test_a_fit_survives(blender, folder, disturb, at):
    scene(folder)
    operator = fitting(folder)
    results = run(operator, disturb, at)
    assert_whole()
    if len(results) <= at:
        return
    if disturb is undo_and_redo:
        assert results[-1] == {"FINISHED"}
        assert bpy.context.object.active_material.measured_brdf.diffuse_level == 2
    else:
        assert results[-1] == {"CANCELLED"}
        assert "removed meanwhile" in operator.reports[-1][1] or disturb is open_another


@release
def test_a_conversion_touches_nothing_of_the_open_file(blender, folder, tmp_path):
    """Not even while it works: its Blender is another one."""
    scene(folder)
    before = state()
    base = type("Base", (making.FromFolder, assets.ReplacesFile), {})
    operator = driven(assets.MEASUREDBRDF_OT_convert_folder, base, directory=str(folder), force=False,
                      library=str(tmp_path / "library.blend"))
    operator._begin(operator.work(bpy.context))
    count = 0
    while (result := tick(operator)) == {"PASS_THROUGH"}:
        if count % 5 == 0:
            bpy.ops.ed.undo()
            bpy.ops.ed.redo()
            assert state() == before
        count += 1
        time.sleep(0.02)
    assert result == {"FINISHED"}, operator.reports
    assert count > 5
    assert state() == before
    with bpy.data.libraries.load(str(tmp_path / "library.blend")) as (names, _):
        assert sorted(names.materials) == ["a", "b", "c"]
