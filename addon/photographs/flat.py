"""Photographs of a flat sample become a plane of its size: a mix of measured materials by masks, with a normal map."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, StringProperty

from ...fitter.arrays import FloatArray
from ..core import lamps
from ..core.annotations import not_none
from ..core.blender import osl_support
from ..core.blender.transaction import by_session_uid
from ..core.shading import compiler, material, mixing
from ..core.storage.outcomes import EmbeddedFit
from ..core.storage.properties import default_choices, fit_arguments, use_preset
from ..core.storage.reading import load_arguments
from ..work import process, queries
from ..work.job import Work
from ..work.modal import AsksForPath, Steps
from . import work as measuring

_CHOSEN = "first", "second", "third", "fourth"
_PRESET = "Standard"        # of materials that are measured


def _chosen(number: int) -> Any:
    return StringProperty(name=f"Material {number}", options={"SKIP_SAVE"}, description=(
        "A measured material of this file that the sample is a mix of. Where none is chosen, those that the "
        "description names, and where it names none, those that are found in the photographs"))


class MEASUREDBRDF_OT_measure_flat(AsksForPath, bpy.types.Operator):
    """Make a plane of photographs of a flat sample, described in a file (.toml): a mix of measured materials, with \
masks and a normal map"""

    bl_idname = "measured_brdf.measure_flat"
    bl_label = "Measure Flat Sample"
    bl_options = {"REGISTER", "UNDO"}

    path_name = "filepath"
    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})
    first: _chosen(1)
    second: _chosen(2)
    third: _chosen(3)
    fourth: _chosen(4)
    mask: StringProperty(name="Corners", options={"SKIP_SAVE"}, description=(
        "A mask of four points, drawn upon one of the photographs in the Image Editor: the sample's corners. Without "
        "one they are those of the description"))
    tile: BoolProperty(name="Tile", options={"SKIP_SAVE"}, description=(
        "Cut a part out of the sample that can be repeated, along the least visible seam"))

    def draw(self, _context: bpy.types.Context) -> None:
        layout = not_none(self.layout)
        layout.use_property_split = True
        for name in _CHOSEN:
            layout.prop_search(self, name, bpy.data, "materials")
        layout.prop_search(self, "mask", bpy.data, "masks")
        layout.prop(self, "tile")

    def work(self, context: bpy.types.Context) -> Work:
        osl_support.make_importable("OpenImageIO")
        names = [name for name in (getattr(self, each) for each in _CHOSEN) if name]
        chosen = [bpy.data.materials.get(name) for name in names]
        kept: list[EmbeddedFit] = []
        for name, each in zip(names, chosen, strict=True):
            fit = None if each is None else queries.embedded_fit(each)
            if fit is None:
                raise ValueError(f"{name!r} is not a measured material of this file, or it is a mix")
            kept.append(fit._replace(name=name))
        self._uids: list[int] = [not_none(each).session_uid for each in chosen]
        choices = default_choices("")
        use_preset(choices, _PRESET)
        corners = _mask_corners(self.mask) if self.mask else None
        return process.Calculation(partial(measuring.flat, bpy.path.abspath(self.filepath), corners, self.tile, kept,
                                           fit_arguments(choices), load_arguments(choices)))

    def prepare(self, result: measuring.Maps) -> Steps:
        shaders = []
        for each in result.outcomes:
            yield 0.95, f"Compiling {each.measured.name}"
            shaders.append(compiler.compile_surface(each.surface))
        return result, shaders

    def apply(self, context: bpy.types.Context, prepared: tuple[measuring.Maps, list[compiler.Shader]]) -> None:
        maps, shaders = prepared
        parts = [by_session_uid(bpy.data.materials, uid) for uid in self._uids]
        if None in parts:
            raise ValueError("A material that was chosen has been removed meanwhile")
        for outcome, shader in zip(maps.outcomes, shaders, strict=True):
            choices = default_choices(outcome.measured.path)
            use_preset(choices, _PRESET)
            parts.append(material.create(outcome, choices, context, shader))
        mixes = _mixed([not_none(each) for each in parts], maps, "REPEAT" if self.tile else "EXTEND", context)
        item = bpy.data.objects.new(maps.name, _plane(maps, mixes[-1]))
        not_none(context.collection).objects.link(item)
        item.location = not_none(context.scene).cursor.location
        lamps.update(context.evaluated_depsgraph_get())
        # no call may follow that can fail: this is not taken back
        for part in (*parts, *mixes):
            part.use_fake_user = part.use_fake_user or part.library is None
        for each in not_none(context.view_layer).objects:
            each.select_set(each == item)
        not_none(context.view_layer).objects.active = item
        for line in (*maps.told, f"{item.name}: a mix of {', '.join(each.name for each in parts)}"):
            self.report({"WARNING"} if line in maps.doubts else {"INFO"}, line)


def _mask_corners(name: str) -> FloatArray:
    """The four points of a mask, (4, 2): as `flat_setup.flat` takes them."""
    mask: Any = bpy.data.masks.get(name)
    splines = [] if mask is None else [spline for layer in mask.layers for spline in layer.splines]
    if [len(each.points) for each in splines] != [4]:
        raise ValueError(f"Corners: {name!r} is not a mask of one spline with four points")
    return np.array([tuple(point.co) for point in splines[0].points]) - 0.5


def _mixed(parts: Sequence[bpy.types.Material], maps: measuring.Maps, beyond: str,
           context: bpy.types.Context) -> list[bpy.types.Material]:
    """Materials that lay each part upon those before it: the last is the sample's. `beyond` is what images are beyond
    their edges."""
    mixes = [parts[0]]
    for number, (part, (content, share)) in enumerate(zip(parts[1:], maps.masks, strict=True), start=2):
        mask = _image(f"{maps.name} mask {number}", content)
        mixes.append(mixing.mixes.mix(mixes[-1], part, share, mask, context))
        for node in not_none(mixes[-1].node_tree).nodes:
            if node.type == "TEX_IMAGE":
                node.extension = beyond
    made = mixes[-1] if len(parts) > 1 else parts[0].copy()
    made.name = maps.name
    node, tree = not_none(material.surface_node(made)), not_none(made.node_tree)
    brightness, normals = (
        _texture(tree, node, y, _image(f"{maps.name} {name}", content), beyond) for y, name, content in (
            (-300, "brightness", maps.brightness), (-600, "normals", maps.normals)))
    strength, normal = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeNormalMap")
    strength.operation, strength.inputs[1].default_value = "MULTIPLY", maps.most
    strength.location, normal.location = ((node.location.x - 180, node.location.y + y) for y in (-300, -600))
    for source, target in ((brightness.outputs["Color"], strength.inputs[0]),
                           (strength.outputs[0], node.inputs["Strength"]),
                           (normals.outputs["Color"], normal.inputs["Color"]),
                           (normal.outputs["Normal"], node.inputs["Normal"])):
        tree.links.new(source, target)
    return [*mixes[1:], *([made] if len(parts) == 1 else [])]


def _texture(tree: bpy.types.NodeTree, node: bpy.types.Node, y: float, image: bpy.types.Image,
             beyond: str) -> bpy.types.Node:
    """A node of an image, left of another one, with what is beyond its edges."""
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.extension = image, beyond
    texture.location = node.location.x - 480, node.location.y + y
    return texture


def _image(name: str, content: bytes) -> bpy.types.Image:
    """An image of numbers that is packed into the file."""
    image = bpy.data.images.new(name, 1, 1, is_data=True)
    image.pack(data=content, data_len=len(content))
    image.source = "FILE"
    return image


def _plane(maps: measuring.Maps, surface: bpy.types.Material) -> bpy.types.Mesh:
    """A mesh of the sample's size with a UV map, about its middle."""
    x, y = (each / 2 for each in maps.size)
    mesh = bpy.data.meshes.new(maps.name)
    mesh.from_pydata([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    mesh.materials.append(surface)
    return mesh


classes = (MEASUREDBRDF_OT_measure_flat,)
