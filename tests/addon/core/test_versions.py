"""Files that earlier versions saved: they open, render as they did, are told apart, and can be brought up to date.

`tests/data` holds what version 0.1.0 wrote with Blender 4.2.23: a scene (the `glossy` measurement of conftest.py by the
preset Draft on a sphere, under a point lamp and a sun; its own picture in a property of the scene) and a library (the
same by the paper's method at level 1). And a scene of version 0.2.0, with Blender 5.0.1: `glossy`, rendered Fast on a
sphere in an even world and under a point lamp, an anisotropic measurement, and a mix of both, Fast too. To keep the
file small, its shaders have no bytecode, and their sources no tables that only rendering reads.
"""

import shutil
import subprocess
import sys

import bpy
import numpy as np
import pytest

import fitter
from fitter.cycles.bake import SHADER_VERSION, bake
from fitter.cycles.unbake import unbake
from support.blend_state import state
from support.cases import quick, release
from support.checkout import ROOT
from support.mixtures import any_mixture
from support.stage import EXITS, render

DATA = ROOT / "tests" / "data"


@pytest.fixture
def old_scene(blender, tmp_path):
    """The scene of 0.1.0, opened; what its pictures show in 8 x 8 blocks: (8, 8, 3)."""
    shutil.copy(DATA / "scene-0.1.0.blend", tmp_path)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene-0.1.0.blend"))
    return np.array(bpy.context.scene["picture"]).reshape(8, 8, 3)


def blocks():
    return render(bpy.context.scene)[..., :3].reshape(8, 4, 8, 4, 3).mean(axis=(1, 3))


def assert_same(picture, expected):
    """The same but for noise: 256 samples a pixel, 16 pixels a block."""
    assert picture.mean() == pytest.approx(expected.mean(), rel=0.005)
    np.testing.assert_allclose(picture, expected, atol=0.02 * expected.max())


def glossy_material():
    return bpy.data.materials["glossy"]


def test_a_shader_that_cannot_take_anothers_place_leaves_nothing_behind(old_scene, monkeypatch):
    from measured_brdf.addon.core import compiler, lamps, material
    from measured_brdf.addon.work import queries, tasks

    made, = tasks.rebake([queries.kept(glossy_material())])
    before, shader = state(), compiler.compile_shader(*made)

    def fail(*_):
        raise MemoryError

    monkeypatch.setattr(lamps, "update", fail)
    with pytest.raises(MemoryError):
        material.replace_shader([glossy_material()], shader, bpy.context)
    assert state() == before


def test_a_scene_of_the_first_version_renders_as_it_did_and_is_told_apart(old_scene):
    from measured_brdf.addon.core import checks, material, versions

    assert_same(blocks(), old_scene)
    assert versions.made_by(glossy_material()) == "0.1.0"
    assert material.is_outdated(glossy_material())
    assert "version" in {finding.key for finding in checks.check(bpy.context.scene)}


@release
def test_one_button_brings_it_up_to_date_without_the_measurements(old_scene):
    from measured_brdf.addon.core import checks, material, node_group, versions

    before = unbake(node_group.source(material.group_node(glossy_material()).node_tree))
    settings = {name: getattr(glossy_material().measured_brdf, name) for name in ("digest", "rmse", "coefficients")}
    material.group_node(glossy_material()).inputs["Strength"].default_value = 0.5
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert not material.is_outdated(glossy_material())
    assert versions.made_by(glossy_material()) == versions.CURRENT
    assert "version" not in {finding.key for finding in checks.check(bpy.context.scene)}
    tree = material.group_node(glossy_material()).node_tree
    assert node_group.version(tree) == SHADER_VERSION
    after = fitter.Fit.from_bytes(node_group.kept_fit(tree))
    np.testing.assert_array_equal(after.diffuse.control_points, before.diffuse.control_points)
    np.testing.assert_array_equal(after.specular.coefficients, before.specular.coefficients)
    assert {name: getattr(glossy_material().measured_brdf, name) for name in settings} == settings
    assert not bpy.data.texts, "the former source"
    assert_same(blocks(), 0.5 * old_scene)
    with pytest.raises(RuntimeError, match="are up to date"):
        bpy.ops.measured_brdf.update_materials()


@pytest.mark.parametrize("has_osl", [True, False])
def test_a_mix_of_the_first_version_and_this_one_is_told_as_it_is_rendered_by_nodes(old_scene, tmp_path, glossy,
                                                                                    write_astm, has_osl):
    from measured_brdf.addon.core import material, rendered

    scene, shown = bpy.context.scene, next(item for item in bpy.data.objects if item.active_material)
    bpy.context.view_layer.objects.active = shown
    bpy.ops.measured_brdf.import_data(filepath=str(write_astm(tmp_path / "new.astm", glossy, "new")), preset="Draft")
    bpy.ops.measured_brdf.mix(first="glossy", second="new")
    assert shown.active_material.name == "glossy + new"
    material.use_rendering(shown.active_material, "NODES")
    scene.cycles.shading_system, scene.cycles.samples = has_osl, 32
    how = rendered.in_scene(shown.active_material, scene)
    said = rendered.sentence(how, "NODES")
    if has_osl:
        assert said == "Rendered by nodes, except what an older version made. Update that"
        assert "in part: update" in rendered.summary(scene)
        assert blocks().mean() == pytest.approx(old_scene.mean(), rel=0.05)
    else:
        assert said == "Rendered black, because OSL is off: an older version made it. Update it"
        assert blocks().mean() == pytest.approx(old_scene.mean() / 2, rel=0.05)
    bpy.ops.measured_brdf.update_materials()
    assert rendered.in_scene(shown.active_material, scene).how == "NODES"


def test_copies_that_share_a_shader_go_on_sharing_it(old_scene):
    from measured_brdf.addon.core import material

    copy = glossy_material().copy()
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert material.group_node(copy).node_tree == material.group_node(glossy_material()).node_tree
    assert not material.is_outdated(copy)
    assert not bpy.data.texts, "the former source"


def test_a_shader_that_was_edited_by_hand_is_left_alone(old_scene):
    bpy.data.texts[0].from_string("shader mine() {}")
    before = state()
    with pytest.raises(RuntimeError, match=r"glossy: not a shader of Measured BRDF.*Refit"):
        bpy.ops.measured_brdf.update_materials()
    assert state() == before


@pytest.fixture
def fast_scene(blender, tmp_path):
    """The scene of 0.2.0, opened."""
    if bpy.app.version < (5, 0, 0):
        pytest.skip("this Blender does not open files of 5.0")
    shutil.copy(DATA / "scene-0.2.0.blend", tmp_path)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene-0.2.0.blend"))
    return bpy.data.materials


def test_what_chose_fast_in_version_0_2_is_rendered_by_nodes_once_it_is_updated(fast_scene):
    from measured_brdf.addon.core import material, rendered

    scene = bpy.context.scene
    before = [rendered.in_scene(fast_scene[name], scene).how for name in ("glossy", "glossy + turned", "turned")]
    assert before == ["FAST", "FAST", "EXACT"], "as it always was"
    assert material.rendering_of(fast_scene["glossy"]) == "NODES"
    assert "older version" in rendered.sentence(rendered.in_scene(fast_scene["glossy"], scene), "NODES")
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    after = [rendered.in_scene(fast_scene[name], scene).how for name in ("glossy", "glossy + turned", "turned")]
    assert after == ["NODES", "NODES", "EXACT"]
    picture = np.array(scene["picture"]).reshape(8, 8, 3)
    assert blocks().mean() == pytest.approx(picture.mean(), rel=0.05)
    for item in fast_scene:
        assert "Exact" not in material.surface_node(item).inputs
        assert not material.surface_node(item).inputs["Exact Everywhere"].default_value
        assert bpy.data.node_groups.get("Measured BRDF Lamps.001") is None


def test_values_and_links_of_a_node_of_version_0_2_outlive_an_update(fast_scene):
    from measured_brdf.addon.core import material

    def found(name):
        node = material.group_node(fast_scene[name])
        return {socket.name: (socket.links[0].from_node.name if socket.is_linked
                              else tuple(socket.default_value) if socket.type in {"RGBA", "VECTOR"}
                              else socket.default_value)
                for socket in node.inputs if socket.name not in {"Exact", "Exact Everywhere", "Nodes"}}

    before = {name: found(name) for name in ("glossy", "turned")}
    assert before["glossy"] == {"Tint": (0.5, 0.25, 1, 1), "Strength": 0.5, "Normal": "Mine"}
    assert before["turned"] == {**before["glossy"], "Tangent": "My Tangent", "Rotation": 0.25}
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    assert {name: found(name) for name in before} == before
    mix = material.surface_node(fast_scene["glossy + turned"]).node_tree
    for name in ("First", "Second"):
        given = {socket.name: socket.links[0].from_socket.name for socket in mix.nodes[name].inputs if socket.is_linked}
        assert given["Nodes"] == "Nodes"
        assert given["Exact Everywhere"] == "Exact Everywhere"


def test_an_updated_material_keeps_its_fit_in_the_format_of_fits(old_scene):
    from measured_brdf.addon.core import material, node_group

    before = unbake(node_group.source(material.group_node(glossy_material()).node_tree))
    assert node_group.kept_fit(material.group_node(glossy_material()).node_tree) == b""
    assert bpy.ops.measured_brdf.update_materials() == {"FINISHED"}
    after = fitter.Fit.from_bytes(node_group.kept_fit(material.group_node(glossy_material()).node_tree))
    np.testing.assert_array_equal(after.specular.coefficients, before.specular.coefficients)
    assert after.notation == glossy_material().measured_brdf.fitted_levels


@pytest.fixture
def old_library(tmp_path, glossy, write_astm):
    """The library of 0.1.0 and the folder that it was made of, as far as the seventh digit."""
    shutil.copy(DATA / "library-0.1.0.blend", tmp_path / "library.blend")
    (tmp_path / "glossy").mkdir()
    write_astm(tmp_path / "glossy" / "glossy.astm", glossy, "glossy")
    return tmp_path / "library.blend"


def convert(library):
    return subprocess.run([sys.executable, ROOT, "convert", "glossy", "-o", library, "--preset", "Paper",
                           "--diffuse-level", "1", "--specular-level", "none"], cwd=library.parent, capture_output=True,
                          text=True, check=False, timeout=300)


@release
def test_converting_again_brings_a_library_of_the_first_version_up_to_date(blender, old_library):
    from measured_brdf.addon.core import material, versions

    done = convert(old_library)
    assert done.returncode in EXITS, done.stderr
    assert done.stdout.count("up to date") == 0
    assert "1 done, 0 failed" in done.stdout
    assert convert(old_library).stdout.count("up to date") == 1
    bpy.ops.wm.open_mainfile(filepath=str(old_library))
    assert [item.name for item in bpy.data.materials] == ["glossy"]
    assert versions.made_by(glossy_material()) == versions.CURRENT
    assert not material.is_outdated(glossy_material())
    assert glossy_material().asset_data.catalog_id != "00000000-0000-0000-0000-000000000000"
    assert bpy.data.texts["Measured BRDF Library"]


@pytest.mark.parametrize(("preset", "channels"), quick(
    [("Paper", 3), ("Draft", 3), ("Standard", 1), ("Standard", 3)], ("Paper", 3), ("Standard", 3)))
def test_a_fit_comes_back_from_its_shader(glossy, preset, channels, random):
    from dataclasses import replace

    samples = replace(glossy, values=glossy.values[:, :channels], channels=("R", "G", "B")[:channels])
    fit = fitter.fit(samples, **fitter.PRESETS[preset])
    mixture = any_mixture(fit)
    back = unbake(bake(fit, mixture=mixture), "glossy", fit.compression)
    assert (back.coefficient_count, back.nbytes) == (fit.coefficient_count, fit.nbytes)
    angles = random.random((4, 2000)) * [[1.57], [6.3], [1.57], [6.3]]
    floor = -np.inf if fit.transform is None else 0
    np.testing.assert_allclose(back.evaluate(*angles), np.maximum(fit.evaluate(*angles), floor),
                               rtol=1e-6, atol=1e-7)
    if fit.transform is None:                   # the prior's widths come back by way of their squares
        assert bake(back, mixture=mixture) == bake(fit, mixture=mixture)


def test_equal_channels_come_back_as_one_column(glossy):
    from dataclasses import replace

    samples = replace(glossy, values=glossy.values[:, [0, 1, 0]])
    fit = fitter.fit(samples, 2, 3, 90)
    back = unbake(bake(fit, mixture=any_mixture(fit)))
    assert back.columns == fit.columns == (0, 1, 0)
    np.testing.assert_array_equal(back.diffuse.control_points, fit.diffuse.control_points)


@pytest.mark.parametrize("damage", [("DIFFUSE[", "DIFFUSION["), ("#define STORED 3", "#define STORED 2"),
                                    ("#define DIFFUSE_CELLS 8", "#define DIFFUSE_CELLS 9"),
                                    ("#define LOG_RELATIVE 1", ""),
                                    ("OCCUPANCY[", "OCCUPANCY[1"), ("shader", "x")])
def test_damaged_sources_are_refused(glossy, damage):
    fit = fitter.fit(glossy, **fitter.PRESETS["Draft"])
    source = bake(fit, mixture=any_mixture(fit))
    assert damage[0] in source
    damaged = source.replace(*damage) if damage[0] != "shader" else source[:source.index("DIFFUSE[") + 200]
    with pytest.raises(ValueError, match="shader"):
        unbake(damaged)
