import pytest
from measured_brdf.addon.core import checks
from measured_brdf.addon.core.blender import osl_support
from measured_brdf.addon.core.lamps import light_objects
from measured_brdf.addon.core.shading.material import count_rendered

import fitter
from support.stage import EEVEE, add_lamp, black_scene, blank_material, material_for


@pytest.fixture
def scene(blender):
    return black_scene(8, 8, 1, 1)


def keys(scene):
    return [finding.key for finding in checks.check(scene)]


def test_a_neutral_scene_has_nothing_to_fix(blender, scene):
    add_lamp("POINT", 10)
    assert keys(scene) == []
    assert blender.ops.measured_brdf.fix_setting() == {"CANCELLED"}


def test_each_setting_is_found_and_fixed_by_itself(blender, scene):
    lamp = add_lamp("AREA", 10)
    cycles = scene.cycles
    cycles.caustics_reflective = False
    cycles.sample_clamp_indirect, cycles.sample_clamp_direct, cycles.blur_glossy = 10, 5, 1
    lamp.visible_glossy = False
    lamp.data.cycles.use_multiple_importance_sampling = False
    wrong = ["caustics", "clamp_indirect", "clamp_direct", "filter_glossy", "glossy:Area", "importance:Area"]
    assert keys(scene) == wrong
    for key in wrong:
        assert blender.ops.measured_brdf.fix_setting(key=key) == {"FINISHED"}
        assert key not in keys(scene)
    assert cycles.caustics_reflective
    assert cycles.sample_clamp_indirect == cycles.sample_clamp_direct == cycles.blur_glossy == 0
    assert lamp.visible_glossy
    assert lamp.data.cycles.use_multiple_importance_sampling


def test_all_are_fixed_at_once(blender, scene):
    scene.cycles.caustics_reflective, scene.cycles.blur_glossy = False, 1
    assert blender.ops.measured_brdf.fix_setting() == {"FINISHED"}
    assert keys(scene) == []


def test_more_lamps_without_a_size_than_can_be_known_are_reported(blender, scene):
    for _ in range(33):
        add_lamp("POINT", 1, shadow_soft_size=0)
    assert keys(scene) == ["pointlike"]


def test_materials_that_mix_more_than_cycles_has_room_for_are_reported(blender, scene, glossy):
    measured = material_for(fitter.fit(glossy, 2, None)).node_tree.nodes
    tree = next(node for node in measured if node.type == "GROUP").node_tree
    material, group, _ = blank_material("Patina", "ShaderNodeGroup")
    inner = blender.data.node_groups.new("Two of them", "ShaderNodeTree")
    for _ in range(2):
        inner.nodes.new("ShaderNodeGroup").node_tree = tree
    group.node_tree = inner
    blender.ops.mesh.primitive_plane_add()
    blender.context.object.data.materials.append(material)
    assert "mixed:Patina" not in keys(scene)
    material.node_tree.nodes.new("ShaderNodeGroup").node_tree = tree
    assert "mixed:Patina" in keys(scene)
    assert count_rendered(None) == 0, "Blender 4 has materials without nodes"


def measured(blender, glossy, write_astm, folder, **choices):
    blender.ops.mesh.primitive_plane_add()
    path = write_astm(folder / "glossy.astm", glossy)
    blender.ops.measured_brdf.import_data(filepath=str(path), preset="Paper", diffuse_level=1, specular_level=-1,
                                          **choices)
    return blender.context.object.active_material


@pytest.mark.parametrize("without", ["OSL", "Cycles"])
def test_where_osl_cannot_run_the_way_out_of_exact_is_automatic(blender, scene, glossy, write_astm, tmp_path,
                                                                monkeypatch, without):
    material = measured(blender, glossy, write_astm, tmp_path, rendering="EXACT")
    if without == "OSL":
        monkeypatch.setattr(osl_support, "reason_unavailable", lambda: "no OSL")
    else:
        scene.render.engine = EEVEE
    assert "osl" in keys(scene)
    assert blender.ops.measured_brdf.fix_setting(key="osl") == {"FINISHED"}
    assert "osl" not in keys(scene)
    assert material.measured_brdf.rendering == "AUTO"


def test_bump_map_correction_is_found_and_turned_off(blender, scene, glossy, write_astm, tmp_path):
    material = measured(blender, glossy, write_astm, tmp_path)
    assert keys(scene) == [], "imported materials have it off"
    material.cycles.use_bump_map_correction = True
    assert keys(scene) == ["bump:glossy"]
    assert blender.ops.measured_brdf.fix_setting(key="bump:glossy") == {"FINISHED"}
    assert not material.cycles.use_bump_map_correction


def test_the_command_reports_what_it_finds(blender, scene, capfd):
    scene.cycles.sample_clamp_indirect = 10
    assert blender.ops.measured_brdf.check_scene() == {"FINISHED"}
    assert "Clamp Indirect is 10" in capfd.readouterr().out


def test_the_panel_is_drawn_again_without_a_look_at_the_objects(blender, scene, monkeypatch):
    lamp, other = add_lamp("POINT", 10), add_lamp("POINT", 10)
    lamp.visible_glossy = other.visible_glossy = False
    other.hide_viewport = True
    other.name = "Unseen"
    blender.context.view_layer.update()
    before = keys(scene)
    assert before == ["glossy:Point", "glossy:Unseen"]

    def looked(*_):
        raise AssertionError("looked again")

    monkeypatch.setattr(light_objects, "forget", looked)
    monkeypatch.setattr(light_objects, "_rendered_lights", looked)
    assert keys(scene) == before
    lamp.visible_glossy = True
    assert keys(scene) == ["glossy:Unseen"]
    monkeypatch.undo()
    blender.data.objects.remove(other)
    blender.context.view_layer.update()
    assert keys(scene) == []
