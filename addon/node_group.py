"""The node group `Measured BRDF`: a baked shader in an INTERNAL script node, fed by the scene's lamps.

Source and bytecode stay in the .blend, which then needs no other file to be rendered.
"""

import bpy

from ..fitter.bake import bake, fast_error
from . import lamps, osl_support

NAME = "Measured BRDF"
SCRIPT_NODE = "Measured BRDF Shader"
FAST_ERROR = "fast_error"           # custom property of the group: closure_mixture.Mixture.error


class CompileError(RuntimeError):
    """The baked shader could not be compiled here; the message says why."""


def create(fit, source=None):
    """A node group that renders `fit`.

    Parameters
    ----------
    fit : Fit
    source : str, optional
        What `fitter.bake.bake` makes of it, where that has been done.

    Returns
    -------
    bpy.types.ShaderNodeTree

    Raises
    ------
    CompileError
        With nothing left behind, if this Blender cannot compile it.
    """
    reason = osl_support.missing()
    if reason:
        raise CompileError(reason)
    text = bpy.data.texts.new(f"{NAME}.osl")
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    try:
        source = bake(fit) if source is None else source
        text.from_string(source)
        text.cursor_set(0)
        _fill(tree, text)
        tree[FAST_ERROR] = fast_error(source)
    except BaseException:
        bpy.data.node_groups.remove(tree)
        bpy.data.texts.remove(text)
        raise
    return tree


def remove(tree):
    """Remove a group that nothing uses any more, and its source."""
    if tree.users:
        return
    text = script_node(tree).script
    bpy.data.node_groups.remove(tree)
    # a text counts one user for itself, so ask for those that refer to it
    if text is not None and not bpy.data.user_map(subset=[text])[text]:
        bpy.data.texts.remove(text)


def script_node(tree):
    """The script node of a group that `create` made, or None for any other tree."""
    node = tree.nodes.get(SCRIPT_NODE)
    return node if node is not None and node.type == "SCRIPT" else None


def _fill(tree, text):
    tree.interface.new_socket("BSDF", in_out="OUTPUT", socket_type="NodeSocketShader")
    tint = tree.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    tint.default_value = (1, 1, 1, 1)
    tint.description = "Multiplies the measured reflectance; white leaves it as it was measured"
    strength = tree.interface.new_socket("Strength", in_out="INPUT", socket_type="NodeSocketFloat")
    strength.default_value, strength.min_value = 1, 0
    strength.description = "Multiplies the measured reflectance"
    exact = tree.interface.new_socket("Exact", in_out="INPUT", socket_type="NodeSocketBool")
    exact.default_value = True
    exact.description = "Render what was measured, a little noisier; off: the nearest that Cycles samples by itself"
    normal = tree.interface.new_socket("Normal", in_out="INPUT", socket_type="NodeSocketVector")
    normal.hide_value = True
    normal.description = "Shading normal, for bump and normal maps; unconnected, that of the surface"

    script = tree.nodes.new("ShaderNodeScript")
    script.name = script.label = SCRIPT_NODE
    script.mode = "INTERNAL"
    script.script = text
    _compile(script)
    source = tree.nodes.new("NodeGroupInput")
    scene_lamps = tree.nodes.new("ShaderNodeGroup")
    scene_lamps.node_tree = lamps.node_tree()
    output = tree.nodes.new("NodeGroupOutput")
    source.location, scene_lamps.location, output.location = (-300, 100), (-300, -100), (300, 0)
    for name in ("Normal", "Tint", "Strength", "Exact"):
        tree.links.new(source.outputs[name], script.inputs[name])
    for socket in scene_lamps.outputs:
        tree.links.new(socket, script.inputs[socket.name])
    tree.links.new(script.outputs["BSDF"], output.inputs["BSDF"])


def _compile(node):
    """Store the bytecode of the node's text in the node, and make its sockets."""
    from cycles import osl

    complaints = []
    # Blender compiles on assignment where Cycles is the active engine
    if not node.bytecode or "BSDF" not in node.outputs:
        try:
            osl.update_script_node(node, lambda kind, message: complaints.append(message) if "ERROR" in kind else None)
        except OSError as error:                # it compiles in the folder for temporary files
            complaints.append(f"{error.filename or 'temporary files'}: {error.strerror}")
    if not node.bytecode or "BSDF" not in node.outputs:
        raise CompileError("The OSL compiler refused the shader" + "".join(f": {text}" for text in complaints))
