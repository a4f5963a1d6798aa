"""The node group `Measured BRDF`: a baked shader in an INTERNAL script node, and closure nodes for other renderers.

The .blend holds bytecode, and the fit, of which another shader can be made. Which of the two shows is a factor from an
output of the script node, which Cycles makes only where it renders with OSL; elsewhere that link is dropped, and the
factor has its own value, 0: the closure nodes. EEVEE has an output of its own, as it has fewer kinds of closures.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import bpy

from ....fitter import Fit
from ....fitter.cycles.bake import SHADER_VERSION, bake, interface
from ....fitter.cycles.node_mixture import Nodes, node_mixtures
from .. import lamps
from ..annotations import not_none
from ..blender import osl_support, shared_groups
from ..blender.node_trees import add_input
from ..blender.transaction import new_data_removed_on_error
from . import closure_nodes
from .compiler import CompileError, Shader, compile_shader

GROUP_NAME = "Measured BRDF"
SCRIPT_NODE = "Measured BRDF Shader"
NODES_ERROR = "nodes_error"         # custom properties of the group: the error of the closure nodes in the mean
NODES_WORST = "nodes_worst"         # and at the worst viewing angle
EEVEE_ERROR = "eevee_error"
EEVEE_WORST = "eevee_worst"
CYCLES_OUTPUT, EEVEE_OUTPUT = "BSDF", "EEVEE"  # outputs
EVERYWHERE = "Exact Everywhere"     # input
SCALE_INPUT = "Scale"               # input of what light goes below: metres per unit
_ACTIVE = "Active"                  # output of the script node: 1 where it renders the surface
_MESH_TANGENT = "MeshTangent"       # input of the script node; the group fills it
_FIT = "fit"                        # custom property of the group: bytes
_BYTES_PROPERTY = "bytes_in_file"   # custom properties of the group, which tell whether a user has changed it
_HASH = "bytecode_hash"
_VERSION_PROPERTY = "shader_version"  # custom property of the group
# what Blender 5.0 writes beside their values, in bytes
_NODE, _SOCKET, _LINK = 500, 640, 88
_MATERIAL = 80_000          # of the material that has the group
_LEAST_SCALE = 1e-6
_SAME_ERRORS = 1e-4         # of errors, relative: the same mixture is not the same to the last digit


def find_or_create(shader: Shader, name: str, unlike: bpy.types.NodeTree | None = None) -> bpy.types.NodeTree:
    """A node group of this file, other than `unlike`, that renders the same fit with the same version of the shader, as
    it was made; else a new one. Raises as `create` does."""
    alike = (tree for tree in bpy.data.node_groups
             if tree.library is None and tree != unlike and _renders(tree, shader))
    return next(alike, None) or create(shader, name)


def create(shader: Shader, name: str = GROUP_NAME) -> bpy.types.NodeTree:
    """Make a node group that renders with a shader; on CompileError the file stays as it was."""
    with new_data_removed_on_error():
        tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
        _fill(tree, shader)
        for key, error in _errors(shader.nodes).items():
            tree[key] = error
        tree[_VERSION_PROPERTY] = SHADER_VERSION
        if shader.fit:
            tree[_FIT] = shader.fit
        tree[_BYTES_PROPERTY], tree[_HASH] = _bytes_in_file(tree), not_none(script_node(tree)).bytecode_hash
    return tree


def bytes_in_file(tree: bpy.types.NodeTree) -> int:
    """About how many bytes a group takes in a .blend without compression; 0 where it is not known."""
    stored = tree.get(_BYTES_PROPERTY)
    return stored if isinstance(stored, int) else 0


def _bytes_in_file(tree: bpy.types.NodeTree) -> int:
    sockets = sum(len(node.inputs) + len(node.outputs) for node in tree.nodes)
    return (len(not_none(script_node(tree)).bytecode) + len(kept_fit(tree)) + _MATERIAL + _NODE * len(tree.nodes)
            + _SOCKET * sockets + _LINK * len(tree.links))


def _renders(tree: bpy.types.NodeTree, shader: Shader) -> bool:
    """Whether a group is as `create` makes it of a shader, as far as can be told."""
    script = script_node(tree)
    return (script is not None and bool(shader.fit) and kept_fit(tree) == shader.fit
            and version(tree) == SHADER_VERSION
            and all(math.isclose(tree.get(key, math.inf), error, rel_tol=_SAME_ERRORS)
                    for key, error in _errors(shader.nodes).items())
            and tree.get(_HASH) == script.bytecode_hash and bytes_in_file(tree) == _bytes_in_file(tree)
            and all(node.node_tree == lamps.node_tree() or shared_groups.is_unchanged(node.node_tree)
                    for node in tree.nodes if node.type == "GROUP"))


def _errors(nodes: Nodes) -> dict[str, float]:
    """What the closure nodes misplace, by custom property of the group."""
    return {NODES_ERROR: nodes.cycles.error, NODES_WORST: nodes.cycles.worst, EEVEE_ERROR: nodes.eevee.error,
            EEVEE_WORST: nodes.eevee.worst}


def make(fit: Fit) -> bpy.types.NodeTree:
    nodes = node_mixtures(fit)
    return create(compile_shader(bake(fit, mixture=nodes.cycles), nodes, fit.to_bytes()))


def unused_groups(tree: bpy.types.NodeTree | None) -> list[bpy.types.ID]:
    """The group and the groups that it shared with others, if nothing uses them; empty for a group in use, or None."""
    # user counts will not do: Blender 4.2 counts the groups of copied materials twice
    if tree is None or bpy.data.user_map(subset=[tree])[tree] or tree.use_fake_user:
        return []
    return [tree, *shared_groups.used_only_by(tree)]


def script_node(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The script node of a group that `create` made; None for any other tree."""
    node = tree.nodes.get(SCRIPT_NODE)
    return node if node is not None and node.type == "SCRIPT" else None


def kept_fit(tree: bpy.types.NodeTree) -> bytes:
    """The fit in a group that `create` made, for `Fit.from_bytes`; empty if it was given none."""
    stored = tree.get(_FIT)
    return stored if isinstance(stored, bytes) else b""


def is_compiled(tree: bpy.types.NodeTree) -> bool:
    return len(not_none(script_node(tree)).outputs) > 0


def version(tree: bpy.types.NodeTree) -> int:
    """The version of a group's shader, as `bake.SHADER_VERSION`; 0 for one to be compiled, in a Blender that can."""
    stored, is_made = tree.get(_VERSION_PROPERTY), is_compiled(tree) or bool(osl_support.reason_unavailable())
    return stored if isinstance(stored, int) and is_made else 0


def _fill(tree: bpy.types.NodeTree, shader: Shader) -> None:
    # values and links of a group's node follow the order in which sockets are made: new ones come last, and what only
    # anisotropic fits have keeps its place
    tree.interface.new_socket(CYCLES_OUTPUT, in_out="OUTPUT", socket_type="NodeSocketShader").description = (
        "The surface for Cycles")
    add_input(tree, "Tint", "Color", "Multiplies the measured reflectance; white keeps it as measured",
              default_value=(1, 1, 1, 1))
    add_input(tree, "Strength", "Float", "Multiplies the measured reflectance", default_value=1, min_value=0)
    normal = add_input(tree, "Normal", "Vector", "Shading normal from a Bump or Normal Map node; by default, that of "
                       "the surface", hide_value=True)
    tree.interface.new_socket(EEVEE_OUTPUT, in_out="OUTPUT", socket_type="NodeSocketShader").description = (
        "The surface for EEVEE")
    nodes = add_input(tree, "Nodes", "Bool", "Approximation by ordinary nodes, on all devices, even where Cycles "
                      "renders with OSL", default_value=False)
    tree.interface.move(nodes, normal.position)
    tangents = _add_tangent(tree, shader.nodes.cycles.turn is not None)
    add_input(tree, EVERYWHERE, "Bool", "For comparisons with other renderers; in pictures nobody sees the difference, "
              "only more noise. Off: exact where the camera sees the surface, directly or through sharp reflection, "
              "glass or transparency; light that has come by a rough surface sees the nodes, which are close. On: "
              "exact for that light too", default_value=False)
    if shader.nodes.walk is not None:
        add_input(tree, SCALE_INPUT, "Float", "Metres that a unit of the scene stands for: where they are few, light "
                  "goes far below the surface, in comparison with the object", default_value=1, min_value=_LEAST_SCALE)

    script = tree.nodes.new("ShaderNodeScript")
    script.name = script.label = SCRIPT_NODE
    script.mode = "INTERNAL"
    if shader.bytecode:                         # else this Blender was built without OSL
        _store(script, shader)
    names = {name: name for name in ("Normal", "Tint", "Strength", "Nodes", *tangents)} | {EVERYWHERE: "Everywhere"}
    source, output = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    source.location, output.location = (-3600, 0), (600, 0)
    with _frame(tree, "Exact: in Cycles with OSL", [script]):
        if shader.bytecode:
            _connect(tree, source, script, names)
    _add_closures(tree, source, script, output, shader.nodes)


def _connect(tree: bpy.types.NodeTree, source: bpy.types.Node, script: bpy.types.Node,
             names: dict[str, str]) -> None:
    """Connect the inputs of the script node: names are {input of the group: parameter of the shader}."""
    script.hide = True                          # as are the lamps: the links between them are many
    if _MESH_TANGENT in script.inputs:
        mesh = tree.nodes.new("ShaderNodeNewGeometry")
        mesh.location = -300, -100
        tree.links.new(mesh.outputs["Tangent"], script.inputs[_MESH_TANGENT])
    scene_lamps = tree.nodes.new("ShaderNodeGroup")
    scene_lamps.node_tree = lamps.node_tree()
    scene_lamps.location, scene_lamps.hide = (-300, 0), True
    for name, parameter in names.items():
        tree.links.new(source.outputs[name], script.inputs[parameter])
    for socket in scene_lamps.outputs:
        if socket.name in script.inputs:
            tree.links.new(socket, script.inputs[socket.name])


def _add_closures(tree: bpy.types.NodeTree, source: bpy.types.Node, script: bpy.types.Node, output: bpy.types.Node,
                  nodes: Nodes) -> None:
    inputs = dict(source.outputs.items())
    with _frame(tree, "Where the viewer is"):
        frame = closure_nodes.add_frame(tree, inputs, nodes.cycles.turn, -3200, -400)
    with _frame(tree, "Nodes: in Cycles without OSL"):
        in_cycles = closure_nodes.add_sum(tree, nodes.cycles, frame, -1200, -900)
    with _frame(tree, "In EEVEE"):
        in_eevee = closure_nodes.add_sum(tree, nodes.eevee, frame, -1200, -2600)
    which = tree.nodes.new("ShaderNodeMixShader")
    which.location = 300, 0
    which.inputs[0].default_value = 0           # where Cycles has no script node
    tree.links.new(in_cycles, which.inputs[1])
    if script.outputs:
        tree.links.new(script.outputs[_ACTIVE], which.inputs[0])
        tree.links.new(script.outputs["BSDF"], which.inputs[2])
    surfaces = {CYCLES_OUTPUT: which.outputs[0], EEVEE_OUTPUT: in_eevee}
    if nodes.walk is not None:
        with _frame(tree, "Below the surface"):
            surfaces = {name: closure_nodes.add_walk(tree, nodes.walk, name == CYCLES_OUTPUT, inputs, frame, above,
                                                     -1200, 900 - 400 * number)
                        for number, (name, above) in enumerate(surfaces.items())}
    for name, surface in surfaces.items():
        tree.links.new(surface, output.inputs[name])


@contextmanager
def _frame(tree: bpy.types.NodeTree, label: str, others: Sequence[bpy.types.Node] = ()) -> Iterator[None]:
    """Put the nodes that the block adds, and others, into a frame with a label."""
    before = {node.name for node in tree.nodes}
    yield
    frame = tree.nodes.new("NodeFrame")
    frame.label = label
    for node in [*others, *(node for node in tree.nodes if node.name not in before)]:
        if node != frame:
            node.parent = frame


def _add_tangent(tree: bpy.types.NodeTree, is_anisotropic: bool) -> list[str]:
    """The inputs of an anisotropic fit, as Blender's anisotropic nodes have them, or their places; their names."""
    sockets = [
        add_input(tree, "Tangent", "Vector", "Direction in which the surface was measured at 0 degrees, from a Tangent "
                  "node; by default, around the Z axis of the object", hide_value=True),
        add_input(tree, "Rotation", "Float", "Turns the surface about its normal, counter-clockwise; 1 is a whole turn",
                  subtype="FACTOR", min_value=0, max_value=1)]
    if is_anisotropic:
        return [socket.name for socket in sockets]
    for socket in sockets:
        tree.interface.remove(socket)
    return []


def _store(node: bpy.types.Node, shader: Shader) -> None:
    # it gets its sockets by compiling: an empty shader of the same parameters takes 10 ms instead of 150
    compile_node(node, interface(shader.source))
    node.bytecode, node.bytecode_hash = shader.bytecode, shader.bytecode_hash


def compile_node(node: bpy.types.Node, source: str) -> None:
    """Give a script node in INTERNAL mode a small shader with an output `Active`. Raises CompileError."""
    from cycles import osl

    errors: list[str] = []

    def report(kind: set[str], message: str) -> None:
        if "ERROR" in kind:
            errors.append(message)

    text = bpy.data.texts.new(node.name)
    text.from_string(source)
    node.script = text
    if _ACTIVE not in node.outputs:
        try:
            osl.update_script_node(node, report)
        except OSError as error:                # it compiles in the folder for temporary files
            errors.append(f"{error.filename or 'temporary files'}: {error.strerror}")
    bpy.data.texts.remove(text)
    if _ACTIVE not in node.outputs:
        raise CompileError("The OSL compiler rejected the shader" + "".join(f": {message}" for message in errors))
