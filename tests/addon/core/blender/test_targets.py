"""What an import is assigned to: the object and the slot that the file was dropped on."""

import math
from functools import partial
from types import SimpleNamespace

import bpy
import pytest
from mathutils import Euler, Matrix, Vector
from measured_brdf.addon.core.blender import targets
from measured_brdf.addon.importing import import_data
from measured_brdf.addon.work import making, process, tasks

from support.stage import add_lamp, black_scene

WIDTH, HEIGHT = 400, 300


@pytest.fixture
def file(tmp_path, glossy, write_astm):
    return str(write_astm(tmp_path / "glossy.astm", glossy))


def looking_down(perspective=True, height=10.0, kind="PERSP"):
    """A 3-D viewport with the camera above the origin, x to the right: as Blender describes it."""
    view = Matrix.Translation((0, 0, height)).inverted()
    aspect = WIDTH / HEIGHT
    if perspective:
        near, far = 0.1, 100.0
        window = Matrix(((1, 0, 0, 0), (0, aspect, 0, 0), (0, 0, -(far + near) / (far - near),
                                                           -2 * far * near / (far - near)), (0, 0, -1, 0)))
    else:                       # 10 wide; a user's orthographic view reaches as far behind its position as before it
        far = 100.0
        window = Matrix(((0.2, 0, 0, 0), (0, 0.2 * aspect, 0, 0), (0, 0, -1 / far, 0), (0, 0, 0, 1)))
    return SimpleNamespace(view_matrix=view, window_matrix=window, perspective_matrix=window @ view,
                           is_perspective=perspective, view_perspective=kind)


def pixel(data, point):
    """Where a point is seen, in the window: the region begins at (50, 60)."""
    x, y, _, w = data.perspective_matrix @ Vector((*point, 1))
    return 50 + WIDTH * (x / w + 1) / 2, 60 + HEIGHT * (y / w + 1) / 2


def context_and_event(data, point, others=()):
    region = SimpleNamespace(type="WINDOW", x=50, y=60, width=WIDTH, height=HEIGHT, data=data)
    space = SimpleNamespace(clip_end=100.0, local_view=None)
    area = SimpleNamespace(type="VIEW_3D", regions=[region, *others], spaces=SimpleNamespace(active=space))
    x, y = pixel(data, point)
    context = SimpleNamespace(window=SimpleNamespace(screen=SimpleNamespace(areas=[area])), scene=bpy.context.scene,
                              object=bpy.context.object, evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get)
    return context, SimpleNamespace(mouse_x=x, mouse_y=y)


def cube(name, place, slots=0, **options):
    bpy.ops.mesh.primitive_cube_add(location=place, **options)
    item = bpy.context.object
    item.name = name
    for number in range(slots):
        item.data.materials.append(bpy.data.materials.new(f"{name} {number}"))
    bpy.context.view_layer.update()
    return item


@pytest.fixture
def scene(blender):
    """Two cubes beside each other; the right one, with three slots, has another material on each side."""
    black_scene(8, 8, samples=1, span=1)
    cube("left", (-2, 0, 0))
    right = cube("right", (2, 0, 0), slots=3)
    for face in right.data.polygons:
        face.material_index = 2 if face.normal.z > 0.5 else 1
    blender.context.view_layer.objects.active = blender.data.objects["left"]
    blender.context.view_layer.update()
    return blender


@pytest.mark.parametrize("perspective", [True, False])
def test_the_object_and_the_face_under_the_mouse_are_found(scene, perspective):
    data = looking_down(perspective)
    for name, point, slot in (("left", (-2.3, 0.2, 1), 0), ("right", (2.1, -0.4, 1), 2)):
        target = targets.find_under_mouse(*context_and_event(data, point))
        assert target == (scene.data.objects[name].session_uid, slot)
    assert targets.find_under_mouse(*context_and_event(data, (0, 0, 1))) is None


def test_an_object_before_the_view_position_of_an_orthographic_view_is_found(scene):
    """Orthographic views show what is behind their position, too; through a camera they do not."""
    low = looking_down(False, height=-50)
    assert targets.find_under_mouse(*context_and_event(low, (2, 0, 1))).slot == 2
    through_camera = looking_down(False, height=-50, kind="CAMERA")
    assert targets.find_under_mouse(*context_and_event(through_camera, (2, 0, 1))) is None
    above = looking_down(False, height=5, kind="CAMERA")
    assert targets.find_under_mouse(*context_and_event(above, (2, 0, 1))).slot == 2


def test_the_nearest_is_meant_and_what_is_drawn_as_wires_is_seen_through(scene):
    above = cube("above", (2, 0, 4))
    data = looking_down(perspective=False)
    assert targets.find_under_mouse(*context_and_event(data, (2, 0, 5))).item == above.session_uid
    above.display_type = "WIRE"
    scene.context.view_layer.update()
    target = targets.find_under_mouse(*context_and_event(data, (2, 0, 5)))
    assert target == (scene.data.objects["right"].session_uid, 2)
    above.display_type, above.hide_viewport = "TEXTURED", True
    scene.context.view_layer.update()
    assert targets.find_under_mouse(*context_and_event(data, (2, 0, 5))) == target


def test_a_collections_instance_means_the_object_that_it_shows(scene):
    group = scene.data.collections.new("group")
    inner = scene.data.objects["left"]
    group.objects.link(inner)
    empty = scene.data.objects.new("instance", None)
    empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", group, (2, 3, 0)
    scene.context.scene.collection.objects.link(empty)
    scene.context.view_layer.update()
    target = targets.find_under_mouse(*context_and_event(looking_down(), (0, 3, 1)))
    assert target.item == inner.session_uid


def test_a_text_and_a_turned_object_with_modifiers_have_faces_too(scene):
    turned = cube("turned", (0, 3, 0), slots=2, size=2)
    turned.rotation_euler = Euler((0, 0, math.radians(30)))
    for face in turned.data.polygons:
        face.material_index = 1 if face.normal.z > 0.5 else 0
    turned.modifiers.new("fine", "SUBSURF").subdivision_type = "SIMPLE"
    scene.ops.object.text_add(location=(-1, -3, 0))
    text = scene.context.object
    text.data.body, text.data.extrude = "III", 0.5
    scene.context.view_layer.update()
    mesh = text.to_mesh()
    front = max((face for face in mesh.polygons if face.normal.z > 0.5), key=lambda face: face.area).center
    letter = text.matrix_world @ front
    text.to_mesh_clear()
    no_texts = bpy.app.version < (4, 3)         # there, rays meet no texts
    for item, point, slot in ((turned, (0.3, 3.2, 1), 1), (text, letter, 0)):
        target = targets.find_under_mouse(*context_and_event(looking_down(), point))
        assert target == (None if item == text and no_texts else (item.session_uid, slot))


def test_what_lies_over_the_viewport_hides_it(scene):
    sidebar = SimpleNamespace(type="UI", x=50, y=60, width=WIDTH, height=HEIGHT)
    assert targets.find_under_mouse(*context_and_event(looking_down(), (2, 0, 1), others=[sidebar])) is None


def test_a_drop_is_assigned_to_the_slot_under_the_mouse_also_when_all_else_changes_meanwhile(scene, file):
    """From the drop to the end of the fit another object, and another slot, may become active."""
    from tests.addon.work.test_at_every_tick import driven, run

    right = scene.data.objects["right"]
    before = [slot.material.name for slot in right.material_slots]
    operator = driven(import_data.MEASUREDBRDF_OT_import_data, import_data.MakesMaterials, directory="", files=[],
                      filepath=file)
    operator.remember_target(*context_and_event(looking_down(), (2, 0, 1)))

    def change():
        right.active_material_index = 0
        scene.ops.mesh.primitive_uv_sphere_add(location=(9, 9, 9))

    operator.work = lambda context: process.Calculation(
        partial(tasks.outcomes, [(file, "")], {"diffuse_level": 1, "specular_level": None}))
    assert run(operator, change, 1)[-1] == {"FINISHED"}
    assert [slot.material.name for slot in right.material_slots] == [*before[:2], "glossy"]
    assert scene.data.objects["left"].active_material is None


CHEAP = {"diffuse_level": 1, "specular_level": -1}


def select(scene, *names):
    for item in scene.context.scene.objects:
        item.select_set(item.name in names)


def shown(scene):
    return {item.name: item.active_material.name for item in scene.data.objects if item.type == "MESH"
            and item.active_material is not None and item.active_material.measured_brdf.coefficients}


def test_all_selected_objects_get_what_is_imported_and_taken_from_the_library(scene, file):
    add_lamp("POINT", 1)
    cube("unselected", (9, 0, 0))
    scene.context.view_layer.objects.active = scene.data.objects["left"]
    select(scene, "left", "right", "lamp", "Light", "Point")
    scene.ops.measured_brdf.import_data(filepath=file, **CHEAP)
    assert shown(scene) == {"left": "glossy", "right": "glossy"}
    scene.data.objects["right"].data.materials.clear()
    scene.ops.measured_brdf.use_published(name="pink-felt")
    assert set(shown(scene).values()) == {scene.data.objects["left"].active_material.name}
    assert set(shown(scene)) == {"left", "right"}
    assert "pink" in scene.data.objects["right"].active_material.name.lower()


def test_objects_that_are_selected_when_a_fit_begins_get_it_whatever_is_selected_at_its_end(scene, file):
    from tests.addon.work.test_at_every_tick import driven, run

    select(scene, "left", "right")
    operator = driven(import_data.MEASUREDBRDF_OT_import_data, import_data.MakesMaterials, directory="", files=[],
                      filepath=file, preset="Paper", diffuse_level=1, specular_level=-1)
    operator.remember_target(scene.context)
    assert run(operator, lambda: (select(scene), cube("other", (9, 9, 9))), 1)[-1] == {"FINISHED"}
    assert shown(scene) == {"left": "glossy", "right": "glossy"}


def test_a_drop_is_for_the_object_under_the_mouse_alone(scene):
    select(scene, "left", "right")
    operator = making.HasTarget()
    operator.target, operator.slot, operator.others = 0, -1, ""
    operator.remember_target(*context_and_event(looking_down(), (2, 0, 1)))
    assert operator.all_targets() == [(scene.data.objects["right"].session_uid, 2)]
    operator.target = 0
    context, event = context_and_event(looking_down(), (0, 0, 1))
    context.selected_objects = scene.context.selected_objects
    operator.remember_target(context, event)
    both = {scene.data.objects[name].session_uid for name in ("left", "right")}
    assert {item for item, _ in operator.all_targets()} == both


def test_a_target_that_has_gone_or_lost_slots_is_told(scene, file, capfd):
    right, left = scene.data.objects["right"], scene.data.objects["left"]
    right.data.materials.pop()
    right.data.materials.pop()
    scene.ops.measured_brdf.import_data(filepath=file, target=right.session_uid, slot=2, **CHEAP)
    assert [slot.material.name for slot in right.material_slots] == ["glossy"]
    gone = left.session_uid
    scene.data.objects.remove(left)
    capfd.readouterr()
    scene.ops.measured_brdf.import_data(filepath=file, target=gone, **CHEAP)
    assert "glossy.001 is not assigned: its object has been removed meanwhile" in capfd.readouterr().out
    assert scene.data.materials["glossy.001"].use_fake_user


def test_drawings_and_volumes_have_no_surface_unless_modifiers_may_make_one(scene):
    material = scene.data.materials.new("measured")
    drawing = "grease_pencil_add" if "grease_pencil_add" in dir(scene.ops.object) else "gpencil_add"
    for make in (getattr(scene.ops.object, drawing), scene.ops.object.volume_add):
        make()
        item = scene.context.object
        before = [slot.material for slot in item.material_slots]
        assert targets.assign(targets.active(scene.context), material) == f"{item.name} has no surface"
        assert [slot.material for slot in item.material_slots] == before
    scene.context.object.modifiers.new("meshes", "NODES")
    assert targets.assign(targets.active(scene.context), material) == ""


def test_objects_that_cannot_have_the_material_are_named(scene, file, tmp_path, capfd):
    scene.context.view_layer.objects.active = None
    scene.ops.measured_brdf.import_data(filepath=file, **CHEAP)
    assert "not assigned: no object was active" in capfd.readouterr().out
    lamp = add_lamp("POINT", 1)
    scene.context.view_layer.objects.active = lamp
    scene.ops.measured_brdf.import_data(filepath=file, **CHEAP)
    assert f"not assigned: {lamp.name} has no surface" in capfd.readouterr().out
    scene.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    black_scene(8, 8, samples=1, span=1)
    with scene.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, linked):
        linked.objects = ["right"]
    theirs = linked.objects[0]
    scene.context.scene.collection.objects.link(theirs)
    before = [slot.material for slot in theirs.material_slots]
    capfd.readouterr()
    scene.ops.measured_brdf.import_data(filepath=file, target=theirs.session_uid, slot=1, **CHEAP)
    told = capfd.readouterr().out
    assert "not assigned: right belongs to another file. Make it local" in told
    assert [slot.material for slot in theirs.material_slots] == before
