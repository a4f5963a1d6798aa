"""A sum of Blender's closure nodes (`fitter.cycles.node_mixture`) in a node group, of groups that all materials share.
"""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import bpy
import numpy as np

from ....fitter.arrays import FloatArray, RealArray
from ....fitter.cycles.node_lobes import Kind
from ....fitter.cycles.node_mixture import NodeMixture
from ....fitter.optics.subsurface import Walk
from ....fitter.shader_constants import LEAST_FACING
from ..blender.shared_groups import shared_group

_DISTRIBUTIONS: dict[Kind, str] = {"GGX": "GGX", "Beckmann": "BECKMANN"}
_UNCONNECTED = 0.5          # a normal or tangent that is shorter is an unconnected input
_ANY = (1.3e-5, 0.7e-5, 1.1e-5)     # added to tangents, so that none is without direction
_MILLIMETRE = 1e-3          # m
_PLACE_WIDTH, _HEIGHT = 200, 260    # of a place in the node editor
_FRAME_INPUTS = {"Tint": "Color", "Strength": "Float", "Normal": "Vector"}

_Value = bpy.types.NodeSocket | float | tuple[float, ...]
Sockets = dict[str, bpy.types.NodeSocket]


class _Builder:
    """Adds nodes to a tree, each at the next place of a row."""

    def __init__(self, tree: bpy.types.NodeTree, x: float, y: float) -> None:
        self.tree, self.x, self.y = tree, x, y

    def node(self, kind: str, given: Mapping[Any, _Value] | None = None,
             **settings: str | bool | bpy.types.NodeTree) -> bpy.types.Node:
        """A node with these settings, and values or links of its inputs, by their names or places."""
        node = self.tree.nodes.new(kind)
        for name, setting in settings.items():
            setattr(node, name, setting)
        node.location = self.x, self.y
        node.hide = kind in {"ShaderNodeMath", "ShaderNodeVectorMath", "ShaderNodeSeparateXYZ"}
        self.x += _PLACE_WIDTH
        for key, value in (given or {}).items():
            self.put(node.inputs[key], value)
        return node

    def put(self, socket: bpy.types.NodeSocket, value: _Value) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def group(self, kind: str, fill: Callable[[bpy.types.NodeTree], None], given: Mapping[str, _Value]
              ) -> bpy.types.Node:
        return self.node("ShaderNodeGroup", given, node_tree=shared_group(kind, fill))

    def math(self, operation: str, *values: _Value) -> bpy.types.NodeSocket:
        return self.node("ShaderNodeMath", dict(enumerate(values)), operation=operation).outputs[0]

    def vector(self, operation: str, *values: _Value, output: str = "Vector") -> bpy.types.NodeSocket:
        return self.node("ShaderNodeVectorMath", dict(enumerate(values)), operation=operation).outputs[output]

    def connected_or(self, socket: bpy.types.NodeSocket, default: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """A vector, or another where it is an unconnected input, which is 0."""
        missing = self.math("LESS_THAN", self.vector("LENGTH", socket, output="Value"), _UNCONNECTED)
        return self.vector("MULTIPLY_ADD", default, missing, socket)


def add_frame(tree: bpy.types.NodeTree, inputs: Sockets, turn: float | None, x: float, y: float) -> Sockets:
    """What the lobes of all sums of a group share, by name, at a place in the node editor; `turn`: see `NodeMixture`.

    "Colour" multiplies the colours of lobes. "Normal" is the shading normal, a unit vector that the viewer sees; "Away"
    leads from its tip to that of the direction of the viewer. "Polar" is the polar angle of the viewer as a share of a
    right angle, and "Phase" the squared cosine of its azimuth from the first principal axis, of anisotropic fits.
    """
    build = _Builder(tree, x, y)
    given: dict[str, _Value] = {name: inputs[name] for name in _FRAME_INPUTS}
    if turn is None:
        node = build.group("Frame", _fill_frame, given)
    else:
        given |= {"Tangent": inputs["Tangent"], "Rotation": inputs["Rotation"], "Turn": turn}
        node = build.group("Turned Frame", _fill_turned_frame, given)
    return dict(node.outputs.items())


def _fill_frame(tree: bpy.types.NodeTree) -> None:
    _group_outputs(tree, _frame(_Builder(tree, 0, 0), _group_inputs(tree, _FRAME_INPUTS)))


def _fill_turned_frame(tree: bpy.types.NodeTree) -> None:
    inputs = _group_inputs(tree, _FRAME_INPUTS | {"Tangent": "Vector", "Rotation": "Float", "Turn": "Float"})
    frame = _frame(_Builder(tree, 0, 0), inputs)
    build = _Builder(tree, 0, -_HEIGHT)
    surface = build.node("ShaderNodeNewGeometry")
    viewer = surface.outputs["Incoming"]
    across = build.vector("NORMALIZE", build.vector(
        "CROSS_PRODUCT", frame["Normal"],
        build.vector("ADD", build.connected_or(inputs["Tangent"], surface.outputs["Tangent"]), _ANY)))
    tangent = build.node("ShaderNodeVectorRotate", {
        "Vector": build.vector("CROSS_PRODUCT", across, frame["Normal"]), "Axis": frame["Normal"],
        "Angle": build.math("MULTIPLY_ADD", inputs["Rotation"], 2 * math.pi, inputs["Turn"])},
        rotation_type="AXIS_ANGLE").outputs[0]
    along = build.vector("DOT_PRODUCT", viewer, tangent, output="Value")
    cosine = build.vector("DOT_PRODUCT", frame["Normal"], viewer, output="Value")
    sine2 = build.math("SUBTRACT", 1.0 + 1e-6, build.math("MULTIPLY", cosine, cosine))
    phase = build.math("DIVIDE", build.math("MULTIPLY", along, along), sine2)
    _group_outputs(tree, frame | {"Tangent": tangent, "Phase": phase})


def _frame(build: _Builder, inputs: Sockets) -> Sockets:
    surface = build.node("ShaderNodeNewGeometry")
    viewer = surface.outputs["Incoming"]
    colour = build.node("ShaderNodeVectorMath", {"Vector": inputs["Tint"], "Scale": inputs["Strength"]},
                        operation="SCALE").outputs["Vector"]
    normal = build.vector("NORMALIZE", build.connected_or(inputs["Normal"], surface.outputs["Normal"]))
    # a normal that is turned away from the viewer is turned back
    hidden = build.math("SUBTRACT", LEAST_FACING, build.vector("DOT_PRODUCT", normal, viewer, output="Value"))
    normal = build.vector("NORMALIZE",
                          build.vector("MULTIPLY_ADD", viewer, build.math("MAXIMUM", hidden, 0.0), normal))
    cosine = build.vector("DOT_PRODUCT", normal, viewer, output="Value")
    polar = build.math("MULTIPLY", build.math("ARCCOSINE", cosine), 2 / math.pi)
    away = build.vector("SUBTRACT", viewer, normal)
    return {"Colour": colour, "Normal": normal, "Away": away, "Tangent": build.vector("ADD", away, _ANY),
            "Polar": polar}


def add_sum(tree: bpy.types.NodeTree, mixture: NodeMixture, frame: Sockets, x: float, y: float) -> bpy.types.NodeSocket:
    stops = mixture.theta / (math.pi / 2)
    total: bpy.types.NodeSocket | None = None
    for number, kind in enumerate(mixture.kinds):
        build = _Builder(tree, x, y - number * _HEIGHT)
        shape = [each[:, number] for each in mixture.shape]
        total = _lobe(build, kind, stops, mixture.colour[:, number], shape, frame, total)
    assert total is not None        # there is always a diffuse lobe
    return total


def add_walk(tree: bpy.types.NodeTree, walk: Walk, is_cycles: bool, inputs: Sockets, frame: Sockets,
             above: bpy.types.NodeSocket, x: float, y: float) -> bpy.types.NodeSocket:
    """Add to the closures of a surface what comes from below it: a random walk, or EEVEE's approximation."""
    build, normal = _Builder(tree, x, y), frame["Normal"]
    fresnel = build.node("ShaderNodeFresnel", {"IOR": walk.surface, "Normal": normal})
    share = build.math("MULTIPLY", inputs["Strength"], build.math("SUBTRACT", 1.0, fresnel.outputs[0]))
    color, rest = (walk.color, walk.rest) if is_cycles else (walk.albedo, np.zeros(3))
    below = build.node("ShaderNodeSubsurfaceScattering", {
        "Color": build.vector("MULTIPLY", inputs["Tint"], tuple(color.tolist())), "Radius": tuple(walk.radius.tolist()),
        "Scale": build.math("DIVIDE", _MILLIMETRE, inputs["Scale"]), "IOR": walk.entry, "Roughness": 0.0,
        "Anisotropy": 0.0, "Normal": normal}, falloff="RANDOM_WALK").outputs[0]
    if rest.any():                      # what walks do not reach leaves where it entered
        diffuse = build.node("ShaderNodeBsdfDiffuse", {
            "Color": build.vector("MULTIPLY", inputs["Tint"], tuple(rest.tolist())), "Normal": normal})
        below = _add_shaders(build, below, diffuse.outputs[0])
    passed = build.node("ShaderNodeMixShader", {0: share, 2: below})        # weighs it: its colour says how it scatters
    return _add_shaders(build, above, passed.outputs[0])


def _add_shaders(build: _Builder, first: bpy.types.NodeSocket, second: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    return build.node("ShaderNodeAddShader", {0: first, 1: second}).outputs[0]


def _lobe(build: _Builder, kind: Kind, stops: FloatArray, colour: FloatArray, shape: list[RealArray],
          frame: Sockets, below: bpy.types.NodeSocket | None) -> bpy.types.NodeSocket:
    """One closure, from its colour (stops, phases, channels) and shape, 3 times (stops,), added to what is below."""
    seen = _ramp(build, stops, colour[:, 0], frame)
    if "Phase" in frame and colour.shape[1] > 1:
        mix = build.node("ShaderNodeMix", data_type="RGBA")
        factor, first, second = (next(socket for socket in mix.inputs if socket.identifier == name)
                                 for name in ("Factor_Float", "A_Color", "B_Color"))
        build.put(factor, frame["Phase"])
        build.put(first, _ramp(build, stops, colour[:, 1], frame))
        build.put(second, seen)
        seen = next(socket for socket in mix.outputs if socket.identifier == "Result_Color")
    roughness, tilt, anisotropy = shape
    is_tilted, is_long = bool(np.any(tilt != 0)), kind in _DISTRIBUTIONS and bool(np.any(anisotropy != 0))
    shared = ("Colour", "Normal", *["Away"] * is_tilted, *["Tangent"] * is_long)
    given: dict[str, _Value] = {"Seen": seen, **{name: frame[name] for name in shared}}
    if is_tilted or is_long or kind != "diffuse":
        given["Shape"] = float(roughness[0]), float(tilt[0]), float(anisotropy[0])
        if any(np.ptp(values) > 0 for values in shape):
            curves = build.node("ShaderNodeVectorCurve", {"Vector": frame["Polar"]})
            _set_curves(curves, stops, shape)
            given["Shape"] = curves.outputs["Vector"]
    if below is not None:
        given["Below"] = below
    name = " ".join(part for part in (kind, "tilted" * is_tilted, "long" * is_long) if part)
    return build.group(name, partial(_fill_lobe, kind=kind, names=tuple(given)), given).outputs[0]


def _fill_lobe(tree: bpy.types.NodeTree, kind: Kind, names: tuple[str, ...]) -> None:
    types = {"Seen": "Color", "Below": "Shader"}
    inputs = _group_inputs(tree, {name: types.get(name, "Vector") for name in dict.fromkeys((*names, "Below"))})
    build = _Builder(tree, 0, 0)
    normal = inputs["Normal"]
    if "Shape" in inputs:
        parts = list(build.node("ShaderNodeSeparateXYZ", {0: inputs["Shape"]}).outputs)
    if "Away" in inputs:
        normal = build.vector("MULTIPLY_ADD", inputs["Away"], parts[1], normal)
    given: dict[str, _Value] = {"Color": build.vector("MULTIPLY", inputs["Seen"], inputs["Colour"]), "Normal": normal}
    if kind != "diffuse":
        given["Roughness"] = parts[0]
    if "Tangent" in inputs:
        given |= {"Anisotropy": parts[2], "Tangent": inputs["Tangent"]}
    if kind == "diffuse":
        closure = build.node("ShaderNodeBsdfDiffuse", given)
    elif kind == "sheen":
        closure = build.node("ShaderNodeBsdfSheen", given, distribution="ASHIKHMIN")
    else:
        closure = build.node("ShaderNodeBsdfAnisotropic", given, distribution=_DISTRIBUTIONS[kind])
    _group_outputs(tree, {"Sum": _add_shaders(build, inputs["Below"], closure.outputs[0])})


def _group_inputs(tree: bpy.types.NodeTree, types: dict[str, str]) -> Sockets:
    for name, kind in types.items():
        tree.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    node = tree.nodes.new("NodeGroupInput")
    node.location = -_PLACE_WIDTH, 0
    return {name: node.outputs[name] for name in types}


def _group_outputs(tree: bpy.types.NodeTree, outputs: Sockets) -> None:
    node = tree.nodes.new("NodeGroupOutput")
    node.location = 10 * _PLACE_WIDTH, 0
    for name, socket in outputs.items():
        kind = {"VALUE": "Float", "SHADER": "Shader"}.get(socket.type, "Vector")
        tree.interface.new_socket(name, in_out="OUTPUT", socket_type=f"NodeSocket{kind}")
        tree.links.new(socket, node.inputs[name])


def _ramp(build: _Builder, stops: FloatArray, colour: FloatArray, frame: Sockets) -> bpy.types.NodeSocket:
    """A colour, (stops, 1 or 3), by the polar angle of the viewer."""
    node = build.node("ShaderNodeValToRGB", {0: frame["Polar"]})
    elements = node.color_ramp.elements
    elements[0].position, elements[1].position = stops[0], stops[-1]
    for stop in stops[1:-1]:
        elements.new(stop)
    # at once: setting one by one updates the whole tree each time
    elements.foreach_set("color", np.insert(np.broadcast_to(colour, (len(stops), 3)), 3, 1, axis=1).ravel())
    return node.outputs["Color"]


def _set_curves(node: bpy.types.Node, stops: FloatArray, shape: list[RealArray]) -> None:
    """Piecewise linear curves of three values in -1 to 1."""
    mapping = node.mapping
    mapping.extend = "HORIZONTAL"
    for curve, values in zip(mapping.curves, shape, strict=True):
        for number, (stop, value) in enumerate(zip(stops, values, strict=True)):
            if number < 2:
                curve.points[number].location = stop, value
            else:
                curve.points.new(stop, value)
        for point in curve.points:
            point.handle_type = "VECTOR"
    mapping.update()
