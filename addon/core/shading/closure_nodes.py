"""A sum of Blender's closure nodes (`fitter.cycles.node_mixture`) in a node group, of groups that all materials share.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ....fitter.shader_constants import LEAST_FACING
from ..blender.shared_groups import shared_group

if TYPE_CHECKING:
    from ....fitter.arrays import FloatArray, RealArray
    from ....fitter.cycles.node_lobes import Kind
    from ....fitter.cycles.node_mixture import NodeMixture
    from ....fitter.optics.subsurface import Walk

_DISTRIBUTIONS: dict[Kind, str] = {"GGX": "GGX", "Beckmann": "BECKMANN"}
_UNCONNECTED = 0.5          # a normal or tangent that is shorter is an unconnected input
_ANY = (1.3e-5, 0.7e-5, 1.1e-5)     # added to tangents, so that none is without direction
_MILLIMETRE = 1e-3          # m
_PLACE_WIDTH, _HEIGHT = 200, 260    # of a place in the node editor


class Inputs(NamedTuple):
    """The sockets that a sum of closures depends on; None for what a fit does not have."""

    tint: bpy.types.NodeSocket
    strength: bpy.types.NodeSocket
    normal: bpy.types.NodeSocket
    tangent: bpy.types.NodeSocket | None
    rotation: bpy.types.NodeSocket | None


class Frame(NamedTuple):
    """What the lobes of all sums of a group share: sockets, each with a value for a shading point.

    Attributes
    ----------
    colour
        By which the colours of lobes are multiplied.
    normal
        The shading normal, a unit vector that the viewer sees.
    away
        From the tip of the normal to that of the direction of the viewer.
    tangent
        Of microfacet lobes.
    polar
        The polar angle of the viewer, as a share of a right angle.
    phase : bpy.types.NodeSocket, or None
        The squared cosine of the viewer's azimuth from the first principal axis; None where a fit is isotropic.
    """

    colour: bpy.types.NodeSocket
    normal: bpy.types.NodeSocket
    away: bpy.types.NodeSocket
    tangent: bpy.types.NodeSocket
    polar: bpy.types.NodeSocket
    phase: bpy.types.NodeSocket | None


_Value = bpy.types.NodeSocket | float | tuple[float, float, float]


class _Builder:
    """Adds nodes to a tree, each at the next place of a row."""

    def __init__(self, tree: bpy.types.NodeTree, x: float, y: float) -> None:
        self.tree, self.x, self.y = tree, x, y

    def node(self, kind: str, **settings: str | bool) -> bpy.types.Node:
        node = self.tree.nodes.new(kind)
        for name, value in settings.items():
            setattr(node, name, value)
        node.location = self.x, self.y
        node.hide = kind in {"ShaderNodeMath", "ShaderNodeVectorMath", "ShaderNodeSeparateXYZ"}
        self.x += _PLACE_WIDTH
        return node

    def put(self, socket: bpy.types.NodeSocket, value: _Value) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif isinstance(value, tuple) or socket.type != "VECTOR":
            socket.default_value = value
        else:
            socket.default_value = (value, value, value)

    def group(self, kind: str, fill: Callable[[bpy.types.NodeTree], None], given: dict[str, _Value]) -> bpy.types.Node:
        """A node of the group that is shared under a name, with values or links by the names of its inputs."""
        node = self.node("ShaderNodeGroup")
        node.node_tree = shared_group(kind, fill)
        for name, value in given.items():
            self.put(node.inputs[name], value)
        return node

    def math(self, operation: str, *values: _Value) -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeMath", operation=operation)
        for socket, value in zip(node.inputs, values, strict=False):
            self.put(socket, value)
        return node.outputs[0]

    def vector(self, operation: str, *values: _Value, output: str = "Vector") -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeVectorMath", operation=operation)
        for socket, value in zip(node.inputs, values, strict=False):
            self.put(socket, value)
        return node.outputs[output]

    def scaled(self, vector: _Value, scale: _Value) -> bpy.types.NodeSocket:
        node = self.node("ShaderNodeVectorMath", operation="SCALE")
        self.put(node.inputs[0], vector)
        self.put(node.inputs["Scale"], scale)
        return node.outputs["Vector"]

    def given(self, socket: bpy.types.NodeSocket, default: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
        """A vector, or another where it is an unconnected input, which is 0."""
        missing = self.math("LESS_THAN", self.vector("LENGTH", socket, output="Value"), _UNCONNECTED)
        return self.vector("MULTIPLY_ADD", default, missing, socket)


def add_frame(tree: bpy.types.NodeTree, inputs: Inputs, turn: float | None, x: float, y: float) -> Frame:
    """Add the node of the group that all lobes share, at a place of the node editor; `turn` is as `NodeMixture` has it.
    """
    build = _Builder(tree, x, y)
    given: dict[str, _Value] = {"Tint": inputs.tint, "Strength": inputs.strength, "Normal": inputs.normal}
    if turn is None or inputs.tangent is None or inputs.rotation is None:
        node = build.group("Frame", _fill_frame, given)
        return _frame_outputs(node)
    node = build.group("Turned Frame", _fill_turned_frame,
                       given | {"Tangent": inputs.tangent, "Rotation": inputs.rotation, "Turn": turn})
    return _frame_outputs(node)


def _frame_outputs(node: bpy.types.Node) -> Frame:
    out = node.outputs
    return Frame(out["Colour"], out["Normal"], out["Away"], out["Tangent"], out["Polar"], out.get("Phase"))


def _fill_frame(tree: bpy.types.NodeTree) -> None:
    inputs = _group_inputs(tree, {"Tint": "Color", "Strength": "Float", "Normal": "Vector"})
    _group_outputs(tree, _frame(_Builder(tree, 0, 0), inputs)._asdict())


def _fill_turned_frame(tree: bpy.types.NodeTree) -> None:
    inputs = _group_inputs(tree, {"Tint": "Color", "Strength": "Float", "Normal": "Vector", "Tangent": "Vector",
                                  "Rotation": "Float", "Turn": "Float"})
    frame = _frame(_Builder(tree, 0, 0), inputs)
    build = _Builder(tree, 0, -_HEIGHT)
    surface = build.node("ShaderNodeNewGeometry")
    viewer = surface.outputs["Incoming"]
    across = build.vector("NORMALIZE", build.vector(
        "CROSS_PRODUCT", frame.normal, build.vector("ADD", build.given(inputs["Tangent"], surface.outputs["Tangent"]),
                                                    _ANY)))
    turned = build.node("ShaderNodeVectorRotate", rotation_type="AXIS_ANGLE")
    build.put(turned.inputs["Vector"], build.vector("CROSS_PRODUCT", across, frame.normal))
    build.put(turned.inputs["Axis"], frame.normal)
    build.put(turned.inputs["Angle"], build.math("MULTIPLY_ADD", inputs["Rotation"], 2 * math.pi, inputs["Turn"]))
    tangent = turned.outputs[0]
    along = build.vector("DOT_PRODUCT", viewer, tangent, output="Value")
    cosine = build.vector("DOT_PRODUCT", frame.normal, viewer, output="Value")
    sine2 = build.math("SUBTRACT", 1.0 + 1e-6, build.math("MULTIPLY", cosine, cosine))
    phase = build.math("DIVIDE", build.math("MULTIPLY", along, along), sine2)
    _group_outputs(tree, frame._replace(tangent=tangent, phase=phase)._asdict())


def _frame(build: _Builder, inputs: dict[str, bpy.types.NodeSocket]) -> Frame:
    """The frame of an isotropic fit."""
    surface = build.node("ShaderNodeNewGeometry")
    viewer = surface.outputs["Incoming"]
    colour = build.scaled(inputs["Tint"], inputs["Strength"])
    normal = build.vector("NORMALIZE", build.given(inputs["Normal"], surface.outputs["Normal"]))
    # a normal that is turned away from the viewer is turned back
    hidden = build.math("SUBTRACT", LEAST_FACING, build.vector("DOT_PRODUCT", normal, viewer, output="Value"))
    normal = build.vector("NORMALIZE",
                          build.vector("MULTIPLY_ADD", viewer, build.math("MAXIMUM", hidden, 0.0), normal))
    cosine = build.vector("DOT_PRODUCT", normal, viewer, output="Value")
    polar = build.math("MULTIPLY", build.math("ARCCOSINE", cosine), 2 / math.pi)
    away = build.vector("SUBTRACT", viewer, normal)
    return Frame(colour, normal, away, build.vector("ADD", away, _ANY), polar, None)


def add_sum(tree: bpy.types.NodeTree, mixture: NodeMixture, frame: Frame, x: float, y: float) -> bpy.types.NodeSocket:
    """Add a sum of closures, and return its output."""
    stops = mixture.theta / (math.pi / 2)
    total: bpy.types.NodeSocket | None = None
    for number, kind in enumerate(mixture.kinds):
        build = _Builder(tree, x, y - number * _HEIGHT)
        shape = [each[:, number] for each in mixture.shape]
        total = _lobe(build, kind, stops, mixture.colour[:, number], shape, frame, total)
    assert total is not None        # there is always a diffuse lobe
    return total


def add_walk(tree: bpy.types.NodeTree, walk: Walk, is_cycles: bool, scale: bpy.types.NodeSocket, inputs: Inputs,
             frame: Frame, above: bpy.types.NodeSocket, x: float, y: float) -> bpy.types.NodeSocket:
    """Add to the closures of a surface what comes from below it, and return the sum: a random walk in Cycles, EEVEE's
    approximation there. `scale` is in metres per unit of the scene."""
    build = _Builder(tree, x, y)
    fresnel = build.node("ShaderNodeFresnel")
    build.put(fresnel.inputs["IOR"], walk.surface)
    build.put(fresnel.inputs["Normal"], frame.normal)
    share = build.math("MULTIPLY", inputs.strength, build.math("SUBTRACT", 1.0, fresnel.outputs[0]))
    color, rest = (walk.color, walk.rest) if is_cycles else (walk.albedo, np.zeros(3))
    closure = build.node("ShaderNodeSubsurfaceScattering", falloff="RANDOM_WALK")
    given: dict[str, _Value] = {
        "Color": build.vector("MULTIPLY", inputs.tint, _vector(color)), "Radius": _vector(walk.radius),
        "Scale": build.math("DIVIDE", _MILLIMETRE, scale), "IOR": walk.entry, "Roughness": 0.0, "Anisotropy": 0.0,
        "Normal": frame.normal}
    for name, value in given.items():
        build.put(closure.inputs[name], value)
    below = closure.outputs[0]
    if rest.any():                      # what walks do not reach leaves where it entered
        diffuse = build.node("ShaderNodeBsdfDiffuse")
        build.put(diffuse.inputs["Color"], build.vector("MULTIPLY", inputs.tint, _vector(rest)))
        build.put(diffuse.inputs["Normal"], frame.normal)
        below = _add_shaders(build, below, diffuse.outputs[0])
    passed = build.node("ShaderNodeMixShader")          # weighs it: its colour says how it scatters
    build.put(passed.inputs[0], share)
    build.put(passed.inputs[2], below)
    return _add_shaders(build, above, passed.outputs[0])


def _vector(numbers: FloatArray) -> tuple[float, float, float]:
    first, second, third = numbers.tolist()
    return first, second, third


def _add_shaders(build: _Builder, first: bpy.types.NodeSocket, second: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    both = build.node("ShaderNodeAddShader")
    build.put(both.inputs[0], first)
    build.put(both.inputs[1], second)
    return both.outputs[0]


def _lobe(build: _Builder, kind: Kind, stops: FloatArray, colour: FloatArray, shape: list[RealArray],
          frame: Frame, below: bpy.types.NodeSocket | None) -> bpy.types.NodeSocket:
    """One closure, from its colour (stops, phases, channels) and shape, 3 times (stops,), added to what is below."""
    seen = _ramp(build, stops, colour[:, 0], frame)
    if frame.phase is not None and colour.shape[1] > 1:
        mix = build.node("ShaderNodeMix", data_type="RGBA")
        factor, first, second = (next(socket for socket in mix.inputs if socket.identifier == name)
                                 for name in ("Factor_Float", "A_Color", "B_Color"))
        build.put(factor, frame.phase)
        build.put(first, _ramp(build, stops, colour[:, 1], frame))
        build.put(second, seen)
        seen = next(socket for socket in mix.outputs if socket.identifier == "Result_Color")
    roughness, tilt, anisotropy = shape
    is_tilted, is_long = bool(np.any(tilt != 0)), kind in _DISTRIBUTIONS and bool(np.any(anisotropy != 0))
    given: dict[str, _Value] = {"Seen": seen, "Colour": frame.colour, "Normal": frame.normal}
    if is_tilted:
        given["Away"] = frame.away
    if is_long:
        given["Tangent"] = frame.tangent
    if is_tilted or is_long or kind != "diffuse":
        given["Shape"] = float(roughness[0]), float(tilt[0]), float(anisotropy[0])
        if any(np.ptp(values) > 0 for values in shape):
            curves = build.node("ShaderNodeVectorCurve")
            _set_curves(curves, stops, shape)
            build.put(curves.inputs["Vector"], frame.polar)
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
    parts: list[bpy.types.NodeSocket] = []
    if "Shape" in inputs:
        separate = build.node("ShaderNodeSeparateXYZ")
        build.put(separate.inputs[0], inputs["Shape"])
        parts = list(separate.outputs)
    if "Away" in inputs:
        normal = build.vector("MULTIPLY_ADD", inputs["Away"], parts[1], normal)
    seen = build.vector("MULTIPLY", inputs["Seen"], inputs["Colour"])
    if kind == "diffuse":
        closure = build.node("ShaderNodeBsdfDiffuse")
    elif kind == "sheen":
        closure = build.node("ShaderNodeBsdfSheen", distribution="ASHIKHMIN")
    else:
        closure = build.node("ShaderNodeBsdfAnisotropic", distribution=_DISTRIBUTIONS[kind])
        if "Tangent" in inputs:
            build.put(closure.inputs["Anisotropy"], parts[2])
            build.put(closure.inputs["Tangent"], inputs["Tangent"])
    if kind != "diffuse":
        build.put(closure.inputs["Roughness"], parts[0])
    build.put(closure.inputs["Color"], seen)
    build.put(closure.inputs["Normal"], normal)
    _group_outputs(tree, {"sum": _add_shaders(build, inputs["Below"], closure.outputs[0])})


def _group_inputs(tree: bpy.types.NodeTree, types: dict[str, str]) -> dict[str, bpy.types.NodeSocket]:
    """Give a new group inputs of these names and types: their sockets in it."""
    for name, kind in types.items():
        tree.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    node = tree.nodes.new("NodeGroupInput")
    node.location = -_PLACE_WIDTH, 0
    return {name: node.outputs[name] for name in types}


def _group_outputs(tree: bpy.types.NodeTree, outputs: dict[str, bpy.types.NodeSocket | None]) -> None:
    """Give a new group these outputs, as far as there are any."""
    node = tree.nodes.new("NodeGroupOutput")
    node.location = 10 * _PLACE_WIDTH, 0
    for name, socket in outputs.items():
        if socket is not None:
            kind = {"VALUE": "Float", "SHADER": "Shader"}.get(socket.type, "Vector")
            tree.interface.new_socket(name.capitalize(), in_out="OUTPUT", socket_type=f"NodeSocket{kind}")
            tree.links.new(socket, node.inputs[name.capitalize()])


def _ramp(build: _Builder, stops: FloatArray, colour: FloatArray, frame: Frame) -> bpy.types.NodeSocket:
    """A colour, (stops, 1 or 3), by the polar angle of the viewer."""
    node = build.node("ShaderNodeValToRGB")
    elements = node.color_ramp.elements
    elements[0].position, elements[1].position = stops[0], stops[-1]
    for stop in stops[1:-1]:
        elements.new(stop)
    # at once: setting one by one updates the whole tree each time
    elements.foreach_set("color", np.insert(np.broadcast_to(colour, (len(stops), 3)), 3, 1, axis=1).ravel())
    build.put(node.inputs[0], frame.polar)
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
