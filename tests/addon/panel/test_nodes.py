"""Shift+A > Measured BRDF, and what is inside of the groups."""

from types import SimpleNamespace

import bpy
import pytest


@pytest.fixture
def editor(cube, quick, tmp_path, glossy, write_astm):
    """A context in which a node editor shows the shader of a cube; two measured materials are in the file."""
    for name in ('a"b', "second"):
        write_astm(tmp_path / "one.astm", glossy, name)
        bpy.ops.measured_brdf.import_data(filepath=str(tmp_path / "one.astm"), diffuse_level=1, specular_level=-1)
    windows = bpy.context.window_manager.windows
    if not windows:
        pytest.skip("this Blender has no window to hold a node editor")
    area = windows[0].screen.areas[0]
    former, area.type = area.type, "NODE_EDITOR"
    area.ui_type = "ShaderNodeTree"
    space = area.spaces.active
    space.path.start(bpy.context.object.active_material.node_tree)
    with bpy.context.temp_override(window=windows[0], area=area, region=area.regions[-1], space_data=space):
        yield space
    area.type = former


def test_the_menu_adds_the_node_of_a_material(editor):
    tree = editor.edit_tree
    before = len(tree.nodes)
    assert bpy.ops.measured_brdf.add_node(material='a"b') == {"FINISHED"}
    assert len(tree.nodes) == before + 1
    added = tree.nodes.active
    assert added.node_tree == next(node for node in bpy.data.materials['a"b'].node_tree.nodes
                                   if node.type == "GROUP").node_tree
    assert {"BSDF", "EEVEE"} <= set(added.outputs.keys())


def test_the_starter_library_is_offered_where_a_material_is_not_measured(editor, extension):
    offered = extension.addon.starter.panel.MEASUREDBRDF_PT_start
    plain = bpy.data.materials.new("plain")
    for material, is_offered in ((None, True), (plain, True), (bpy.data.materials['a"b'], False)):
        assert offered.poll(SimpleNamespace(material=material)) == is_offered


def test_a_name_that_is_not_there_is_refused(editor):
    before = len(editor.edit_tree.nodes)
    with pytest.raises(RuntimeError, match="'nowhere' is not a measured material"):
        bpy.ops.measured_brdf.add_node(material="nowhere")
    assert len(editor.edit_tree.nodes) == before


def test_nodes_inside_of_a_group_lie_in_frames_and_do_not_cover_each_other(editor):
    tree = next(node.node_tree for node in editor.edit_tree.nodes if node.type == "GROUP")
    inside = [node for node in tree.nodes if node.type not in {"FRAME", "GROUP_INPUT", "GROUP_OUTPUT"}]
    assert {node.label for node in tree.nodes if node.type == "FRAME"} == {
        "Exact: in Cycles with OSL", "Where the viewer is", "Nodes: in Cycles without OSL", "In EEVEE"}
    assert sum(node.parent is None for node in inside) == 1          # the Mix Shader of both
    places = [tuple(round(value) for value in node.location) for node in inside]
    assert len(set(places)) == len(places)
    collapsed = {node.type for node in inside if node.hide and len([s for s in node.inputs if s.is_linked]) > 20}
    assert collapsed == {"SCRIPT"}
