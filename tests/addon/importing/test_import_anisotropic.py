"""Anisotropic measurements through the add-on: imported, refitted, in an asset library."""

import numpy as np
import pytest
from measured_brdf.addon.core.shading import tangents
from measured_brdf.addon.core.shading.material import group_node
from measured_brdf.addon.work import tasks

from fitter import cli
from support.anisotropic import STEEL, few, write_table
from support.cases import release
from support.stage import add_lamp, black_scene, render, rotation_toward, set_input

CHEAP = {"preset": "Paper", "diffuse_level": 2, "specular_level": -1}


@pytest.fixture
def file(tmp_path):
    return write_table(tmp_path / "steel.csv", STEEL, directions=few())


@pytest.fixture
def plane(blender):
    black_scene(16, 16, samples=16, span=1)
    blender.ops.mesh.primitive_plane_add()
    return blender.context.object


def find_tangent_node(item):
    return group_node(item.active_material)


def names(item):
    return {"Tangent", "Rotation"} & set(find_tangent_node(item).inputs.keys())


def test_an_anisotropic_file_becomes_a_material_with_a_tangent_and_a_rotation(blender, plane, file):
    assert blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP) == {"FINISHED"}
    assert names(plane) == {"Tangent", "Rotation"}
    assert plane.active_material.measured_brdf.fitted_levels == "level 2"
    assert plane.active_material.measured_brdf.shown_phi == 0


@release
def test_it_is_isotropic_where_the_user_says_so_and_a_refit_changes_it(blender, plane, file):
    blender.ops.measured_brdf.import_data(filepath=str(file), isotropic="isotropic", **CHEAP)
    settings = plane.active_material.measured_brdf
    assert names(plane) == set()
    before = settings.digest
    settings.isotropic = "auto"
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert names(plane) == {"Tangent", "Rotation"}
    assert settings.digest != before


@release
def test_a_refit_keeps_the_tangent_and_the_rotation_that_are_connected(blender, plane, file):
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    tangents.take_from_uv(plane.active_material)
    set_input(plane.active_material, "Rotation", 0.25)
    plane.active_material.measured_brdf.diffuse_level = 1
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    assert find_tangent_node(plane).inputs["Tangent"].links[0].from_node.type == "TANGENT"
    assert find_tangent_node(plane).inputs["Rotation"].default_value == 0.25


def test_a_quarter_of_a_turn_swaps_bright_and_dark(blender, plane, file):
    blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    tangents.take_from_uv(plane.active_material)
    across = (0, 3, 3)
    add_lamp("SUN", 3, rotation=rotation_toward(across))
    bright = render(blender.context.scene)[..., :3].mean()
    set_input(plane.active_material, "Rotation", 0.25)
    dark = render(blender.context.scene)[..., :3].mean()
    set_input(plane.active_material, "Rotation", 0.5)
    half = render(blender.context.scene)[..., :3].mean()
    assert bright > 1.5 * dark
    assert half == pytest.approx(bright, rel=0.2)


@pytest.mark.parametrize("count", [1, 2])
def test_one_or_two_rotations_are_fitted_as_isotropic_and_told(extension, blender, plane, tmp_path, count):
    path = write_table(tmp_path / "few.csv", STEEL, directions=few(count))
    blender.ops.measured_brdf.import_data(filepath=str(path), **CHEAP)
    assert names(plane) == set()
    data = extension.addon.work.tasks.read(str(path), None)
    assert ("Material", "isotropic", False) in data.description.rows()
    assert any("rotation" in note for note in data.description.notes) == (count == 2)


def test_a_fit_too_large_for_the_compiler_names_the_remedy_and_changes_nothing(blender, plane, file, monkeypatch):
    bake = tasks.bake
    monkeypatch.setattr(tasks, "bake", lambda fit, mixture: bake(fit, mixture=mixture) + "\n" * (1 << 24))
    with pytest.raises(RuntimeError, match="can be compiled: choose a lower level, or a compression that drops more"):
        blender.ops.measured_brdf.import_data(filepath=str(file), **CHEAP)
    assert plane.active_material is None
    assert len(blender.data.materials) == len(blender.data.texts) == 0


def test_a_folder_of_anisotropic_files_becomes_a_library(extension, blender, file, tmp_path):
    out = tmp_path / "library" / "made.blend"
    cheap = ["--preset", "Paper", "--diffuse-level", "2", "--specular-level", "none"]
    given = ["convert", str(file), "-o", str(out), "--processes", "1", *cheap]
    assert extension.addon.work.command.main(given) == cli.BAD
    with blender.data.libraries.load(str(out)) as (source, target):
        target.materials = source.materials
    material, = target.materials
    assert material.preview.image_size[0] > 0
    group = next(node for node in material.node_tree.nodes if node.type == "GROUP")
    assert {"Tangent", "Rotation"} <= set(group.inputs.keys())
    assert np.isfinite(material.measured_brdf.rmse)
