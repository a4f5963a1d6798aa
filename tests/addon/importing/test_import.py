"""The add-on as a script drives it, in background."""

import math

import numpy as np
import pytest
from measured_brdf.addon.work import tasks

import fitter
from support.known_lamps import known, lamp_groups, readers
from support.stage import add_lamp, black_scene, render


@pytest.fixture
def file(tmp_path):
    """An ASTM file of a Lambertian of albedo (0.25, 0.5, 0.75), with an awkward name."""
    path = tmp_path / 'a "b" } #include.astm'
    angles = np.random.default_rng(0).random((400, 3)) * [1.55, 1.55, math.pi]
    value = np.array([0.25, 0.5, 0.75]) / math.pi
    rows = [f"{i:.6f},0,{o:.6f},{phi:.6f},{value[0]:.6f},{value[1]:.6f},{value[2]:.6f}" for i, o, phi in angles]
    header = ['SAMPLE_NAME "; */ } shader evil() { system("x"); }', "VARS theta_i,phi_i,theta_s,phi_s,R,G,B"]
    path.write_text("\n".join([*header, *rows]))
    return path


def counts(bpy):
    return {name: len(getattr(bpy.data, name)) for name in ("materials", "texts", "node_groups", "images", "objects")}


def import_file(bpy, path, **choices):
    return bpy.ops.measured_brdf.import_data(filepath=str(path), **choices)


def test_import_makes_a_material_and_assigns_it_to_the_active_object(blender, cube, file):
    assert import_file(blender, file, diffuse_level=3, specular_level=5, compression=90.0) == {"FINISHED"}
    material = cube.active_material
    settings = material.measured_brdf
    samples = fitter.load(file)
    fit = fitter.fit(samples, 3, 5, 90)
    errors = fitter.error_metrics(samples.values, fit.evaluate(*samples.directions))
    assert (settings.coefficients, settings.bytes) == (fit.coefficient_count, fit.nbytes)
    assert (settings.rmse, settings.mre) == pytest.approx((errors.rmse, errors.mre), rel=1e-4)
    assert settings.seconds > 0
    assert (settings.diffuse_level, settings.specular_level, settings.compression) == (3, 5, 90)
    node = next(n for n in material.node_tree.nodes if n.type == "GROUP")
    assert node.node_tree.name == material.name
    assert {"Normal", "Tint"} <= set(node.inputs.keys())
    script = node.node_tree.nodes["Measured BRDF Shader"]
    assert (script.mode, bool(script.bytecode)) == ("INTERNAL", True)


def test_nothing_from_the_file_or_of_this_machine_gets_into_the_shader(blender, cube, file):
    import_file(blender, file, specular_level=-1, diffuse_level=2)
    node = next(node for node in cube.active_material.node_tree.nodes if node.type == "GROUP")
    bytecode = node.node_tree.nodes["Measured BRDF Shader"].bytecode
    for word in ("evil", file.name, "stdosl.h", "/", "\\"):
        assert word not in bytecode


@pytest.mark.parametrize("lamp", [True, False])
def test_import_with_nothing_active_that_has_a_surface_only_makes_the_material(blender, cube, file, lamp):
    blender.context.view_layer.objects.active = add_lamp("POINT", 1) if lamp else None
    assert import_file(blender, file, diffuse_level=2, specular_level=-1) == {"FINISHED"}
    assert len(blender.data.materials) == 1
    assert cube.active_material is None


def test_an_imported_lambertian_renders_as_one(blender, file):
    scene = black_scene(8, 8, samples=64, span=1)
    blender.ops.mesh.primitive_plane_add(size=4)
    import_file(blender, file, diffuse_level=4, specular_level=6)
    add_lamp("SUN", math.pi, angle=0)
    assert render(scene)[..., :3].mean(axis=(0, 1)) == pytest.approx([0.25, 0.5, 0.75], rel=0.01)


@pytest.mark.parametrize("content", ["nonsense", "VARS theta_i,phi_i,theta_s,phi_s,R,G,B\n1,0,0.5,0,1,2"])
def test_a_failed_import_leaves_the_blend_as_it_was(blender, cube, tmp_path, content):
    path = tmp_path / "bad.astm"
    path.write_text(content)
    before = counts(blender)
    with pytest.raises(RuntimeError, match=r"bad\.astm"):
        import_file(blender, path)
    assert counts(blender) == before
    assert cube.active_material is None


BAD_FILE = {"choose_sample": {"filepath": "{path}", "item": "a"},
            "find_file": {"filepath": "{path}", "refit": True}}


@pytest.mark.parametrize("name", BAD_FILE)
def test_an_operator_that_hands_on_an_unreadable_file_reports_its_error_in_one_line(
        blender, extension, cube, file, tmp_path, monkeypatch, capfd, name):
    if name == "find_file":
        import_file(blender, file, diffuse_level=2, specular_level=-1)
    monkeypatch.setattr(extension.addon.importing.asking, "_items", [("a", "a", "")])
    path = tmp_path / "bad.astm"
    path.write_text("nonsense")
    options = {key: value.format(path=path, folder=tmp_path) if isinstance(value, str) else value
               for key, value in BAD_FILE[name].items()}
    capfd.readouterr()
    with pytest.raises(RuntimeError) as raised:
        getattr(blender.ops.measured_brdf, name)(**options)
    assert str(raised.value).startswith(f"Error: {path}: ")
    assert str(raised.value).count("\n") == 1
    assert "Traceback" not in "".join(capfd.readouterr())


def test_a_fix_that_another_operator_refuses_is_reported_in_one_line(blender, extension, cube, file, monkeypatch):
    checks, fit = extension.addon.core.checks, extension.addon.importing.fit
    import_file(blender, file, diffuse_level=2, specular_level=-1)
    file.write_text("nonsense")
    finding = checks.Finding("a", "Something", "Refit", lambda: fit._refit(cube.active_material))
    monkeypatch.setattr(checks, "check", lambda scene: [finding])
    with pytest.raises(RuntimeError) as raised:
        blender.ops.measured_brdf.fix_setting()
    assert str(raised.value).startswith(f"Error: {file}: ")
    assert str(raised.value).count("\n") == 1


def test_an_import_that_does_not_compile_leaves_the_blend_as_it_was(blender, cube, file, monkeypatch):
    monkeypatch.setattr(tasks, "bake", lambda fit: "shader broken( {")
    before = counts(blender)
    with pytest.raises(RuntimeError, match="compile"):
        import_file(blender, file)
    assert counts(blender) == before


def test_fitting_a_material_of_ones_own_keeps_its_nodes(blender, cube, file):
    material = blender.data.materials.new("Mine")
    if not material.node_tree:
        material.use_nodes = True
    before = {node.name for node in material.node_tree.nodes}
    cube.data.materials.append(material)
    material.measured_brdf.filepath = str(file)
    material.measured_brdf.diffuse_level, material.measured_brdf.specular_level = 2, -1
    assert blender.ops.measured_brdf.fit() == {"FINISHED"}
    nodes = material.node_tree.nodes
    assert before < {node.name for node in nodes}
    surface = next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Surface"]
    assert surface.links[0].from_node.node_tree.name == material.name


def test_undo_takes_the_import_back_and_redo_brings_it_again(blender, cube, file):
    blender.ops.ed.undo_push(message="before")
    import_file(blender, file, diffuse_level=2, specular_level=-1)
    blender.ops.ed.undo_push(message="import")
    blender.ops.ed.undo()
    assert len(blender.data.materials) == 0
    blender.ops.ed.redo()
    assert len(blender.data.materials) == 1
    assert "UNDO" in blender.ops.measured_brdf.import_data.bl_options


def test_enabling_osl(blender):
    scene = blender.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    assert blender.ops.measured_brdf.enable_osl() == {"FINISHED"}
    assert scene.render.engine == "CYCLES"
    assert scene.cycles.shading_system


def known_lamps():
    return [((round(x, 6), round(y, 6), round(z, 6)), round(size, 6)) for x, y, z, size, _ in known().tolist()]


@pytest.mark.parametrize("way", ["appended", "made local"])
def test_what_comes_from_another_file_shares_the_lamp_group_of_this_one(blender, cube, file, tmp_path, way):
    path, name = library_of(blender, cube, file, tmp_path)
    lamp = add_lamp("POINT", 1, (7, 8, 9), shadow_soft_size=0.5)
    blender.ops.mesh.primitive_cube_add()
    import_file(blender, file, diffuse_level=2, specular_level=-1)
    for _ in range(2):
        with blender.data.libraries.load(path, link=way == "made local") as (_, target):
            target.objects = ["theirs"]
        theirs = target.objects[0]
        blender.context.scene.collection.objects.link(theirs)
        if way == "made local":
            theirs.select_set(True)
            blender.context.view_layer.objects.active = theirs
            blender.ops.object.make_local(type="ALL")
    lamp.location.x = 4
    blender.context.view_layer.update()
    group, = lamp_groups()
    assert group.library is None
    for item in readers():
        assert known(item=item)[0, :3] == pytest.approx((4, 8, 9))
    measured = [tree for tree in blender.data.node_groups if tree.name.startswith(name)]
    assert len(measured) == 3
    for tree in measured:
        assert_reads_lamps(tree, group)


def test_an_override_shares_the_lamp_group_of_its_library(blender, cube, file, tmp_path):
    path, name = library_of(blender, cube, file, tmp_path)
    add_lamp("POINT", 1, (7, 8, 9), shadow_soft_size=0.5)
    with blender.data.libraries.load(path, link=True) as (_, target):
        target.materials = [name]
    tree = target.materials[0].override_create(remap_local_usages=True).node_tree
    tree = next(node.node_tree for node in tree.nodes if node.type == "GROUP").override_create(remap_local_usages=True)
    lamps = next(node.node_tree for node in tree.nodes if node.type == "GROUP" and "Lamps" in node.node_tree.nodes)
    lamps.override_create(remap_local_usages=True)
    assert len(lamp_groups()) == 2
    blender.ops.mesh.primitive_cube_add()
    blender.context.view_layer.update()
    group, = lamp_groups()
    assert group.library is not None
    blender.context.object.active_material = target.materials[0]
    blender.context.view_layer.update()
    assert known()[0, :3] == pytest.approx((7, 8, 9))
    measured = [tree for tree in blender.data.node_groups if any(node.type == "SCRIPT" for node in tree.nodes)]
    assert len(measured) == 2
    for tree in measured:
        assert_reads_lamps(tree, group)


def library_of(bpy, cube, file, folder):
    """Import a file and save it, with the cube as "theirs"; begin another: the path, and the name of the material."""
    import_file(bpy, file, diffuse_level=2, specular_level=-1)
    cube.name, name = "theirs", cube.active_material.name
    path = str(folder / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    black_scene(16, 16, samples=8, span=1)
    return path, name


def assert_reads_lamps(tree, group):
    script = next(node for node in tree.nodes if node.type == "SCRIPT")
    node = script.inputs["Lamp1"].links[0].from_node
    assert node.node_tree == group
    assert script.inputs["Lamp1"].links[0].from_socket.name == "Lamp1"


def test_a_lamp_group_may_be_renamed_and_its_name_taken(blender, cube, file):
    import_file(blender, file, diffuse_level=2, specular_level=-1)
    tree = blender.data.node_groups["Measured BRDF Lamps"]
    tree.name = "Mine"
    blender.data.node_groups.new("Measured BRDF Lamps", "GeometryNodeTree")
    add_lamp("POINT", 10)
    blender.context.view_layer.update()
    assert tree.nodes["Lamps"].outputs[0].default_value == 1
    assert import_file(blender, file, diffuse_level=2, specular_level=-1) == {"FINISHED"}


def test_of_many_lamps_those_without_a_size_then_suns_then_the_strongest_are_kept(blender, cube, file):
    import_file(blender, file, diffuse_level=2, specular_level=-1)
    for power in range(36):
        add_lamp("POINT", power, (power, 0, 0), shadow_soft_size=0.1)
    add_lamp("SUN", 0.1, angle=0.01)
    add_lamp("SPOT", 0.01, (40, 0, 0), shadow_soft_size=0)
    blender.context.view_layer.update()
    lamps = known_lamps()
    assert len(lamps) == 32
    assert lamps[0] == ((40, 0, 0), 0)
    assert lamps[1][1] < 0
    assert sorted(position[0] for position, _ in lamps[2:]) == list(range(6, 36))


def test_disabling_leaves_nothing_behind(blender, extension):
    bpy = blender
    extension.unregister()
    try:
        assert not hasattr(bpy.types.Material, "measured_brdf")
        assert "import_data" not in dir(bpy.ops.measured_brdf)
        for name in ("depsgraph_update_post", "frame_change_post", "render_pre"):
            assert not [h for h in getattr(bpy.app.handlers, name) if "measured_brdf" in h.__module__]
    finally:
        extension.register()
