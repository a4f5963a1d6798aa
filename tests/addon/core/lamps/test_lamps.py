"""Which lamps the shaders know, when, and what the add-on inspects to find out."""

import functools
import math
import threading
from contextlib import contextmanager, nullcontext
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core import checks, lamps

from support.known_lamps import POINTER, known
from support.stage import add, add_lamp, background, black_scene, blank_material, render

NAMES = ["Lamp", 'with "quotes"', "back\\slash", "Lämpchen 灯", "]['"]


@pytest.fixture
def scene(blender):
    return black_scene(8, 8, 1, 1)


def drivers_of(scene):
    """The drivers of a scene's carrier."""
    return scene[POINTER].animation_data.drivers


def in_order(values):
    return np.array(sorted(map(tuple, np.round(values, 4))))


def linear(item, prop, *keys):
    """Keyframes with straight lines between them."""
    for frame, value in keys:
        setattr(item, prop, value)
        item.keyframe_insert(prop, frame=frame)
    straighten(item.animation_data.action)


def straighten(action):
    curves = action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


@pytest.fixture
def material(blender, scene):
    """That of a plane, with the lamp group in it."""
    return use(lamps.node_tree())


@pytest.fixture
def tree(material):
    """The lamp group, which the material of a plane has in it."""
    return lamps.node_tree()


@contextmanager
def handled(function, name="frame_change_post"):
    """Blender calls a function within the block, as a handler of this name."""
    handlers = getattr(bpy.app.handlers, name)
    handlers.append(function)
    try:
        yield
    finally:
        handlers.remove(function)


@contextmanager
def unregistered():
    """Nothing follows lamps within the block but drivers."""
    lamps.unregister()
    try:
        yield
    finally:
        lamps.register()


def use(tree):
    """A plane whose material has the group in it, as measured materials do."""
    bpy.ops.mesh.primitive_plane_add()
    material, node, surface = blank_material("Uses lamps", "ShaderNodeGroup")
    shader, node.node_tree = material.node_tree.nodes.new("ShaderNodeBsdfDiffuse"), tree
    material.node_tree.links.new(shader.outputs[0], surface)
    material.node_tree.links.new(node.outputs["Lamp1"], shader.inputs["Color"])
    bpy.context.object.data.materials.append(material)
    return material


def moving_lamps(scene):
    """Lamps that move in every way, in frames 1 to 11, and where they are by arithmetic: a function of the frame."""
    flown = add_lamp("POINT", 10, shadow_soft_size=0.25)
    linear(flown, "location", (1, (0, 0, 3)), (11, (10, 5, 3)))
    flown.scale = (2, 2, 2)
    carried = add_lamp("SPOT", 7, (1, 0, 0), shadow_soft_size=0)
    arm = add(bpy.data.curves.new("Arm", "CURVE"), (0, 0, 1))
    linear(arm, "rotation_euler", (1, (0, 0, 0)), (11, (0, 0, math.pi)))
    carried.parent = arm
    bound = add_lamp("AREA", 5, shape="RECTANGLE", size=6, size_y=8)
    bound.constraints.new("COPY_LOCATION").target = flown
    turned = add_lamp("SUN", 2, angle=0.2)
    linear(turned, "rotation_euler", (1, (0, 0, 0)), (11, (0, 1.0, 0)))
    dimmed = add_lamp("POINT", 3, (-4, 0, 0), shadow_soft_size=0.5)
    linear(dimmed.data, "energy", (1, 0), (11, 40))
    for item, name in zip((flown, carried, bound, turned, dimmed), NAMES, strict=True):
        item.name = name

    def at(frame):
        t = (frame - 1) / 10
        return np.array([[10 * t, 5 * t, 3, 0.5, 10 / (4 * math.pi)],
                         [math.cos(math.pi * t), math.sin(math.pi * t), 1, 0, 7 / (4 * math.pi)],
                         [10 * t, 5 * t, 3, 5, 5 / math.pi],
                         [math.sin(t), 0, math.cos(t), -0.1, 2],
                         [-4, 0, 0, 0.5, 40 * t / (4 * math.pi)]])

    return at


def seen_in_frames(scene, folder, look):
    """Render frames 1, 6 and 11: what `look(depsgraph)` returns at each, {frame: ...}."""
    seen = {}

    def note(scene, depsgraph):
        if depsgraph.mode == "RENDER":
            seen[scene.frame_current] = look(depsgraph)

    scene.frame_start, scene.frame_end, scene.frame_step = 1, 11, 5
    scene.render.filepath = str(folder / "frame")
    with handled(note):
        bpy.ops.render.render(animation=True)
    assert sorted(seen) == [1, 6, 11]
    return seen


@pytest.mark.parametrize("is_enabled", [True, False])
def test_moving_lamps_are_followed_in_every_frame_that_is_rendered(blender, scene, is_enabled, tmp_path, tree):
    """Rendered without handlers, as on a farm without the extension: what the render's depsgraph evaluates."""
    at = moving_lamps(scene)
    blender.context.view_layer.update()
    with nullcontext() if is_enabled else unregistered():
        seen = seen_in_frames(scene, tmp_path, lambda depsgraph: known(tree, depsgraph))
    for frame, values in seen.items():
        np.testing.assert_allclose(in_order(values), in_order(at(frame)), atol=2e-4, err_msg=str(frame))
    assert all(curve.driver.is_simple_expression and curve.driver.is_valid for curve in drivers_of(scene))


def test_a_lamp_that_is_hidden_in_the_viewport_is_followed_in_the_render(blender, scene, tree):
    lamp = add_lamp("POINT", 10, shadow_soft_size=0)
    lamp.hide_viewport = True
    blender.context.view_layer.update()
    lamp.location = (1, 2, 3)
    seen = []
    with unregistered(), handled(lambda _, depsgraph: seen.append(known(tree, depsgraph))):
        render(scene)
    assert seen[0][0, :3] == pytest.approx((1, 2, 3))


@pytest.mark.parametrize("is_enabled", [True, False])
@pytest.mark.parametrize("hidden", [("hide_render",), ("hide_viewport",), ("hide_render", "hide_viewport")])
def test_a_lamp_that_appears_in_an_animation_is_known_when_it_does(blender, scene, hidden, is_enabled, tmp_path, tree):
    """It is in no picture before only where it is hidden in both ways."""
    lamp = add_lamp("POINT", 4 * math.pi, shadow_soft_size=0)
    for name in hidden:
        for frame, is_hidden in ((1, True), (6, False)):
            setattr(lamp, name, is_hidden)
            lamp.keyframe_insert(name, frame=frame)
    scene.frame_set(1)
    with nullcontext() if is_enabled else unregistered():
        seen = seen_in_frames(scene, tmp_path, lambda depsgraph: known(tree, depsgraph)[:, 4].tolist())
    assert seen == {1: [0 if len(hidden) == 2 else pytest.approx(1)], 6: [pytest.approx(1)], 11: [pytest.approx(1)]}


def test_a_lamp_that_is_gone_leaves_its_last_values_and_no_driver(blender, scene, tree):
    lamp = add_lamp("POINT", 10)
    linear(lamp, "location", (1, (1, 2, 3)), (11, (4, 5, 6)))
    blender.context.view_layer.update()
    with unregistered():
        blender.data.objects.remove(lamp)
        blender.context.view_layer.update()
        scene.frame_set(5)
        assert known(tree)[0, :3] == pytest.approx((1, 2, 3))
    scene.frame_set(6)
    assert len(known(tree)) == 0
    assert len(drivers_of(scene)) == 0


@pytest.mark.parametrize("kind", ["materials", "objects"])
def test_still_lamps_have_no_drivers_and_drivers_bring_no_lamps_along(blender, scene, kind, tmp_path, material):
    plane, name = blender.context.object, blender.context.object.name
    still = add_lamp("POINT", 10)
    blender.context.view_layer.update()
    assert len(drivers_of(scene)) == 0
    linear(still, "location", (1, (0, 0, 0)), (11, (10, 0, 0)))
    blender.context.view_layer.update()
    assert len(drivers_of(scene)) > 0
    path = str(tmp_path / "library.blend")
    blender.data.libraries.write(path, {material if kind == "materials" else plane})
    blender.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    with blender.data.libraries.load(path) as (source, target):
        assert list(source.lights) == []
        setattr(target, kind, getattr(source, kind))
    assert len(blender.data.lights) == 0
    assert [item.name for item in blender.data.objects] == [name] * (kind == "objects")


def test_each_view_layer_is_rendered_with_its_own_lamps(blender, scene, tree):
    layers = [scene.view_layers[0], scene.view_layers.new("Second")]
    for number in range(2):
        collection = blender.data.collections.new(f"Of layer {number}")
        scene.collection.children.link(collection)
        lamp = add_lamp("POINT", 10, (number + 1, 0, 0), shadow_soft_size=0)
        collection.objects.link(lamp)
        scene.collection.objects.unlink(lamp)
        layers[1 - number].layer_collection.children[collection.name].exclude = True
    seen = {}

    def look(_, depsgraph):
        if depsgraph.mode == "RENDER":
            seen[depsgraph.view_layer.name] = known(tree)[:, 0].tolist()

    with handled(look):
        render(scene)
    assert seen == {layers[0].name: [1], "Second": [2]}


@pytest.mark.parametrize("kind", ["POINT", "SUN", "AREA"])
def test_a_lamp_is_as_strong_as_its_exposure_makes_it(blender, scene, kind, tree):
    light = add_lamp(kind, 10).data
    if not hasattr(light, "exposure"):
        pytest.skip("lamps have no exposure in this Blender")
    blender.context.view_layer.update()
    ((*_, before),) = known(tree)
    light.exposure = 3
    blender.context.view_layer.update()
    assert known(tree)[0, 4] == pytest.approx(8 * before)
    linear(light, "exposure", (1, 0), (11, 10))
    blender.context.view_layer.update()
    for frame in (1, 6):
        scene.frame_set(frame)
        assert known(tree)[0, 4] == pytest.approx(2 ** (frame - 1) * before)


def test_a_renamed_lamp_is_followed_on(blender, scene, tree):
    lamp = add_lamp("POINT", 10)
    linear(lamp, "location", (1, (0, 0, 0)), (11, (10, 0, 0)))
    blender.context.view_layer.update()
    lamp.name = "Another"
    blender.context.view_layer.update()
    scene.frame_set(6)
    assert known(tree)[0, 0] == pytest.approx(5)


def test_a_linked_and_a_local_lamp_of_one_name_are_told_apart(blender, scene, tmp_path):
    lamp = add_lamp("POINT", 10)
    linear(lamp, "location", (1, (0, 1, 0)), (11, (10, 1, 0)))
    lamp.name = "Same"
    path = str(tmp_path / "library.blend")
    blender.data.libraries.write(path, {lamp})
    lamp.name = "Other"
    with blender.data.libraries.load(path, link=True) as (_, target):
        target.objects = ["Same"]
    scene.collection.objects.link(target.objects[0])
    lamp.name = "Same"
    linear(lamp, "location", (1, (0, 2, 0)), (11, (20, 2, 0)))
    assert lamp.name == target.objects[0].name
    tree = lamps.node_tree()
    use(tree)
    blender.context.view_layer.update()
    for frame in (6, 11):
        scene.frame_set(frame)
        assert sorted(known(tree)[:, 0]) == pytest.approx([frame - 1, 2 * (frame - 1)])


def test_drivers_stay_where_lamps_change_in_brightness_only(blender, scene, tree):
    """An exchange would make Blender rebuild its dependency graph in every frame."""
    for number in range(2):
        linear(add_lamp("POINT", 1).data, "energy", (1, 10 * number), (11, 10 - 10 * number))
    blender.context.view_layer.update()
    before = [curve.driver.variables[0].targets[0].data_path for curve in drivers_of(scene)]
    scene.frame_set(11)
    assert [curve.driver.variables[0].targets[0].data_path for curve in drivers_of(scene)] == before
    assert sorted(known(tree)[:, 4]) == pytest.approx([0, 10 / (4 * math.pi)])


def animated_sky(scene):
    nodes = scene.world.node_tree.nodes
    sky = nodes.new("ShaderNodeTexSky")
    scene.world.node_tree.links.new(sky.outputs[0], nodes["Background"].inputs["Color"])
    background(scene, 1)
    sky.sun_elevation = 0
    for frame, angle in ((1, 0), (11, math.pi)):
        sky.sun_rotation = angle
        sky.keyframe_insert("sun_rotation", frame=frame)
    straighten(scene.world.node_tree.animation_data.action)


def test_instanced_lamps_and_the_sky_are_followed_in_a_background_animation(blender, scene, tmp_path, tree):
    lamp = add_lamp("POINT", 10, (0, 0, 2), shadow_soft_size=0)
    empty = instance_by_collection(scene, lamp)
    scene.collection.objects.unlink(lamp)
    linear(empty, "location", (1, (0, 0, 0)), (11, (10, 0, 0)))
    animated_sky(scene)
    assert "lock_interface" in [finding.key for finding in checks.check(scene)]
    seen = seen_in_frames(scene, tmp_path, lambda depsgraph: known(tree))
    for frame, (instanced, sun) in seen.items():
        t = (frame - 1) / 10
        assert instanced[:3] == pytest.approx((10 * t, 0, 2), abs=1e-5)
        assert sun[:3] == pytest.approx((math.sin(math.pi * t), math.cos(math.pi * t), 0), abs=1e-5)


# --- threads


def called_from_a_thread(function, failed, *arguments):
    """Call a function as a render job calls handlers; what it raises is listed, since Blender only prints it."""
    def run():
        try:
            function(*arguments)
        except BaseException as error:
            failed.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()


@pytest.mark.parametrize(("locked", "written"), [(False, False), (True, True)])
def test_a_render_thread_writes_and_evaluates_nothing_unless_the_interface_is_locked(
        blender, scene, monkeypatch, locked, written, tree):
    blender.context.view_layer.update()
    lamp = add_lamp("POINT", 10, (1, 2, 3))
    scene.render.use_lock_interface = locked
    if not locked:
        forbid(monkeypatch)
    failed = []
    with unregistered(), handled(functools.partial(called_from_a_thread, lamps._on_evaluation, failed)):
        scene.frame_set(5)
    assert failed == []
    assert (len(known(tree)) == 1) is written
    assert not written or known(tree)[0, :3] == pytest.approx(tuple(lamp.location))


def forbid(monkeypatch):
    """Make whatever writes or looks for lamps fail."""
    def fail(*_, **__):
        raise AssertionError("a render thread must not do this")

    for module, name in ((lamps.group, "store"), (lamps.group, "trees"), (lamps.drivers, "wire"),
                         (lamps.carrier, "store"), (lamps.carrier, "point"),
                         (lamps.instances, "search"), (lamps.light_objects, "shining"), (lamps, "update")):
        monkeypatch.setattr(module, name, fail)


def test_what_a_render_job_holds_up_is_done_after_it(blender, monkeypatch, tree):
    blender.context.view_layer.update()

    class App:
        running = True

        def __getattr__(self, name):
            return getattr(blender.app, name)

        def is_job_running(self, kind):
            return self.running and kind == "RENDER"

    app = App()
    monkeypatch.setattr(lamps, "bpy", type("Module", (), {"app": app, "context": blender.context}))
    add_lamp("POINT", 10, (1, 2, 3))
    blender.context.view_layer.update()
    assert len(known(tree)) == 0
    assert blender.app.timers.is_registered(lamps._retry)
    assert lamps._retry() > 0
    lamps.update(blender.context.view_layer.depsgraph)
    assert len(known(tree)) == 0
    app.running = False
    assert lamps._retry() is None
    assert known(tree)[0, :3] == pytest.approx((1, 2, 3))
    blender.app.timers.unregister(lamps._retry)


def test_a_lamp_that_begins_to_move_by_itself_is_followed_at_once(blender, scene, tree):
    """Nothing of it has changed yet; a render job follows it by drivers alone."""
    lamp = add_lamp("POINT", 10, (1, 2, 3))
    blender.context.view_layer.update()
    assert len(drivers_of(scene)) == 0
    lamp.constraints.new("COPY_LOCATION").influence = 0
    blender.context.view_layer.update()
    assert len(drivers_of(scene)) > 0


# --- the carrier


def node_values(tree):
    """All that Cycles makes constants of: values, names and links of a group's nodes."""
    nodes = [(node.name, node.mute, getattr(node, "attribute_name", ""),
              [socket.default_value for socket in [*node.inputs, *node.outputs] if socket.type == "VALUE"])
             for node in tree.nodes]
    return nodes, [(link.from_node.name, link.to_socket.identifier) for link in tree.links]


@contextmanager
def evaluated():
    """The data-blocks that Blender evaluates within the block."""
    told = []

    def tell(_, graph):
        told.extend(update.id.original for update in graph.updates)

    with handled(tell, "depsgraph_update_post"):
        yield told


def test_a_change_of_a_lamp_changes_no_node(blender, scene, tree, material):
    """Cycles compiles materials again whenever their nodes change, or are marked as changed."""
    lamp = add_lamp("AREA", 10, shape="DISK", size=1)
    layer = blender.context.view_layer
    layer.update()
    before = node_values(tree)
    with evaluated() as told:
        for owner, name, value in ((lamp, "location", (1, 2, 3)), (lamp.data, "energy", 5), (lamp.data, "size", 3),
                                   (lamp.data, "color", (1, 0, 0)), (lamp, "rotation_euler", (1, 0, 0))):
            setattr(owner, name, value)
            layer.update()
            layer.update()
    np.testing.assert_allclose(known(tree), [(1, 2, 3, 1.5, 5 / math.pi)], rtol=1e-6)
    assert node_values(tree) == before
    assert scene[POINTER] in told
    assert not {material, tree, material.node_tree}.intersection(told)


def shows_places(material):
    """Have a material from `use` glow in the place of the first lamp."""
    tree = material.node_tree
    output, glow = tree.get_output_node("CYCLES"), tree.nodes.new("ShaderNodeEmission")
    group = next(node for node in tree.nodes if node.type == "GROUP")
    tree.links.new(group.outputs["Lamp1"], glow.inputs["Color"])
    tree.links.new(glow.outputs[0], output.inputs["Surface"])


def test_a_render_with_kept_data_follows_a_lamp(blender, scene, material):
    shows_places(material)
    scene.render.use_persistent_data = True
    assert render(scene)[4, 4, :3] == pytest.approx((0, 0, 0), abs=1e-6)
    lamp = add_lamp("POINT", 0.001, shadow_soft_size=0.1)
    for place in ((0.25, 0.5, 0.75), (0.5, 1, 2), (-1, -2, 3)):
        lamp.location = place
        blender.context.view_layer.update()
        assert render(scene)[4, 4, :3] == pytest.approx(place, abs=1e-6)


def test_an_object_is_given_its_first_attribute_between_two_renders_with_kept_data(blender, scene, material):
    shows_places(material)
    add_lamp("POINT", 0.001, (0.25, 0.5, 0.75))
    above = add(blender.data.meshes["Plane"].copy(), (0, 0, 1))
    above.data.materials.clear()
    scene.render.use_persistent_data = True
    assert render(scene)[4, 4, :3] == pytest.approx((0, 0, 0), abs=1e-6)
    above.data.materials.append(material)
    layer = blender.context.view_layer
    for _ in range(2):                  # the handler points it out, and then it is evaluated
        layer.update()
    assert above.evaluated_get(layer.depsgraph)[POINTER].original == scene[POINTER], "in a viewport"
    assert render(scene)[4, 4, :3] == pytest.approx((0.25, 0.5, 0.75), abs=1e-6)


def test_objects_point_to_the_carrier_as_long_as_they_have_a_measured_material(blender, scene):
    material, plane, layer = use(lamps.node_tree()), blender.context.object, blender.context.view_layer
    other = add(blender.data.meshes.new("Other"))
    add_lamp("POINT", 10, (1, 2, 3))
    layer.update()
    assert plane[POINTER] == scene[POINTER]
    assert POINTER not in other
    copy = plane.copy()
    scene.collection.objects.link(copy)
    other.data.materials.append(material)
    layer.update()
    assert copy[POINTER] == other[POINTER] == scene[POINTER]
    other.data.materials.clear()
    layer.update()
    assert POINTER not in other
    assert len(blender.data.textures) == 1


def test_an_object_of_no_scene_reads_the_lamps_of_one_and_keeps_to_them(blender, scene, tree):
    """As in a collection that is instanced at another frame."""
    lonely = blender.context.object.copy()
    other = another_scene()
    blender.context.view_layer.update()
    assert lonely[POINTER] == scene[POINTER]
    other.view_layers[0].update()
    assert lonely[POINTER] == scene[POINTER]


def test_no_carrier_is_made_for_materials_that_no_object_has(blender, scene, material):
    blender.data.objects.remove(blender.context.object)
    material.use_fake_user = True
    add_lamp("POINT", 10)
    blender.context.view_layer.update()
    assert POINTER not in scene
    assert len(blender.data.textures) == 0


def test_what_has_a_measured_material_by_nodes_by_a_layer_or_in_an_instance_reads_the_lamps(blender, scene):
    material, plane, layer = use(lamps.node_tree()), blender.context.object, blender.context.view_layer
    add_lamp("POINT", 10, (1, 2, 3))
    tree = blender.data.node_groups.new("Set", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, assign, end = (tree.nodes.new(kind) for kind in ("GeometryNodeMeshCube", "GeometryNodeSetMaterial",
                                                            "NodeGroupOutput"))
    assign.inputs["Material"].default_value = material
    tree.links.new(cube.outputs["Mesh"], assign.inputs["Geometry"])
    tree.links.new(assign.outputs[0], end.inputs[0])
    by_nodes = add(blender.data.meshes.new("By nodes"))
    by_nodes.modifiers.new("Set", "NODES").node_group = tree
    instanced = plane.copy()
    collection = blender.data.collections.new("Instanced")
    collection.objects.link(instanced)
    instancer(scene.collection, collection)
    plain = add(blender.data.meshes.new("Plain"))
    layer.update()
    assert by_nodes[POINTER] == instanced[POINTER] == scene[POINTER]
    assert POINTER not in plain
    layer.material_override = material
    layer.update()
    assert plain[POINTER] == scene[POINTER]


def another_scene(*items):
    other = bpy.data.scenes.new("Another")
    other.camera = bpy.context.scene.camera
    for name in ("engine", "resolution_x", "resolution_y"):
        setattr(other.render, name, getattr(bpy.context.scene.render, name))
    other.cycles.shading_system, other.cycles.samples = True, 1
    for item in items:
        other.collection.objects.link(item)
    return other


def test_each_scene_has_its_own_lamps_and_a_shared_object_those_of_the_scene_that_is_rendered(blender, scene, tree):
    plane = blender.context.object
    add_lamp("POINT", 10, (1, 0, 0), shadow_soft_size=0)
    lamp = add_lamp("POINT", 10, (2, 0, 0), shadow_soft_size=0)
    second = add_lamp("POINT", 5, (3, 0, 0), shadow_soft_size=0)
    other = another_scene(plane, lamp, second)
    for item in (lamp, second):
        scene.collection.objects.unlink(item)
    blender.context.view_layer.update()
    seen = {}

    def look(rendered, depsgraph):
        if depsgraph.mode == "RENDER":
            carrier = plane[POINTER]
            assert carrier == rendered[POINTER]
            seen[rendered.name] = [carrier[f"Lamp{number + 1}"][0] for number in range(carrier["Lamps"])]

    with handled(look):
        for each in (scene, other, scene):
            blender.ops.render.render(scene=each.name)
    assert seen == {scene.name: [1], other.name: [2, 3]}
    # the group is shared: the scene with the most lamps says how many there are
    assert tree.nodes["Lamps"].outputs[0].default_value == 2


def test_a_copied_scene_gets_a_carrier_of_its_own(blender, scene, tree):
    add_lamp("POINT", 10, (1, 2, 3))
    blender.context.view_layer.update()
    first, copy = scene[POINTER], scene.copy()
    assert copy[POINTER] == first
    copy.view_layers[0].update()
    lamps.update(copy.view_layers[0].depsgraph)
    assert scene[POINTER] == first
    assert copy[POINTER] != first
    assert [*copy[POINTER]["Lamp1"]] == [1, 2, 3]


def library_of_a_plane(folder):
    """A file with an object that has a measured material, and a lamp that moves: its path."""
    use(lamps.node_tree())
    linear(add_lamp("POINT", 10), "location", (1, (4, 4, 4)), (11, (9, 9, 9)))
    bpy.context.view_layer.update()
    path = str(folder / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    return path


def test_an_appended_object_reads_the_lamps_of_this_file(blender, scene, tmp_path):
    path = library_of_a_plane(tmp_path)
    scene = black_scene(8, 8, 1, 1)
    add_lamp("POINT", 10, (1, 2, 3))
    blender.ops.wm.append(filepath=f"{path}/Object/Plane", directory=f"{path}/Object/", filename="Plane")
    blender.context.view_layer.update()
    plane = blender.data.objects["Plane"]
    assert plane[POINTER] == scene[POINTER]
    assert len(blender.data.textures) == len(blender.data.lights) == 1
    assert known()[0, :3] == pytest.approx((1, 2, 3))
    assert len(drivers_of(scene)) == 0


@pytest.mark.parametrize("way", ["linked", "overridden", "linked material"])
def test_what_is_linked_reads_the_lamps_of_this_file(blender, scene, way, tmp_path):
    path = library_of_a_plane(tmp_path)
    scene = black_scene(8, 8, 1, 1)
    is_material = way == "linked material"
    with blender.data.libraries.load(path, link=True) as (_, target):
        target.objects, target.materials = (["Plane"], []) if not is_material else ([], ["Uses lamps"])
    if is_material:
        blender.ops.mesh.primitive_plane_add()
        plane = blender.context.object
        plane.data.materials.append(target.materials[0])
    else:
        plane = target.objects[0]
        scene.collection.objects.link(plane)
    if way == "overridden":
        plane = plane.override_create(remap_local_usages=True)
    lamp = add_lamp("POINT", 10, (1, 2, 3))
    moving = add_lamp("POINT", 5)
    linear(moving, "location", (1, (0, 1, 0)), (11, (10, 1, 0)))
    layer = blender.context.view_layer
    for place in ((1, 2, 3), (5, 2, 3)):
        lamp.location = place
        layer.update()
        scene.frame_set(6)
        found = known(depsgraph=layer.depsgraph, item=plane)
        np.testing.assert_allclose(found[:, :3], [place, (5, 1, 0)], atol=1e-5)
    # what points to local data does not outlive a save: others have the carrier of their own file
    assert (plane[POINTER].library is None) == is_material


def test_pointers_and_values_are_saved_undone_and_done_again(blender, tmp_path, tree):
    lamp = add_lamp("POINT", 10, (1, 2, 3))
    layer = blender.context.view_layer
    layer.update()
    blender.ops.ed.undo_push(message="before")
    lamp.location = (4, 5, 6)
    layer.update()
    blender.ops.ed.undo_push(message="moved")
    for step, place in ((blender.ops.ed.undo, (1, 2, 3)), (blender.ops.ed.redo, (4, 5, 6))):
        step()
        blender.context.view_layer.update()
        assert known()[0, :3] == pytest.approx(place)
    path = str(tmp_path / "saved.blend")
    blender.ops.wm.save_as_mainfile(filepath=path)
    with unregistered():
        blender.ops.wm.open_mainfile(filepath=path)
        assert known()[0, :3] == pytest.approx((4, 5, 6))
        assert len(blender.data.textures) == 1


# --- what is inspected


def by_brute_force(scene, layer, depsgraph):
    """The lamps of a scene by looking at every instance and every object: (n, 5), in order."""
    values, taken = [], set()
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT":
            if not instance.is_instance:
                taken.add(instance.object.original)
            if instance.object.data.energy > 0:
                values.append(independent(instance.object.data, np.array(instance.matrix_world)))
    rendered = set()

    def walk(layer_collection):
        if not layer_collection.exclude and not layer_collection.collection.hide_render:
            rendered.update(layer_collection.collection.objects)
            for child in layer_collection.children:
                walk(child)

    walk(layer.layer_collection)
    for item in scene.objects:
        if item.type == "LIGHT" and item not in taken and item in rendered and not item.hide_render:
            evaluated = item.evaluated_get(depsgraph)
            if evaluated.data.energy > 0:
                values.append(independent(evaluated.data, np.array(evaluated.matrix_world)))
    return in_order(np.array(values).reshape(-1, 5))


def independent(light, matrix):
    """A lamp as the shader takes it, from the matrix of its object (4, 4)."""
    if light.type == "SUN":
        toward = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
        return (*toward, -max(light.angle / 2, 1e-6), light.energy)
    return (*matrix[:3, 3], light.shadow_soft_size * np.linalg.norm(matrix[:3, :3] @ np.ones(3)) / math.sqrt(3),
            light.energy / (4 * math.pi))


def edits(scene, random):
    """One random edit, as users make them: its name, and what makes it."""
    objects, collections = list(scene.objects), [scene.collection, *bpy.data.collections]
    lights = [item for item in bpy.data.objects if item.type == "LIGHT"]

    def pick(things):
        return things[random.integers(len(things))]

    def put(item):
        pick(collections).objects.link(item)

    def lamp():
        light = bpy.data.lights.new("L", pick(["POINT", "SUN", "SPOT"]))
        light.energy = 1 + 9 * random.random()
        item = bpy.data.objects.new("L", light)
        item.location = random.random(3) * 9
        put(item)

    def duplicate():
        item = pick(lights).copy()
        item.location.x += 1
        put(item)

    def replace():
        data = pick(lights).data
        bpy.data.objects.remove(next(item for item in lights if item.data == data))
        put(bpy.data.objects.new("R", data))

    def instance():
        within = pick(collections[1:])
        empty = instancer(scene.collection, within)
        empty.location = random.random(3) * 9
        if empty.name in within.all_objects:
            bpy.data.objects.remove(empty)

    def move_to():
        item = pick(lights)
        for collection in [holder for holder in collections if item.name in holder.objects]:
            collection.objects.unlink(item)
        put(item)

    def switch(item, prop):
        setattr(item, prop, not getattr(item, prop))

    def parent():
        child, up = pick(objects), pick(objects)
        while up is not None and up != child:
            up = up.parent
        if up is None:
            child.parent = pick([item for item in objects if item != child and item.parent is None] or [None])

    def vertices():
        item = pick([item for item in objects if item.type == "MESH"])
        if not item.data.vertices:
            item.data.from_pydata([(0, 0, 0), (3, 0, 0)], [], [])
        item.instance_type = pick(["VERTS", "NONE"])

    def swap():
        one, other = pick(lights), pick(lights)
        one.data, other.data = other.data, one.data

    return pick([
        ("lamp", lamp), ("mesh", lambda: put(bpy.data.objects.new("M", pick([None, bpy.data.meshes.new("M")])))),
        ("duplicate", duplicate), ("remove", lambda: bpy.data.objects.remove(pick(lights))), ("replace", replace),
        ("collection", lambda: pick(collections).children.link(bpy.data.collections.new("C"))), ("instance", instance),
        ("move to", move_to),
        ("exclude", lambda: switch(pick(list(bpy.context.view_layer.layer_collection.children)), "exclude")),
        ("hide", lambda: switch(pick([*lights, *collections[1:]]), pick(["hide_viewport", "hide_render"]))),
        ("parent", parent), ("kind", lambda: setattr(pick(lights).data, "type", pick(["POINT", "SUN", "SPOT"]))),
        ("energy", lambda: setattr(pick(lights).data, "energy", pick([0, 1, 5]))),
        ("move", lambda: setattr(pick(objects), "location", random.random(3) * 9)), ("vertices", vertices),
        ("swap", swap), ("rename", lambda: setattr(pick(objects), "name", pick(NAMES))),
        ("hide in layer", lambda: pick(objects).hide_set(pick([True, False]))), ("undo", bpy.ops.ed.undo)])


@pytest.mark.parametrize("seed", range(6))
def test_after_any_edits_the_lamps_are_those_that_a_look_at_everything_finds(blender, scene, seed):
    random = np.random.default_rng(seed)
    tree = lamps.node_tree()
    use(tree)
    group = blender.data.collections.new("C")
    scene.collection.children.link(group)
    for number in range(3):
        add_lamp("POINT", 5, (number, 0, 0), shadow_soft_size=0.1)
    blender.context.view_layer.update()
    done = []
    for _ in range(60):
        name, edit = edits(blender.context.scene, random)
        done.append(name)
        blender.ops.ed.undo_push(message=name)
        try:
            edit()
        except (IndexError, RuntimeError, StopIteration) as error:
            done[-1] += f" ({type(error).__name__})"
        scene, layer = blender.context.scene, blender.context.view_layer
        layer.update()
        layer.update()
        tree, = (tree for tree in blender.data.node_groups if "Lamp1" in tree.nodes)
        expected = by_brute_force(scene, layer, layer.depsgraph)
        got = in_order(known(tree))
        assert got.shape == expected.shape or min(len(got), len(expected)) == 32, done
        if len(expected) <= 32:
            np.testing.assert_allclose(got, expected, atol=2e-3, err_msg=str(done))


def instance_by_collection(scene, lamp):
    collection = bpy.data.collections.new("Lit")
    collection.objects.link(lamp)
    return instancer(scene.collection, collection)


def instance_by_nested_collections(scene, lamp):
    outer = bpy.data.collections.new("Outer")
    instance_by_collection(scene, lamp).users_collection[0].objects.unlink(bpy.data.objects["Instancer"])
    outer.objects.link(bpy.data.objects["Instancer"])
    return instancer(scene.collection, outer)


def instancer(where, collection):
    empty = bpy.data.objects.new("Instancer", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    where.objects.link(empty)
    return empty


def instance_by_vertices(scene, lamp):
    item = add(points())
    scene.collection.objects.link(lamp)
    lamp.parent, item.instance_type = item, "VERTS"
    return item


def instance_by_particles(scene, lamp):
    item = add(points())
    item.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = item.particle_systems[0].settings
    settings.count, settings.emit_from, settings.use_emit_random = 2, "VERT", False
    settings.frame_start, settings.frame_end, settings.physics_type = 1, 1, "NO"
    settings.render_type, settings.instance_object = "OBJECT", lamp
    return item


def instance_by_nodes(scene, lamp):
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, put, what, end = (tree.nodes.new(kind) for kind in (
        "NodeGroupInput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo", "NodeGroupOutput"))
    what.inputs["Object"].default_value = lamp
    what.inputs["As Instance"].default_value = True
    tree.links.new(start.outputs[0], put.inputs["Points"])
    tree.links.new(what.outputs["Geometry"], put.inputs["Instance"])
    tree.links.new(put.outputs["Instances"], end.inputs[0])
    item = add(points())
    item.modifiers.new("Scatter", "NODES").node_group = tree
    return item


def points():
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata([(0, 0, 0), (3, 0, 0)], [], [])
    return mesh


@pytest.mark.parametrize("instanced", [instance_by_collection, instance_by_nested_collections, instance_by_vertices,
                                       instance_by_particles, instance_by_nodes])
def test_lamps_that_are_instanced_are_found_and_followed(blender, scene, instanced, tree):
    lamp = add_lamp("POINT", 10, (0, 0, 1), shadow_soft_size=0.1)
    scene.collection.objects.unlink(lamp)
    layer = blender.context.view_layer
    layer.update()
    assert len(known(tree)) == 0
    item = instanced(scene, lamp)
    for x in (2, 5):
        item.location.x = x
        layer.update()
        expected = by_brute_force(scene, layer, layer.depsgraph)
        assert len(expected) > 0
        assert expected[0, 0] >= x
        np.testing.assert_allclose(in_order(known(tree)), expected, atol=1e-4)
    if item.data is not None:
        item.data.vertices[1].co.x = 7
        item.data.update()
        layer.update()
        np.testing.assert_allclose(in_order(known(tree)), by_brute_force(scene, layer, layer.depsgraph), atol=1e-4)


def test_edits_that_concern_no_instanced_lamp_look_at_no_instance(blender, scene, monkeypatch, tree):
    lit, dark = (blender.data.collections.new(name) for name in ("Lit", "Dark"))
    lamp = add_lamp("POINT", 10)
    inside = blender.data.objects.new("Inside", blender.data.meshes.new("Inside"))
    dark.objects.link(inside)
    instancers = [instancer(scene.collection, collection) for collection in (dark, lit)]
    mesh = add(blender.data.meshes.new("Mesh"))
    material = blender.data.materials.new("Edited")
    mesh.data.materials.append(material)
    layer = blender.context.view_layer
    layer.update()
    looked = []
    look = lamps.instances.search
    monkeypatch.setattr(lamps.instances, "search", lambda *a: looked.append(1) or look(*a))

    def looks(edit):
        looked.clear()
        edit()
        layer.update()
        return len(looked)

    assert looks(lambda: setattr(mesh, "location", (1, 0, 0))) == 0
    assert looks(lambda: setattr(lamp, "location", (1, 0, 0))) == 0
    assert looks(lambda: add(blender.data.meshes.new("Another"))) == 0
    assert looks(lambda: setattr(material, "diffuse_color", (1, 0, 0, 1))) == 0
    assert looks(lambda: setattr(instancers[0], "location", (1, 0, 0))) == 0
    assert looks(lambda: setattr(lamp, "parent", mesh)) == looks(lambda: setattr(lamp, "parent", None)) == 0
    assert looks(lambda: lit.objects.link(lamp)) == 1
    assert looks(lambda: setattr(mesh, "location", (2, 0, 0))) == 0
    assert looks(lambda: setattr(instancers[0], "location", (2, 0, 0))) == 0
    assert looks(lambda: setattr(instancers[1], "location", (2, 0, 0))) == 1
    assert looks(lambda: setattr(material, "diffuse_color", (0, 0, 0, 1))) == 0


def test_groups_of_other_versions_read_the_carrier_and_keep_the_number_of_their_lamps(blender, scene, monkeypatch):
    trees = []
    for count in (4, 34):
        with monkeypatch.context() as patch:
            patch.setattr(lamps.group, "MAX_LAMPS", count)
            trees.append(lamps.group._create())
    trees.append(lamps.node_tree())
    material = use(trees[0])
    for tree in trees[1:]:
        material.node_tree.nodes.new("ShaderNodeGroup").node_tree = tree
    for number in range(40):
        add_lamp("POINT", 1 + number, (number, 0, 0), shadow_soft_size=0.1)
    blender.context.view_layer.update()
    for tree, held in zip(trees, (4, 34, 32), strict=True):
        assert sorted(known(tree)[:, 0]) == pytest.approx(range(40 - held, 40))
    assert lamps.node_tree() == trees[2]


def test_a_group_knows_of_gpus(blender, scene, monkeypatch, tree):
    add_lamp("POINT", 10, (1, 2, 3))
    for gpu in (True, False):
        monkeypatch.setattr(lamps, "renders_on_gpu", lambda scene, gpu=gpu: gpu)
        add_lamp("POINT", 10)
        blender.context.view_layer.update()
        assert tree.nodes["Frugal"].outputs[0].default_value == gpu
        assert len(known(tree)) == 3 - gpu


def test_instanced_lamps_that_move_ask_for_lock_interface(blender, scene, tree):
    lamp = add_lamp("POINT", 10)
    empty = instance_by_collection(scene, lamp)
    scene.collection.objects.unlink(lamp)
    blender.context.view_layer.update()

    def keys():
        return [finding.key for finding in checks.check(scene)]

    assert "lock_interface" not in keys()
    linear(empty, "location", (1, (0, 0, 0)), (11, (10, 0, 0)))
    blender.context.view_layer.update()
    assert "lock_interface" in keys()
    assert blender.ops.measured_brdf.fix_setting(key="lock_interface") == {"FINISHED"}
    assert scene.render.use_lock_interface
    assert "lock_interface" not in keys()


def test_how_many_there_are_is_written_without_copying_materials_which_are_taken_anew(blender, tree, material):
    """Blender copies node trees with their bytecode wherever it copies; nodes of a copy lie elsewhere in memory. One at
    a time, they took 2.6 s instead of 1 ms for 32 lamps, of 300 materials."""
    graph = blender.context.view_layer.depsgraph

    def places():
        return [node.as_pointer() for node in material.evaluated_get(graph).node_tree.nodes]

    blender.context.view_layer.update()
    before = places()
    with unregistered(), evaluated() as told:
        lamps.group.store(tree, 1, False)
        blender.context.view_layer.update()
    assert material in told
    assert places() == before
    inner = next(node.node_tree for node in material.evaluated_get(graph).node_tree.nodes if node.type == "GROUP")
    assert inner.nodes["Lamps"].outputs[0].default_value == 1
    assert (inner.nodes["Extent1"].mute, inner.nodes["Lamp2"].mute) == (False, True)


def test_a_lamp_that_hangs_from_part_of_an_object_can_move(blender, scene):
    """A bone may have constraints of its own, and a vertex goes with the shape."""
    holder = add(points())
    lamp = add_lamp("POINT", 10)
    lamp.parent = holder
    assert not lamps.drivers.can_move(lamp)
    lamp.parent_type = "VERTEX"
    assert lamps.drivers.can_move(lamp)


def test_of_many_changes_none_is_looked_at():
    """A change of frame in a large scene lists every object."""
    looked_at = []
    updates = (looked_at.append(number) for number in range(100_000))
    assert lamps.changes.changed_objects(SimpleNamespace(updates=updates)) is None
    assert len(looked_at) < 200


def test_without_a_measured_material_no_lamps_are_looked_for(blender, monkeypatch):
    """In any other file the extension costs nothing."""
    monkeypatch.setattr(lamps, "_lamps", lambda *_: pytest.fail("lamps were looked for"))
    lamps.update(blender.context.evaluated_depsgraph_get())


def test_only_what_differs_is_written(blender, scene, monkeypatch):
    """Every write into the group makes Cycles compile the materials."""
    module, written, tree, write = lamps.group, [], lamps.node_tree(), lamps.group._write
    monkeypatch.setattr(module, "_write", lambda *given: written.append(write(*given)) or written[-1])
    counts = []
    for count, frugal in ((2, False), (2, False), (2, True), (1, True)):
        written.clear()
        module.store(tree, count, frugal)
        counts.append(sum(written))
    # how many there are, and which nodes are muted; nothing; frugal
    assert counts == [2, 0, 1, 2]


@pytest.mark.parametrize("lost", ["Lamps", "Frugal", "Extent3"])
def test_a_group_that_lost_a_node_is_none(blender, scene, lost):
    tree = lamps.node_tree()
    assert lamps.group.trees() == [tree]
    tree.nodes.remove(tree.nodes[lost])
    assert lamps.group.trees() == []
    assert lamps.node_tree() != tree
