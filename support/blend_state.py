"""The state of the open file as plain values: all that must stay the same when an operation changes nothing."""

import bpy

KINDS = ("materials", "node_groups", "texts", "images", "objects", "meshes", "lights", "scenes", "worlds", "libraries")

GROUPS = ("measured_brdf", "measured_brdf_adjustments")


def state():
    """Data-blocks by kind and name, with nodes, links, values, settings and users."""
    users = bpy.data.user_map()             # Blender 4.2 counts some twice
    found = {kind: {item.name: (sorted(user.name for user in users[item] if user != item), item.use_fake_user)
                    for item in getattr(bpy.data, kind)} for kind in KINDS}
    found["nodes"] = {item.name: _tree(item.node_tree) for item in bpy.data.materials if item.node_tree is not None}
    found["groups"] = {tree.name: _tree(tree) for tree in bpy.data.node_groups}
    found["texts"] = {text.name: hash(text.as_string()) for text in bpy.data.texts}
    found["looks"] = {item.name: (tuple(item.diffuse_color), item.roughness, item.metallic,
                                  item.cycles.use_bump_map_correction) for item in bpy.data.materials}
    found["settings"] = {item.name: [_settings(getattr(item, name)) for name in GROUPS] for item in bpy.data.materials}
    found["assets"] = {item.name: _asset(item) for item in bpy.data.materials}
    found["slots"] = {item.name: [slot.material and slot.material.name for slot in item.material_slots]
                      for item in bpy.data.objects}
    return found


def whole_state():
    """The same, with cameras and masks, places, lights, UV maps, and the settings of photographs of all scenes."""
    return {**state(), "cameras": {item.name: item.lens for item in bpy.data.cameras},
            "masks": sorted(item.name for item in bpy.data.masks),
            "places": {item.name: [tuple(row) for row in item.matrix_basis] for item in bpy.data.objects},
            "lit": {light.name: (light.energy, tuple(light.color)) for light in bpy.data.lights},
            "lamps": {item.name: item.data.name for item in bpy.data.objects if item.type == "LIGHT"},
            "uv": {mesh.name: [tuple(each.uv) for layer in mesh.uv_layers for each in layer.data]
                   for mesh in bpy.data.meshes},
            "photographs": {scene.name: _settings(scene.measured_brdf_photographs) for scene in bpy.data.scenes}}


def _settings(group):
    """All properties of a property group by name, with those of its collections, and names of data-blocks."""
    def plain(value):
        if isinstance(value, bpy.types.bpy_prop_collection):
            return [_settings(each) for each in value]
        return value.name if isinstance(value, bpy.types.ID) else _plain(value)
    return {each.identifier: plain(getattr(group, each.identifier)) for each in group.bl_rna.properties
            if each.identifier != "rna_type"}


def _tree(tree):
    nodes = {node.name: (node.bl_idname, node.label, tuple(node.location), _name(getattr(node, "node_tree", None)),
                         getattr(node, "target", None), hash(getattr(node, "bytecode", None)),
                         _values(node.inputs), _values(node.outputs))
             for node in tree.nodes}
    links = sorted((link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
                   for link in tree.links)
    return nodes, links


def _values(sockets):
    return [(socket.identifier, _plain(getattr(socket, "default_value", None))) for socket in sockets]


def _asset(item):
    about = item.asset_data
    return about and (about.description, about.catalog_id, about.author, sorted(tag.name for tag in about.tags))


def _name(item):
    return item and item.name


def _plain(value):
    if hasattr(value, "__len__") and not isinstance(value, str):
        return tuple(map(_plain, value))
    return "not a number" if value != value else value      # such as errors that nobody knows; else never the same
