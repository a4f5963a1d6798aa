"""An operator that fails, at whatever point, leaves the .blend as it was."""

import contextlib
import os
import sys
from pathlib import Path

import bpy
import pytest

from support.blend_state import state
from support.cases import quick
from support.checkout import ROOT

ADDON = str(ROOT / "addon") + os.sep
# lamp groups are derived data, and their functions are called hundreds of times; Blender calls a slider's update, and
# what computes a property, and prints their errors
HANDLERS = (*(f"{ADDON}core{os.sep}{name}" for name in (
    "lamps", os.path.join("blender", "device.py"), os.path.join("shading", "export_follow.py"))),
            f"{ADDON}adjust{os.sep}settings.py")
# transactions are what is tested; the others change no data of Blender's
QUIET = ("annotations.py", "transaction.py", "tasks.py", "process.py", "queue.py", "properties.py", "compiler.py",
         "versions.py", "icons.py", "preferences.py")
# these change nothing, and Blender calls them before an operator begins and after it has ended
OUTSIDE = ("poll", "is_editable", "can_change", "is_measured", "group_node", "script_node", "active_material",
           "execute", "run", "_path", "_report_failure", "_on_change", "get_side")


class InjectedError(Exception):
    """Raised in the middle of the add-on."""


class _Injection:
    """Raise at the first call of the n-th function of the add-on that is called, while it is active."""

    def __init__(self, at):
        self.at, self.where, self.called = at, None, set()

    def __enter__(self):
        self.former = sys.gettrace()        # that of `tools.reached`
        sys.settrace(self._trace)
        return self

    def __exit__(self, *_):
        sys.settrace(self.former)

    def _trace(self, frame, event, argument):
        self._fail(frame, event)
        return self.former(frame, event, argument) if self.former is not None else None

    def _fail(self, frame, event):
        path, name = frame.f_code.co_filename, frame.f_code.co_name
        if event != "call" or not path.startswith(ADDON) or path.startswith(HANDLERS):
            return
        if path.endswith(QUIET) or name in OUTSIDE or name[0] == "<" or _is_called_by_a_handler(frame):
            return
        if self.where is not None or frame.f_code in self.called:
            return
        self.called.add(frame.f_code)
        if len(self.called) == self.at:
            self.where = f"{Path(path).name}: {name}"
            raise InjectedError(self.where)


def _is_called_by_a_handler(frame):
    """Whether a handler has called: Blender prints its errors, and the operator goes on."""
    while frame is not None and not frame.f_code.co_filename.startswith(HANDLERS):
        frame = frame.f_back
    return frame is not None


@pytest.fixture(scope="module")
def files(tmp_path_factory, glossy, write_astm):
    path = tmp_path_factory.mktemp("measurements")
    for name in ("a", "b"):
        write_astm(path / f"{name}.astm", glossy, name)
    return path


@pytest.fixture
def cube(cube, quick, files):
    assert bpy.ops.measured_brdf.import_data(filepath=str(files / "a.astm"), diffuse_level=1,
                                             specular_level=-1) == {"FINISHED"}
    return cube


OPERATIONS = {
    "import": lambda folder: bpy.ops.measured_brdf.import_data(filepath=str(folder / "b.astm"), diffuse_level=1,
                                                               specular_level=-1),
    "import folder": lambda folder: bpy.ops.measured_brdf.import_folder(directory=str(folder), preset="Paper",
                                                                        diffuse_level=1, specular_level=-1),
    "refit": lambda folder: bpy.ops.measured_brdf.fit(),
    "fit with a preset": lambda folder: bpy.ops.measured_brdf.fit(preset="Paper"),
    "find file": lambda folder: bpy.ops.measured_brdf.find_file(filepath=str(folder / "b.astm"),
                                                                refit=True),
    "use published": lambda folder: bpy.ops.measured_brdf.use_published(name="pink-felt"),
    "save asset": lambda folder: bpy.ops.measured_brdf.save_asset(),
    "update": lambda folder: bpy.ops.measured_brdf.update_materials(),
    "adjust": lambda folder: bpy.ops.measured_brdf.adjust(),
    "adjust a material of a mix": lambda folder: bpy.ops.measured_brdf.adjust(),
    "bake": lambda folder: bpy.ops.measured_brdf.bake_pbr(size=2),
    "mix": lambda folder: bpy.ops.measured_brdf.mix(first="a", second="b"),
}


def make_older():
    """Make the file's shaders look like those of an older version."""
    for tree in bpy.data.node_groups:
        if "shader_version" in tree:
            tree["shader_version"] = 1


def group_uids():
    return {tree.session_uid for tree in bpy.data.node_groups}


def changed(before, after):
    return [kind for kind in before if before[kind] != after[kind]]


@pytest.mark.parametrize("name", quick(OPERATIONS, "import", "adjust", "mix"))
def test_an_error_anywhere_in_an_operator_leaves_the_blend_as_it_was(cube, files, name, capfd):
    if name == "update":
        make_older()
    if name.startswith("adjust"):
        cube.active_material.measured_brdf_adjustments.diffuse_gain = 0.5
    if "mix" in name:
        bpy.context.view_layer.objects.active = None
        OPERATIONS["import"](files)
        if name != "mix":
            OPERATIONS["mix"](files)
        bpy.context.view_layer.objects.active = cube
    before, groups, places = state(), group_uids(), []
    for at in range(1, 400):
        injection, result = _Injection(at), None
        with contextlib.suppress(RuntimeError), injection:
            result = OPERATIONS[name](files)
        if injection.where is None:
            break
        places.append(injection.where)
        assert changed(before, state()) == [], injection.where
    assert result == {"FINISHED"}
    assert changed(before, state()) != [] or group_uids() != groups, "the operator does something when nothing fails"
    assert len(places) > 5
    capfd.readouterr()


def test_every_setting_of_a_material_is_part_of_the_state(cube):
    material = cube.active_material
    before, seen = state(), set()
    for settings in (material.measured_brdf, material.measured_brdf_adjustments):
        for name, prop in settings.bl_rna.properties.items():
            if name not in ("rna_type", "name"):
                setattr(settings, name, another(prop, getattr(settings, name)))
                assert changed(before, state()) == ["settings"], name
                before = state()
                seen.add(name)
    assert {"rendering", "adjusted", "coat", "filepath"} < seen


def another(prop, value):
    """Another value of a property."""
    if prop.type == "FLOAT":
        return [0.5] * prop.array_length if prop.is_array else 0.5
    if prop.type == "ENUM":
        return next(item.identifier for item in prop.enum_items if item.identifier != value)
    return {"BOOLEAN": not value, "INT": 7, "STRING": "other"}[prop.type]


def test_a_refit_of_a_material_whose_output_was_deleted_gives_it_one(cube):
    material = cube.active_material
    for node in [node for node in material.node_tree.nodes if node.type == "OUTPUT_MATERIAL"]:
        material.node_tree.nodes.remove(node)
    material.measured_brdf.diffuse_level = 2
    assert bpy.ops.measured_brdf.fit() == {"FINISHED"}
    surface = material.node_tree.get_output_node("CYCLES").inputs["Surface"]
    assert surface.links[0].from_node.type == "GROUP"
    assert material.measured_brdf.coefficients == 5 * 7 * 5         # level 2
