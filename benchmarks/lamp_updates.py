"""Part of ``make bench-scale``: the cost of following lamps at each edit of a scene of a hundred thousand instances.

python -m benchmarks.lamp_updates [INSTANCES] runs with another number. Times are those of the extension's own work, the
median of five edits, beside those of looking at the whole scene, as earlier versions did at each edit.
"""

import statistics
import sys
import time

from support import checkout

EDITS = 5
MILLISECONDS = 1e3


def mesh_objects(bpy, scene, count):
    """So many mesh objects, and one that is edited."""
    mesh = triangle(bpy)
    for _ in range(count):
        scene.collection.objects.link(bpy.data.objects.new("Mesh", mesh))
    return scene.objects["Mesh"]


def collection_instances(bpy, scene, count):
    """So many instances of a collection without lights, one of which is edited."""
    collection = bpy.data.collections.new("Instanced")
    collection.objects.link(bpy.data.objects.new("Inside", triangle(bpy)))
    for _ in range(count):
        empty = bpy.data.objects.new("Instance", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        scene.collection.objects.link(empty)
    return scene.objects["Instance"]


def scatter(bpy, scene, count):
    """One object that instances another so many times in geometry nodes."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    line, put, what = (tree.nodes.new(kind) for kind in ("GeometryNodeMeshLine", "GeometryNodeInstanceOnPoints",
                                                         "GeometryNodeObjectInfo"))
    line.inputs["Count"].default_value = count
    what.inputs["Object"].default_value = bpy.data.objects.new("Inside", triangle(bpy))
    what.inputs["As Instance"].default_value = True
    tree.links.new(line.outputs["Mesh"], put.inputs["Points"])
    tree.links.new(what.outputs["Geometry"], put.inputs["Instance"])
    tree.links.new(put.outputs["Instances"], tree.nodes.new("NodeGroupOutput").inputs["Geometry"])
    item = bpy.data.objects.new("Scatter", triangle(bpy))
    item.modifiers.new("Scatter", "NODES").node_group = tree
    scene.collection.objects.link(item)
    return item


def triangle(bpy):
    mesh = bpy.data.meshes.new("Triangle")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    return mesh


def measure(extension, bpy, count, populate):
    """Print the times of some edits in one scene."""
    from support.stage import add, add_lamp, black_scene

    scene = black_scene(8, 8, 1, 1)
    lamps = extension.addon.core.lamps
    moved, other = populate(bpy, scene, count), add(triangle(bpy))
    material = bpy.data.materials.new("Edited")
    other.data.materials.append(material)
    sources = [add_lamp("POINT", 10 + number, (number, 0, 0)) for number in range(20)]
    lamps.node_tree()
    layer = bpy.context.view_layer
    layer.update()
    edits = {
        "an instancer moves": lambda step: setattr(moved, "location", (step, 0, 0)),
        "a mesh moves": lambda step: setattr(other, "location", (step, 0, 0)),
        "a mesh is added": lambda step: add(triangle(bpy)),
        "a material is edited": lambda step: setattr(material, "diffuse_color", (step / EDITS, 0, 0, 1)),
        "a lamp moves": lambda step: setattr(sources[0], "location", (0, step, 0)),
    }
    print(f"{count} {populate.__name__.replace('_', ' ')}")
    for name, edit in edits.items():
        spent = []
        for step in range(1, EDITS + 1):
            edit(step)
            spent.append(seconds_of_handlers(lamps, layer))
        start = time.thread_time()
        look_at_everything(layer.depsgraph)
        print_row(name, statistics.median(spent), time.thread_time() - start)
    layer.update()


def look_at_everything(depsgraph):
    """The least that a look at all instances has to do: ask which are lights, and for their materials."""
    lights, materials = [], set()
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT":
            lights.append(instance.matrix_world.copy())
        materials.update(slot.material for slot in instance.object.material_slots)
    return lights, materials


def seconds_of_handlers(lamps, layer):
    """The seconds that the extension takes of one evaluation."""
    import bpy

    handlers = bpy.app.handlers.depsgraph_update_post
    before = [*handlers]
    spent = []

    def timed(scene, depsgraph):
        start = time.thread_time()
        for handler in before:
            handler(scene, depsgraph)
        spent.append(time.thread_time() - start)

    handlers[:] = [timed]
    layer.update()
    handlers[:] = before
    return sum(spent)


def panel(extension, bpy, count):
    """Print the time in which the panel checks a scene of so many objects."""
    from support.stage import add_lamp, black_scene

    scene = black_scene(8, 8, 1, 1)
    mesh_objects(bpy, scene, count)
    for _ in range(20):
        add_lamp("POINT", 1)
    bpy.context.view_layer.update()
    checks = extension.addon.core.checks
    checks.check(scene)
    spent = []
    for _ in range(EDITS):
        start = time.thread_time()
        checks.check(scene)
        spent.append(time.thread_time() - start)
    start = time.thread_time()
    assert sum(item.type == "LIGHT" for item in scene.objects) == 20
    print(f"{count} objects")
    print_row("the panel is drawn", statistics.median(spent), time.thread_time() - start)


def print_row(name, spent, everything):
    print(f"  {name:22} {spent * MILLISECONDS:8.2f} ms   look at everything {everything * MILLISECONDS:8.1f} ms   "
          f"{everything / spent:7.0f} times", flush=True)


def main(count=100_000):
    """Print the table."""
    extension = checkout.extension()
    extension.register()
    import bpy

    for populate in (scatter, collection_instances, mesh_objects):
        measure(extension, bpy, count, populate)
    panel(extension, bpy, count // 5)
    extension.unregister()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
