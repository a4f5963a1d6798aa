"""The scene's lamps, handed to the shaders: a node group of constants that the measured materials share.

Appending or linking materials brings groups of other files along; all of them are kept up to date, in memory too where
they are linked. A group is known by its nodes, not by its name, which users may change.

The shader puts a lobe at each lamp (`osl/lamps.h`). The lobes, the mixture and the drawn directions sum to the measured
reflectance wherever the lobes stand, so a lamp that is missing here, or stands here and is not seen, costs noise; only
a lamp without any size, which nothing drawn can hit, is seen as the mixture shows it until it is known.
"""

import math

import bpy
from bpy.app.handlers import persistent
from mathutils import Vector

from ..fitter.bake import MAX_LAMPS
from .sky import bright_spots

NAME = "Measured BRDF Lamps"
_LAMPS = "Lamps"
_EVEN = "Even"
_POINTLIKE = 1e-6           # angular radius of a sun without a size, to be told from a lamp
_NODES = (_EVEN, _LAMPS, *(f"{kind}{number}" for number in range(1, MAX_LAMPS + 1) for kind in ("Lamp", "Extent")))
# what moves or holds lamps, or gives other light
_CARRIERS = (bpy.types.Object, bpy.types.Light, bpy.types.Collection, bpy.types.Scene, bpy.types.World)


def node_tree():
    """The shared node group, made where there is none yet."""
    local = next((tree for tree in _trees() if tree.library is None), None)
    return local if local is not None else _create()


def light_is_even(depsgraph):
    """Whether there is light besides that of the lamps, and it is even: a world of one colour, and no surface that
    shines."""
    materials = {slot.material for instance in depsgraph.object_instances for slot in instance.object.material_slots}
    return _is_even(depsgraph.scene.world) and not any(
        _gives_light(material.node_tree) for material in materials if material is not None)


def _is_even(world):
    if world is None:
        return False
    if world.node_tree is None:
        return max(world.color) > 0
    links = world.node_tree.links
    return len(links) > 0 and all(
        link.to_node.type == "OUTPUT_WORLD" and link.to_socket.name == "Surface" and link.from_node.type == "BACKGROUND"
        and link.from_node.inputs["Strength"].default_value * max(link.from_node.inputs["Color"].default_value[:3]) > 0
        for link in links)


def _gives_light(tree):
    """Whether nodes may give light; None for no nodes."""
    if tree is None:
        return False
    for node in tree.nodes:
        strength = node.inputs.get("Emission Strength")
        inside = node.node_tree if node.type == "GROUP" else None
        if (node.type == "EMISSION" or (strength is not None and (strength.is_linked or strength.default_value > 0))
                or _gives_light(inside)):
            return True
    return False


def in_scene(depsgraph):
    """The lamps of an evaluated scene, as the shader takes them.

    Returns
    -------
    list of ((x, y, z), size, strength)
        At most `MAX_LAMPS` that give light, those without a size first (nothing else finds them), then suns, then the
        strongest. A sun: the direction toward it, minus its angular radius (radians), its irradiance. Any other: its
        position, the radius of a ball around what shines (m), and its irradiance at 1 m. Bright places of the world
        are suns.
    """
    found = [_ranked(_lamp(item, matrix)) for item, matrix in _lights(depsgraph) if item.energy > 0]
    found += [_ranked((direction, -radius, light))
              for direction, radius, light in bright_spots(depsgraph.scene.world) if light > 0]
    found.sort()
    return [lamp for *_, lamp in found[:MAX_LAMPS]]


def _lights(depsgraph):
    """Lights and where they stand: those that are evaluated, instances among them, and those that are only rendered."""
    evaluated = set()
    for instance in depsgraph.object_instances:
        if instance.object.type == "LIGHT":
            evaluated.add(instance.object.original)
            yield instance.object.data, instance.matrix_world
    for item in depsgraph.scene.objects:
        if item.type == "LIGHT" and not item.hide_render and item.original not in evaluated:
            yield item.data, item.matrix_world


def _ranked(lamp):
    is_sun = lamp[1] < 0
    return lamp[1] not in (0, -_POINTLIKE), not is_sun, -lamp[2], lamp


def _lamp(light, matrix):
    if light.type == "SUN":
        toward = (matrix.to_3x3() @ Vector((0, 0, 1))).normalized()
        return tuple(toward), -max(light.angle / 2, _POINTLIKE), light.energy
    if light.type == "AREA":
        sides = light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size
        scale = matrix.to_scale()
        halves = sides[0] * scale.x / 2, sides[1] * scale.y / 2
        round_one = light.shape in {"DISK", "ELLIPSE"}
        return tuple(matrix.translation), max(halves) if round_one else math.hypot(*halves), light.energy / math.pi
    return tuple(matrix.translation), light.shadow_soft_size * matrix.median_scale, light.energy / (4 * math.pi)


def store(tree, lamps, even=False):
    """Write the lamps, and whether other light is even, into the shared group; nothing happens where it is there
    already."""
    _set(tree.nodes[_LAMPS].outputs[0], float(len(lamps)))
    _set(tree.nodes[_EVEN].outputs[0], float(even))
    for number, (position, size, strength) in enumerate(lamps, 1):
        for kind, values in (("Lamp", position), ("Extent", (size, strength, 0))):
            for socket, value in zip(tree.nodes[f"{kind}{number}"].inputs, values, strict=True):
                _set(socket, value)


def update(depsgraph):
    """Hand the lamps of an evaluated scene to the measured materials, where there are any."""
    trees = _trees()
    if trees:
        lamps, even = in_scene(depsgraph), light_is_even(depsgraph)
        for tree in trees:
            store(tree, lamps, even)


def _trees():
    """The groups that have all their nodes: a user may have taken one apart, or given its name to something else."""
    return [tree for tree in bpy.data.node_groups
            if tree.bl_idname == "ShaderNodeTree" and all(name in tree.nodes for name in _NODES)]


def _create():
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    for row, name in enumerate((_EVEN, _LAMPS), -1):
        _add(tree, output, "ShaderNodeValue", name, "NodeSocketFloat", row)
        tree.nodes[name].outputs[0].default_value = 0
    for number in range(1, MAX_LAMPS + 1):
        for kind in ("Lamp", "Extent"):
            _add(tree, output, "ShaderNodeCombineXYZ", f"{kind}{number}", "NodeSocketVector", number)
    return tree


def _add(tree, output, kind, name, socket_type, row):
    tree.interface.new_socket(name, in_out="OUTPUT", socket_type=socket_type)
    node = tree.nodes.new(kind)
    node.name = node.label = name
    node.location = (200 if name.startswith("Extent") else 0, -150 * row)
    tree.links.new(node.outputs[0], output.inputs[name])


def _set(socket, value):
    """Assign only what changes: an assignment makes Cycles take the shader up anew."""
    if not math.isclose(socket.default_value, value, rel_tol=1e-6, abs_tol=1e-9):
        socket.default_value = value


@persistent
def _on_update(_scene, depsgraph):
    # looking for lamps takes time in proportion to the instances in the scene: not when a material is being edited
    if any(isinstance(changed.id, _CARRIERS) for changed in depsgraph.updates):
        update(depsgraph)


@persistent
def _on_frame(_scene, depsgraph):
    update(depsgraph)


@persistent
def _on_render(scene, _depsgraph=None):
    if _trees():
        layer = scene.view_layers[0]
        layer.update()              # a script may have moved a lamp since the last evaluation
        update(layer.depsgraph)


_HANDLERS = {"depsgraph_update_post": _on_update, "frame_change_post": _on_frame, "render_pre": _on_render}


def register():
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    for name, handler in _HANDLERS.items():
        handlers = getattr(bpy.app.handlers, name)
        if handler in handlers:
            handlers.remove(handler)
