"""Adds the node of a measured material to the shader that the node editor shows: Shift+A > Measured BRDF."""

import bpy
from bpy.props import StringProperty

from ..core.annotations import OperatorResult, not_none
from ..core.shading import material as materials

ADD_MENU = "NODE_MT_add"     # the menu of Blender that has this one


class MEASUREDBRDF_OT_add_node(bpy.types.Operator):
    """Add the node of this measured material, to mix it with others or to change its inputs"""

    bl_idname = "measured_brdf.add_node"
    bl_label = "Add Measured BRDF"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    material: StringProperty(name="Material", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _edits_shader(context) and context.space_data.edit_tree.is_editable

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        done = self.execute(context)
        if done == {"FINISHED"}:
            bpy.ops.node.translate_attach_remove_on_cancel("INVOKE_DEFAULT")
        return done

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        material = bpy.data.materials.get(self.material)
        surface = materials.surface_node(material) if material is not None else None
        tree = context.space_data.edit_tree
        if surface is None:
            self.report({"ERROR"}, f"{self.material!r} is not a measured material of this file")
            return {"CANCELLED"}
        group = not_none(surface.node_tree)
        if tree == group or group.contains_tree(tree):
            self.report({"ERROR"}, f"{group.name} cannot hold itself")
            return {"CANCELLED"}
        for node in tree.nodes:
            node.select = False
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree, node.width, node.label = group, surface.width, material.name
        node.location = context.space_data.cursor_location
        tree.nodes.active = node
        return {"FINISHED"}


class MEASUREDBRDF_MT_add_node(bpy.types.Menu):
    """The measured materials of this file, as nodes; slices append to it how to make one"""

    bl_idname = "MEASUREDBRDF_MT_add_node"
    bl_label = "Measured BRDF"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _edits_shader(context)

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for item in bpy.data.materials:
            if materials.is_shown(item):
                layout.operator(MEASUREDBRDF_OT_add_node.bl_idname, text=item.name, translate=False,
                                icon="MATERIAL").material = item.name
        layout.separator()


def _edits_shader(context: bpy.types.Context) -> bool:
    space = context.space_data
    return space is not None and space.type == "NODE_EDITOR" and (
        space.tree_type == "ShaderNodeTree" and space.edit_tree is not None)


def entry(menu: bpy.types.Menu, context: bpy.types.Context) -> None:
    if _edits_shader(context):
        menu.layout.separator()
        menu.layout.menu(MEASUREDBRDF_MT_add_node.bl_idname)


classes = (MEASUREDBRDF_OT_add_node, MEASUREDBRDF_MT_add_node)
