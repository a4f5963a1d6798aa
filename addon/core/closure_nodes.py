"""A sum of Blender's closure nodes (`fitter.cycles.node_mixture`) in a node group."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import bpy
import numpy as np

from ...fitter.shader_constants import LEAST_FACING

if TYPE_CHECKING:
    from ...fitter.arrays import FloatArray
    from ...fitter.cycles.node_lobes import Kind
    from ...fitter.cycles.node_mixture import NodeMixture

_DISTRIBUTIONS: dict[Kind, str] = {"GGX": "GGX", "Beckmann": "BECKMANN"}
_UNCONNECTED = 0.5          # a normal or tangent that is shorter is an unconnected input
_ANY = (1.3e-5, 0.7e-5, 1.1e-5)     # added to tangents, so that none is without direction
_WIDTH, _HEIGHT = 200, 260          # of a place in the node editor


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
        self.x += _WIDTH
        return node

    def put(self, socket: bpy.types.NodeSocket, value: _Value) -> None:
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif isinstance(value, tuple) or socket.type != "VECTOR":
            socket.default_value = value
        else:
            socket.default_value = (value, value, value)

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
    """Add the nodes that all lobes share.

    Parameters
    ----------
    tree : bpy.types.NodeTree
    inputs : Inputs
    turn : float, or None
        As `NodeMixture` has it.
    x, y : float
        Where the nodes are drawn.
    """
    build = _Builder(tree, x, y)
    surface = build.node("ShaderNodeNewGeometry")
    viewer = surface.outputs["Incoming"]
    colour = build.scaled(inputs.tint, inputs.strength)
    normal = build.vector("NORMALIZE", build.given(inputs.normal, surface.outputs["Normal"]))
    # a normal that is turned away from the viewer is turned back
    hidden = build.math("SUBTRACT", LEAST_FACING, build.vector("DOT_PRODUCT", normal, viewer, output="Value"))
    normal = build.vector("NORMALIZE",
                          build.vector("MULTIPLY_ADD", viewer, build.math("MAXIMUM", hidden, 0.0), normal))
    cosine = build.vector("DOT_PRODUCT", normal, viewer, output="Value")
    polar = build.math("MULTIPLY", build.math("ARCCOSINE", cosine), 2 / math.pi)
    away = build.vector("SUBTRACT", viewer, normal)
    if turn is None or inputs.tangent is None or inputs.rotation is None:
        return Frame(colour, normal, away, build.vector("ADD", away, _ANY), polar, None)
    build = _Builder(tree, x, y - _HEIGHT)
    across = build.vector("NORMALIZE", build.vector(
        "CROSS_PRODUCT", normal, build.vector("ADD", build.given(inputs.tangent, surface.outputs["Tangent"]), _ANY)))
    turned = build.node("ShaderNodeVectorRotate", rotation_type="AXIS_ANGLE")
    build.put(turned.inputs["Vector"], build.vector("CROSS_PRODUCT", across, normal))
    build.put(turned.inputs["Axis"], normal)
    build.put(turned.inputs["Angle"], build.math("MULTIPLY_ADD", inputs.rotation, 2 * math.pi, turn))
    tangent = turned.outputs[0]
    along = build.vector("DOT_PRODUCT", viewer, tangent, output="Value")
    sine2 = build.math("SUBTRACT", 1.0 + 1e-6, build.math("MULTIPLY", cosine, cosine))
    phase = build.math("DIVIDE", build.math("MULTIPLY", along, along), sine2)
    return Frame(colour, normal, away, tangent, polar, phase)


def add_sum(tree: bpy.types.NodeTree, mixture: NodeMixture, frame: Frame, x: float, y: float) -> bpy.types.NodeSocket:
    """Add a sum of closures, and return its output."""
    stops = mixture.theta / (math.pi / 2)
    total: bpy.types.NodeSocket | None = None
    for number, kind in enumerate(mixture.kinds):
        build = _Builder(tree, x, y - number * _HEIGHT)
        shape = [each[:, number] for each in mixture.shape]
        lobe = _lobe(build, kind, stops, mixture.colour[:, number], shape, frame)
        if total is None:
            total = lobe
            continue
        both = build.node("ShaderNodeAddShader")
        build.put(both.inputs[0], total)
        build.put(both.inputs[1], lobe)
        total = both.outputs[0]
    assert total is not None        # there is always a diffuse lobe
    return total


def _lobe(build: _Builder, kind: Kind, stops: FloatArray, colour: FloatArray, shape: list[FloatArray],
          frame: Frame) -> bpy.types.NodeSocket:
    """One closure, from its colour (stops, phases, channels) and shape, 3 times (stops,)."""
    seen = _ramp(build, stops, colour[:, 0], frame)
    if frame.phase is not None and colour.shape[1] > 1:
        mix = build.node("ShaderNodeMix", data_type="RGBA")
        factor, first, second = (next(socket for socket in mix.inputs if socket.identifier == name)
                                 for name in ("Factor_Float", "A_Color", "B_Color"))
        build.put(factor, frame.phase)
        build.put(first, _ramp(build, stops, colour[:, 1], frame))
        build.put(second, seen)
        seen = next(socket for socket in mix.outputs if socket.identifier == "Result_Color")
    seen = build.vector("MULTIPLY", seen, frame.colour)
    roughness, tilt, anisotropy = shape
    normal = frame.normal
    parts: tuple[_Value, ...] = float(roughness[0]), 0.0, 0.0
    if any(np.ptp(values) > 0 for values in shape):
        curves = build.node("ShaderNodeVectorCurve")
        _set_curves(curves, stops, shape)
        build.put(curves.inputs["Vector"], frame.polar)
        separate = build.node("ShaderNodeSeparateXYZ")
        build.put(separate.inputs[0], curves.outputs["Vector"])
        parts = tuple(separate.outputs)
    if np.any(tilt != 0):
        normal = build.vector("MULTIPLY_ADD", frame.away, parts[1], frame.normal)
    if kind == "diffuse":
        closure = build.node("ShaderNodeBsdfDiffuse")
    elif kind == "sheen":
        closure = build.node("ShaderNodeBsdfSheen", distribution="ASHIKHMIN")
        build.put(closure.inputs["Roughness"], parts[0])
    else:
        closure = build.node("ShaderNodeBsdfAnisotropic", distribution=_DISTRIBUTIONS[kind])
        build.put(closure.inputs["Roughness"], parts[0])
        if np.any(anisotropy != 0):
            build.put(closure.inputs["Anisotropy"], parts[2])
            build.put(closure.inputs["Tangent"], frame.tangent)
    build.put(closure.inputs["Color"], seen)
    build.put(closure.inputs["Normal"], normal)
    return closure.outputs[0]


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


def _set_curves(node: bpy.types.Node, stops: FloatArray, shape: list[FloatArray]) -> None:
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
