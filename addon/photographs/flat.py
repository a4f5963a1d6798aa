"""Photographs of a flat sample become a plane of its size: a mix of measured materials by masks, with a normal map."""

from collections.abc import Generator, Sequence
from functools import partial
from typing import Any

import bpy
import numpy as np
from bpy.props import BoolProperty, StringProperty

from ...fitter.photographs.capture_setup import CameraSetup
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
from ..work.modal import AsksForPath, InBackground, Steps
from . import settings as photographs
from . import stage
from . import work as measuring
from .operators import HasPhotographs, light_of
from .settings import CHOSEN

_PRESET = "Standard"        # of materials that are measured


def _chosen(number: int) -> Any:
    return StringProperty(name=f"Material {number}", options={"SKIP_SAVE"}, description=(
        "A measured material of this file that the sample is a mix of. Where none is chosen, those that the "
        "description names, and where it names none, those that are found in the photographs"))


class _MakesMix(InBackground):
    """A mix-in for operators whose result is the mix of materials that a flat sample is."""

    def choose(self, chosen: Sequence[bpy.types.Material | None], names: Sequence[str]) -> list[EmbeddedFit]:
        """The fits of chosen materials, which are remembered. ValueError where one has none."""
        kept: list[EmbeddedFit] = []
        for name, each in zip(names, chosen, strict=True):
            fit = None if each is None else queries.embedded_fit(each)
            if fit is None:
                raise ValueError(f"{name!r} is not a measured material of this file, or it is a mix")
            kept.append(fit._replace(name=name))
        self._uids: list[int] = [not_none(each).session_uid for each in chosen]
        return kept

    def compiled(self, maps: measuring.Maps) -> Generator[tuple[float, str], None, list[compiler.Shader]]:
        """The shaders of the materials that were measured, in steps."""
        shaders = []
        for each in maps.outcomes:
            yield 0.95, f"Compiling {each.measured.name}"
            shaders.append(compiler.compile_surface(each.surface))
        return shaders

    def mixed(self, context: bpy.types.Context, maps: measuring.Maps, shaders: Sequence[compiler.Shader],
              beyond: str) -> tuple[list[bpy.types.Material], list[bpy.types.Material]]:
        """The materials and the mixes that are made of them, of which the last is the sample's."""
        parts = [by_session_uid(bpy.data.materials, uid) for uid in self._uids]
        if None in parts:
            raise ValueError("A material that was chosen has been removed meanwhile")
        for outcome, shader in zip(maps.outcomes, shaders, strict=True):
            choices = default_choices(outcome.measured.path)
            use_preset(choices, _PRESET)
            parts.append(material.create(outcome, choices, context, shader))
        return [not_none(each) for each in parts], _mixed([not_none(each) for each in parts], maps, beyond, context)


def _arguments() -> tuple[Any, Any]:
    """Those of fits, and of reading."""
    choices = default_choices("")
    use_preset(choices, _PRESET)
    return fit_arguments(choices), load_arguments(choices)


class MEASUREDBRDF_OT_measure_flat(AsksForPath, _MakesMix, bpy.types.Operator):
    """Make a plane of photographs of a flat sample, described in a file (.toml): a mix of measured materials, with \
masks and a normal map"""

    bl_idname = "measured_brdf.measure_flat"
    bl_label = "Flat Sample at Once"
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
        for name in CHOSEN:
            layout.prop_search(self, name, bpy.data, "materials")
        layout.prop_search(self, "mask", bpy.data, "masks")
        layout.prop(self, "tile")

    def work(self, context: bpy.types.Context) -> Work:
        osl_support.make_importable("OpenImageIO")
        names = [name for name in (getattr(self, each) for each in CHOSEN) if name]
        kept = self.choose([bpy.data.materials.get(name) for name in names], names)
        corners = None
        if self.mask:
            drawn = bpy.data.masks.get(self.mask)
            if drawn is None:
                raise ValueError(f"Corners: {self.mask!r} is not a mask of one spline with four points")
            corners = stage.drawn_corners(drawn)
        return process.Calculation(partial(measuring.flat, bpy.path.abspath(self.filepath), corners, self.tile, kept,
                                           *_arguments()))

    def prepare(self, result: measuring.Maps) -> Steps:
        return result, (yield from self.compiled(result))

    def apply(self, context: bpy.types.Context, prepared: tuple[measuring.Maps, list[compiler.Shader]]) -> None:
        maps, shaders = prepared
        parts, mixes = self.mixed(context, maps, shaders, "REPEAT" if self.tile else "EXTEND")
        item = bpy.data.objects.new(maps.name, stage.plane(maps.name, maps.size, mixes[-1]))
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


class MEASUREDBRDF_OT_measure_sample(_MakesMix, HasPhotographs, bpy.types.Operator):
    """Measure the materials, masks and normals of the flat sample in the photographs, and make its material of them"""

    bl_idname = "measured_brdf.measure_sample"
    bl_label = "Measure"
    bl_options = {"REGISTER", "UNDO"}

    def work(self, context: bpy.types.Context) -> Work:
        scene = self.remember(context)
        settings = photographs.get(scene)
        chosen = [each for each in (getattr(settings, name) for name in CHOSEN) if each is not None]
        return process.Calculation(partial(
            measuring.flat_of_scene, stage.description_of(scene), scene.name,
            self.choose(chosen, [each.name for each in chosen]), *_arguments()))

    def prepare(self, result: tuple[measuring.Maps, CameraSetup]) -> Steps:
        return *result, (yield from self.compiled(result[0]))

    def apply(self, context: bpy.types.Context,
              prepared: tuple[measuring.Maps, CameraSetup, list[compiler.Shader]]) -> None:
        (maps, camera, shaders), scene = prepared, self.scene()
        settings = photographs.get(scene)
        parts, mixes = self.mixed(context, maps, shaders, "EXTEND")
        # no call may follow that can fail: this is not taken back
        for part in (*parts, *mixes):
            part.use_fake_user = part.use_fake_user or part.library is None
        settings.sample.data.materials[0] = mixes[-1]
        stage.place_camera(settings.camera, camera, (0, 0, 0))
        _set_lights(settings, maps)
        settings.told, settings.doubts = "\n".join(maps.told), "\n".join(maps.doubts)
        for line in maps.doubts:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"{mixes[-1].name}: a mix of {', '.join(each.name for each in parts)}")


def _set_lights(settings: Any, maps: measuring.Maps) -> None:
    """Make the lamps as bright as they were found to be; one that was left out is as the median of the others."""
    usual = np.median([*maps.intensities.values()], axis=0)
    do_differ = any((each != usual).any() for each in maps.intensities.values())
    for shot in settings.photographs:
        if shot.lamp is None:
            continue
        if do_differ and shot.lamp.data.users > 1:
            shot.lamp.data = shot.lamp.data.copy()
        name = bpy.path.basename(shot.files[0].filepath)
        shot.lamp.data.energy, shot.lamp.data.color = light_of(maps.intensities.get(name, usual))


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


classes = (MEASUREDBRDF_OT_measure_flat, MEASUREDBRDF_OT_measure_sample)
