"""The node group `Measured BRDF`: a baked shader in an INTERNAL script node, fed by the scene's lamps.

Source and bytecode stay in the .blend, which then needs no other file to be rendered.
"""

import bpy

from ...fitter.cycles.bake import bake, fast_error, interface, shader_version
from ..scene import lamps
from ..transaction import new_data_removed_on_error
from .compiler import CompileError, Shader, compile_shader

NAME = "Measured BRDF"
SCRIPT_NODE = "Measured BRDF Shader"
FAST_ERROR = "fast_error"           # custom property of the group: closure_mixture.Mixture.error
_VERSION = "shader_version"         # custom property of the group; 0.1.0 made groups without one


def create(fit, shader=None):
    """A node group that renders `fit`.

    Parameters
    ----------
    fit : Fit, or None
        None where `shader` is given.
    shader : compiler.Shader, optional
        What has been baked and compiled of the fit already.

    Returns
    -------
    bpy.types.ShaderNodeTree

    Raises
    ------
    CompileError
        With nothing left behind, if this Blender cannot compile it.
    """
    shader = compile_shader(bake(fit)) if shader is None else shader
    with new_data_removed_on_error():
        text = bpy.data.texts.new(f"{NAME}.osl")
        tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
        _fill(tree, text, shader)
        tree[FAST_ERROR] = fast_error(shader.source)
        tree[_VERSION] = shader_version(shader.source)
    return tree


def unused(tree):
    """What is left of a group that nothing uses any more: itself and its source; nothing of one in use, or of None."""
    if tree is None:
        return []
    text = script_node(tree).script
    # what refers to them: a text counts itself as a user, and Blender 4.2 counts groups of copied materials twice
    users = bpy.data.user_map(subset=[tree] if text is None else [tree, text])
    if users[tree] or tree.use_fake_user:
        return []
    return [tree] if text is None or users[text] - {tree} else [tree, text]


def script_node(tree):
    """The script node of a group that `create` made, or None for any other tree."""
    node = tree.nodes.get(SCRIPT_NODE)
    return node if node is not None and node.type == "SCRIPT" else None


def source(tree):
    """The OSL source in a group that `create` made; empty where its text is gone."""
    text = script_node(tree).script
    return "" if text is None else text.as_string()


def version(tree):
    """The version of the shader in a group that `create` made, as `bake.SHADER_VERSION` counts them."""
    stored = tree.get(_VERSION)
    return stored if isinstance(stored, int) else 1


def _fill(tree, text, shader):
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
    _put(script, text, shader)
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


def _put(node, text, shader: Shader):
    """Store a compiled shader in a script node and its text.

    Blender compiles on assignment where Cycles is the active engine, and only then makes the node's sockets. So the
    node gets an empty shader of the same parameters first: 10 ms instead of 150.
    """
    from cycles import osl

    complaints = []
    text.from_string(interface(shader.source))
    node.script = text
    if "BSDF" not in node.outputs:
        try:
            osl.update_script_node(node, lambda kind, message: complaints.append(message) if "ERROR" in kind else None)
        except OSError as error:                # it compiles in the folder for temporary files
            complaints.append(f"{error.filename or 'temporary files'}: {error.strerror}")
    if "BSDF" not in node.outputs:
        raise CompileError("The OSL compiler refused the shader" + "".join(f": {text}" for text in complaints))
    text.from_string(shader.source)
    text.cursor_set(0)
    node.bytecode, node.bytecode_hash = shader.bytecode, shader.bytecode_hash
