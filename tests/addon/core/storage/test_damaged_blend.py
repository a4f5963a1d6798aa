"""Blend files whose measured materials were damaged, made by hand, or saved by another version."""

import contextlib
import math
import subprocess
import sys

import bpy
import pytest
from measured_brdf.addon.core import lamps

from support.cases import release
from support.checkout import ROOT
from support.stage import EXITS, add_lamp, black_scene, render
from tools import fuzz

FIT_CHOICES = ("filepath", "sample", "preset", "diffuse_level", "specular_level", "compression", "tolerance",
               "rendering", "angles", "quantity", "illuminant", "isotropic", "symmetry", "encoding")
ODD_CHOICES = ("x" * 2000, 2**31 - 1)
ODD = ("", "x" * 2000, "//../\n", "99", -5, 99, 2**31 - 1, math.nan, math.inf, -1e300, [1, 2], {"a": 1}, True)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "made.astm"
    path.write_bytes(fuzz.seeds()["astm, made"])
    return path


@pytest.fixture
def plane(blender, file):
    """A plane with a measured material, under a sun."""
    black_scene(8, 8, samples=4, span=1)
    blender.ops.mesh.primitive_plane_add(size=4)
    blender.ops.measured_brdf.import_data(filepath=str(file), preset="Paper", diffuse_level=1, specular_level=-1)
    add_lamp("SUN", math.pi, angle=0)
    return blender.context.object


def stored(material):
    """The stored properties themselves, as a file holds them, past their declared types and ranges."""
    system = getattr(material, "bl_system_properties_get", None)
    return (system() if system else material)["measured_brdf"]


def complaint(operator, **arguments):
    """The error that an operator reports, or an empty string; never a traceback."""
    try:
        assert operator(**arguments) == {"FINISHED"}
        return ""
    except RuntimeError as error:
        message = str(error)
    assert "Traceback" not in message, message
    return message


def fit(bpy):
    return not complaint(bpy.ops.measured_brdf.fit)


@release
def test_stored_properties_of_any_type_and_size_are_refused_or_harmless(blender, plane, file):
    material = plane.active_material
    whole = dict(stored(material).items())
    assert {"filepath", "diffuse_level"} <= whole.keys()
    shown = [name for name in whole if name not in FIT_CHOICES and name != "use_tolerance"]     # that asks for a search
    damage = [{"compression": math.nan}, *({name: value} for name in FIT_CHOICES for value in ODD_CHOICES)]
    damage += [{name: ODD[(start + n) % len(ODD)] for n, name in enumerate(shown)} for start in range(0, len(ODD), 4)]
    for change in damage:
        for name, value in change.items():
            replace(stored(material), name, value)
        assert fit(blender) or not change.keys() <= set(shown)      # what is only shown may be anything
        for name in change:
            replace(stored(material), name, whole[name])
    assert fit(blender)
    assert render(blender.context.scene)[..., :3].max() > 0.01


def replace(group, name, value):
    """Store a value of whatever type, where a file can hold one."""
    if name in group:
        del group[name]
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        group[name] = value


def rename_to_another_kind(tree):
    """Another node has the name of the script node."""
    name = next(node.name for node in tree.nodes if node.type == "SCRIPT")
    tree.nodes.remove(tree.nodes[name])
    tree.nodes.new("ShaderNodeValue").name = name


def remove_nodes(tree):
    tree.nodes.clear()


def hostile_text(tree):
    text = bpy.data.texts.new("broken.osl")
    text.from_string("shader broken( {")
    next(node for node in tree.nodes if node.type == "SCRIPT").script = text


@pytest.mark.parametrize("damage", [rename_to_another_kind, remove_nodes, hostile_text])
def test_a_group_taken_apart_can_be_fitted_anew_and_renders(blender, plane, damage):
    node = next(node for node in plane.active_material.node_tree.nodes if node.type == "GROUP")
    damage(node.node_tree)
    blender.context.view_layer.update()
    assert fit(blender)
    assert render(blender.context.scene)[..., :3].max() > 0.01


def test_a_truncated_blend_is_refused_and_the_next_one_opens(blender, plane, tmp_path):
    whole, cut = tmp_path / "whole.blend", tmp_path / "cut.blend"
    blender.ops.wm.save_as_mainfile(filepath=str(whole), compress=False)
    content = whole.read_bytes()
    for size in (10, len(content) // 2, len(content) - 100):
        cut.write_bytes(content[:size])
        complaint(blender.ops.wm.open_mainfile, filepath=str(cut))
    blender.ops.wm.open_mainfile(filepath=str(whole))
    assert fit(blender)


@pytest.mark.parametrize("number", range(25))
def test_a_damaged_file_makes_a_whole_material_or_none(blender, tmp_path, number):
    path = tmp_path / "case.dat"
    path.write_bytes(fuzz.case(fuzz.seeds(), number)[-1])
    kinds = ("materials", "texts", "node_groups", "images", "objects", "meshes")
    before = [len(getattr(blender.data, kind)) for kind in kinds]
    refused = complaint(blender.ops.measured_brdf.import_data, filepath=str(path), diffuse_level=0, specular_level=-1)
    if refused:
        assert str(path) in refused
        assert [len(getattr(blender.data, kind)) for kind in kinds] == before
        return
    node = next(node for node in blender.data.materials[-1].node_tree.nodes if node.type == "GROUP")
    assert all(node.bytecode for node in node.node_tree.nodes if node.type == "SCRIPT")


CYCLE = """
import bpy
from support import checkout

def found():
    handlers = {name: [h for h in getattr(bpy.app.handlers, name)] for name in dir(bpy.app.handlers)
                if isinstance(getattr(bpy.app.handlers, name), list)}
    classes = {name for name in dir(bpy.types)}
    operators = {name for name in dir(bpy.ops)} | {f"measured_brdf.{name}" for name in dir(bpy.ops.measured_brdf)}
    properties = {(kind, name) for kind in ("Material", "Scene", "Object", "WindowManager", "NodeTree", "World")
                  for name in dir(getattr(bpy.types, kind))}
    menus = {name: list(getattr(getattr(bpy.types, name).draw, "_draw_funcs", ())) for name in dir(bpy.types)
             if hasattr(getattr(bpy.types, name), "draw")}
    timers = [function for function in dir(bpy.app.timers) if not function.startswith("_")]
    return dict(handlers=handlers, classes=classes, operators=operators, properties=properties,
                menus={name: value for name, value in menus.items() if len(value) > 1}, timers=timers)

extension = checkout.extension()
before = found()
extension.register()
enabled = found()
assert enabled != before
for _ in range(2):
    extension.unregister()
    after = found()
    for kind in before:
        assert after[kind] == before[kind], (kind, before[kind], after[kind])
    extension.register()
    assert {kind: len(value) for kind, value in found().items()} == {kind: len(v) for kind, v in enabled.items()}
extension.unregister()
print("CLEAN")
"""


def test_enabling_and_disabling_again_and_again_leaves_nothing_behind():
    done = subprocess.run([sys.executable, "-c", CYCLE], cwd=ROOT, capture_output=True, text=True, check=False,
                          timeout=120)
    assert done.returncode in EXITS, done.stdout + done.stderr
    assert "CLEAN" in done.stdout


def test_a_fit_that_fails_of_a_material_with_a_choice_that_does_not_exist_tells_why(blender, plane, monkeypatch):
    """What the choice was cannot be put back."""
    def fails(*_):
        raise ValueError("no room")

    replace(stored(plane.active_material), "rendering", 99)
    monkeypatch.setattr(lamps, "update", fails)
    assert complaint(blender.ops.measured_brdf.fit).strip() == "Error: no room"
