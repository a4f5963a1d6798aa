"""The scene's lamps, handed to the shaders: a node group of constants that the measured materials share.

Appending or linking materials brings groups of other files along; all of them are kept up to date, in memory too where
they are linked. A group is known by its nodes, not by its name, which users may change.

The shader puts a lobe at each lamp that is too small for a drawn direction to hit (`osl/lamps.h`). The lobes and the
drawn directions sum to the measured reflectance wherever the lobes stand, so a lamp that is missing here costs noise;
only a lamp without any size, which nothing drawn can hit, is dark until it is known.
"""

import math

import bpy
from bpy.app.handlers import persistent
from mathutils import Vector

MAX_LAMPS = 8               # as in osl/lamps.h
NAME = "Measured BRDF Lamps"
_LAMPS = "Lamps"
_NODES = (_LAMPS, *(f"{kind}{number}" for number in range(1, MAX_LAMPS + 1) for kind in ("Lamp", "Size")))
_CARRIERS = (bpy.types.Object, bpy.types.Light, bpy.types.Collection, bpy.types.Scene)   # what moves or holds lamps


def node_tree():
    """The shared node group, made where there is none yet."""
    local = next((tree for tree in _trees() if tree.library is None), None)
    return local if local is not None else _create()


def in_scene(depsgraph):
    """The lamps of an evaluated scene, as the shader takes them.

    Returns
    -------
    list of ((x, y, z), size)
        At most `MAX_LAMPS` that give light, those without a size first (nothing else finds them), then suns, then the
        strongest: a sun as the direction toward it and minus its angular radius (radians), a point or spot lamp as its
        position and its radius (m).
    """
    found = []
    for instance in depsgraph.object_instances:
        item = instance.object
        if item.type != "LIGHT" or item.data.type not in {"SUN", "POINT", "SPOT"} or item.data.energy <= 0:
            continue
        matrix, light = instance.matrix_world, item.data
        if light.type == "SUN":
            extent = light.angle / 2
            lamp = tuple((matrix.to_3x3() @ Vector((0, 0, 1))).normalized()), -max(extent, 1e-6)
        else:
            extent = light.shadow_soft_size * matrix.median_scale
            lamp = tuple(matrix.translation), extent
        found.append((extent > 0, light.type != "SUN", -light.energy, lamp))
    found.sort()
    return [lamp for *_, lamp in found[:MAX_LAMPS]]


def store(tree, lamps):
    """Write the lamps into the shared group; does nothing where they are there already."""
    _set(tree.nodes[_LAMPS].outputs[0], float(len(lamps)))
    for number, (position, size) in enumerate(lamps, 1):
        node = tree.nodes[f"Lamp{number}"]
        for socket, value in zip(node.inputs, position, strict=True):
            _set(socket, value)
        _set(tree.nodes[f"Size{number}"].outputs[0], size)


def update(depsgraph):
    """Hand the lamps of an evaluated scene to the measured materials, where there are any."""
    trees = _trees()
    if trees:
        lamps = in_scene(depsgraph)
        for tree in trees:
            store(tree, lamps)


def _trees():
    """The groups that have all their nodes: a user may have taken one apart, or given its name to something else."""
    return [tree for tree in bpy.data.node_groups
            if tree.bl_idname == "ShaderNodeTree" and all(name in tree.nodes for name in _NODES)]


def _create():
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    output = tree.nodes.new("NodeGroupOutput")
    output.location = (400, 0)
    _add(tree, output, "ShaderNodeValue", _LAMPS, "NodeSocketFloat", 0)
    for number in range(1, MAX_LAMPS + 1):
        _add(tree, output, "ShaderNodeCombineXYZ", f"Lamp{number}", "NodeSocketVector", number)
        _add(tree, output, "ShaderNodeValue", f"Size{number}", "NodeSocketFloat", number)
    tree.nodes[_LAMPS].outputs[0].default_value = 0
    return tree


def _add(tree, output, kind, name, socket_type, row):
    tree.interface.new_socket(name, in_out="OUTPUT", socket_type=socket_type)
    node = tree.nodes.new(kind)
    node.name = node.label = name
    node.location = (200 if kind == "ShaderNodeValue" else 0, -150 * row)
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
