"""Flakes: cells of the surface, each of which is tilted a little, so that each shows the highlight from elsewhere."""

import bpy

from ..core.annotations import OperatorResult, not_none
from ..core.blender import shared_groups
from ..core.blender.active_material import active_material, is_editable
from ..core.blender.node_trees import add_input
from ..core.shading import material as materials

_FLAKES_KIND = "Flakes"
_NORMAL_SOCKET = "Normal"   # input of the groups, and input and output of the flakes'
_SIZE, _FLAKE_SPREAD = 0.005, 0.1  # units of the object, and radians


class MEASUREDBRDF_OT_add_flakes(bpy.types.Operator):
    """Give the surface sparkling flakes: cells that are tilted by chance. The measured highlight has those of the \
material already, as many at once as the instrument saw, and becomes a little wider"""

    bl_idname = "measured_brdf.add_flakes"
    bl_label = "Add Flakes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return (is_editable(cls, context) and target is not None
                and (node := materials.surface_node(target)) is not None and not has_flakes(node))

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        node = not_none(materials.surface_node(not_none(active_material(context))))
        tree, normal = node.id_data, node.inputs[_NORMAL_SOCKET]
        flakes = tree.nodes.new("ShaderNodeGroup")
        flakes.node_tree = shared_groups.shared_group(_FLAKES_KIND, _fill)
        flakes.location, flakes.width = (node.location.x - 240, node.location.y - 200), 180
        if normal.is_linked:                    # a bump or normal map, which the flakes lie on
            tree.links.new(not_none(normal.links)[0].from_socket, flakes.inputs[_NORMAL_SOCKET])
        tree.links.new(flakes.outputs[_NORMAL_SOCKET], normal)
        return {"FINISHED"}


def has_flakes(node: bpy.types.Node) -> bool:
    links = node.inputs[_NORMAL_SOCKET].links or ()
    return any(getattr(link.from_node, "node_tree", None) is not None
               and shared_groups.is_unchanged(link.from_node.node_tree) for link in links)


def _fill(tree: bpy.types.NodeTree) -> None:
    add_input(tree, "Size", "Float", "Width of a flake, in units of the object",
              default_value=_SIZE, min_value=1e-6, subtype="DISTANCE")
    add_input(tree, "Spread", "Float", "How far flakes are tilted at most, to each side",
              default_value=_FLAKE_SPREAD, min_value=0, max_value=1, subtype="ANGLE")
    add_input(tree, _NORMAL_SOCKET, "Vector", "Normal of what the flakes lie on, from a Bump or Normal Map node; by "
              "default, the surface's", hide_value=True)
    not_none(tree.interface).new_socket(_NORMAL_SOCKET, in_out="OUTPUT", socket_type="NodeSocketVector")
    source, output = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    place, surface = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeNewGeometry")

    def math(kind: str, operation: str, *operands: bpy.types.NodeSocket | float | tuple[float, ...],
             result: str | int = 0) -> bpy.types.NodeSocket:
        node = tree.nodes.new(kind)
        node.operation = operation
        for socket, operand in zip(node.inputs, operands, strict=False):
            if isinstance(operand, bpy.types.NodeSocket):
                tree.links.new(operand, socket)
            else:
                socket.default_value = operand
        return node.outputs[result]

    number, vector = "ShaderNodeMath", "ShaderNodeVectorMath"
    cells = tree.nodes.new("ShaderNodeTexVoronoi")
    cells.inputs["Scale"].default_value = 1
    scaled = math(vector, "DIVIDE", place.outputs["Object"], source.outputs["Size"])
    tree.links.new(scaled, cells.inputs["Vector"])
    chance = math(vector, "MULTIPLY_ADD", cells.outputs["Color"], (2, 2, 2), (-1, -1, -1))
    slope = math(number, "TANGENT", source.outputs["Spread"])
    tilt = math(vector, "MULTIPLY", chance, slope)
    is_bare = math(number, "LESS_THAN", math(vector, "LENGTH", source.outputs[_NORMAL_SOCKET], result="Value"), 0.5)
    bare = math(vector, "MULTIPLY", surface.outputs["Normal"], is_bare)
    normal = math(vector, "ADD", math(vector, "ADD", source.outputs[_NORMAL_SOCKET], bare), tilt)
    tree.links.new(math(vector, "NORMALIZE", normal), output.inputs[_NORMAL_SOCKET])
    for step, node in enumerate(tree.nodes):
        node.location = 200 * step, 0


classes = (MEASUREDBRDF_OT_add_flakes,)
