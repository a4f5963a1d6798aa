"""Photographs of a flat sample become a plane of its size: a mix of measured materials by masks, with a normal map."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import bpy
import numpy as np

from ...fitter.arrays import FloatArray
from ..core.annotations import not_none
from ..core.blender.transaction import find_by_session_uid
from ..core.shading import compiler, material, mixing
from ..core.storage.outcomes import EmbeddedFit
from ..core.storage.reading import load_arguments
from ..work import process, queries
from ..work.job import Work
from ..work.modal import Steps
from . import describing, stage
from . import work as measuring
from .operators import HasPhotographs, blender_light, compile_outcomes, create_materials, default_fit
from .settings import CHOSEN


class MEASUREDBRDF_OT_measure_sample(HasPhotographs, bpy.types.Operator):
    """Measure the materials, masks and normals of the flat sample in the photographs, and make its material of them"""

    bl_idname = "measured_brdf.measure_sample"
    bl_label = "Measure"

    def work(self, context: bpy.types.Context) -> Work:
        settings = self.remember(context)
        chosen = [each for each in (getattr(settings, name) for name in CHOSEN) if each is not None]
        self._uids = [each.session_uid for each in chosen]
        return process.Calculation(partial(
            measuring.measure_sample, describing.describe_scene(settings), settings.tile,
            [_embedded_fit(each) for each in chosen], load_arguments(default_fit(""))))

    def prepare(self, result: measuring.SampleResult) -> Steps:
        return result, (yield from compile_outcomes(result.outcomes))

    def apply(self, context: bpy.types.Context,
              prepared: tuple[measuring.SampleResult, list[compiler.Shader]]) -> None:
        (maps, shaders), settings = prepared, self.settings()
        told, doubts = (measuring.translate_keys("\n".join(each)) for each in (maps.told, maps.doubts))
        chosen = [find_by_session_uid(bpy.data.materials, uid) for uid in self._uids]
        if None in chosen:
            raise ValueError("A material that was chosen has been removed meanwhile")
        parts = [*map(not_none, chosen), *create_materials(maps.outcomes, shaders, context)]
        mixes = _mix_parts(parts, maps, context)
        plane, pose, lights = settings.sample.data, stage.camera_pose(maps.view), _lights(settings, maps)
        coordinates = stage.uv_of_part(plane, maps.part)
        layer = plane.uv_layers.active or plane.uv_layers.new(name="UVMap")
        # no call may follow that can fail: this is not taken back
        settings.sample.active_material = mixes[-1]
        layer.data.foreach_set("uv", coordinates)
        plane.update()
        for part in (*parts, *mixes):
            part.use_fake_user = part.use_fake_user or part.library is None
        settings.camera.matrix_basis = pose
        for lamp, light, energy, colour in lights:
            lamp.data, light.energy, light.color = light, energy, colour
        settings.told, settings.doubts = told, doubts
        for line in doubts.splitlines():
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"{mixes[-1].name}: a mix of {', '.join(each.name for each in parts)}")


def _embedded_fit(chosen: bpy.types.Material) -> EmbeddedFit:
    fit = queries.embedded_fit(chosen)
    if fit is None:
        raise ValueError(f"{chosen.name!r} is not a measured material of this file, or it is a mix")
    return fit._replace(name=chosen.name)


def _lights(settings: Any, maps: measuring.SampleResult) -> list[tuple[Any, Any, float, FloatArray]]:
    """The lamps, their lights, and how bright these were found to be; one that was left out is as the median of the
    others, beside which it is as bright as its photograph says."""
    shots = {bpy.path.basename(each.files[0].filepath): each for each in settings.photographs if each.lamp is not None}
    usual = np.median([each / shots[name].brightness for name, each in maps.intensities.items()], axis=0)
    found = {name: maps.intensities.get(name, usual * shot.brightness) for name, shot in shots.items()}
    do_differ = any((each != usual).any() for each in found.values())
    return [(shot.lamp, shot.lamp.data.copy() if do_differ and shot.lamp.data.users > 1 else shot.lamp.data,
             *blender_light(found[name])) for name, shot in shots.items()]


def _mix_parts(parts: Sequence[bpy.types.Material], maps: measuring.SampleResult,
               context: bpy.types.Context) -> list[bpy.types.Material]:
    """Materials that lay each part upon those before it: the last is the sample's."""
    mixes, beyond = [parts[0]], "REPEAT" if maps.is_tile else "EXTEND"
    for number, (part, (content, share)) in enumerate(zip(parts[1:], maps.masks, strict=True), start=2):
        mask = _image(f"{maps.name} mask {number}", content)
        mixes.append(mixing.mixes.mix(mixes[-1], part, share, mask, context))
        for node in not_none(mixes[-1].node_tree).nodes:
            if node.type == "TEX_IMAGE":
                node.extension = beyond
    made = mixes[-1] if len(parts) > 1 else parts[0].copy()
    made.name = maps.name
    node, tree = not_none(material.surface_node(made)), not_none(made.node_tree)
    for y, kind, name, content, target in ((-300, "ShaderNodeMath", "brightness", maps.brightness, "Strength"),
                                           (-600, "ShaderNodeNormalMap", "normals", maps.normals, "Normal")):
        texture, between = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new(kind)
        texture.image, texture.extension = _image(f"{maps.name} {name}", content), beyond
        texture.location, between.location = ((node.location.x - x, node.location.y + y) for x in (480, 180))
        if kind == "ShaderNodeMath":
            between.operation, between.inputs[1].default_value = "MULTIPLY", maps.most
        tree.links.new(texture.outputs["Color"], between.inputs["Color" if kind == "ShaderNodeNormalMap" else 0])
        tree.links.new(between.outputs[0], node.inputs[target])
    return [*mixes[1:], *([made] if len(parts) == 1 else [])]


def _image(name: str, content: bytes) -> bpy.types.Image:
    image = bpy.data.images.new(name, 1, 1, is_data=True)
    image.pack(data=content, data_len=len(content))
    image.source = "FILE"
    return image


classes = MEASUREDBRDF_OT_measure_sample,
