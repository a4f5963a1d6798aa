"""Pins the material that others are compared with, and renders materials to look at them."""

from itertools import count
from pathlib import Path
from typing import Any

import bpy

from ...fitter.arrays import SingleArray
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material
from ..core.shading import comparison, look
from ..panel.layout import has_measured
from ..work import process
from ..work.blender_process import Command
from ..work.job import Work
from ..work.modal import InBackground
from ..work.recent import Recent

SIZE, _SAMPLES = 256, 64    # of renders: pixels on a side, and samples per pixel

RenderKey = tuple[int, str, str]
"""What is rendered: the `session_uid` of the material, and one of `look.SHAPES` and `look.LIGHTINGS`."""
renders: Recent[RenderKey, tuple[SingleArray, int]] = Recent(12)
"""Test renders of this session, each as the material was when it was rendered, until it is rendered again: a picture,
(size, size, 4), and its number, by which it is told from earlier ones."""
_numbers = count()


def render_key(scene: bpy.types.Scene, material: bpy.types.Material) -> RenderKey:
    """What a render of a material shows with the present choices of a scene."""
    chosen = comparison.get(scene)
    return material.session_uid, chosen.shape or look.BALL, chosen.lighting or look.STUDIO  # empty where damaged


class MEASUREDBRDF_OT_pin(bpy.types.Operator):
    """Compare other measured materials with this one"""

    bl_idname = "measured_brdf.pin"
    bl_label = "Pin Measured Material"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.scene is None or not context.scene.is_editable:
            cls.poll_message_set("The scene belongs to another file")
            return False
        return has_measured(cls, context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        target = not_none(active_material(context))
        comparison.get(not_none(context.scene)).pinned = target
        self.report({"INFO"}, f"Choose another material to compare it with {target.name}")
        return {"FINISHED"}


def _write(folder: Path, scene: bpy.types.Scene, wanted: list[bpy.types.Material], shape: str, lighting: str) -> None:
    worlds = [scene.world] if lighting == look.WORLD else []
    if None in worlds:
        raise ValueError("The scene has no world: choose another light")
    # copies, because a file does not hold what it links
    copies: list[Any] = []
    try:
        for each in (*wanted, *worlds):
            copies.append(not_none(each).copy())
        names, view = [copy.name for copy in copies], scene.view_settings
        bpy.data.libraries.write(str(folder / look.MATERIALS_FILE), set(copies), path_remap="ABSOLUTE", fake_user=True)
        look.write_request(folder, look.Request(
            names[:len(wanted)], "".join(names[len(wanted):]), shape, lighting, SIZE, _SAMPLES,
            view.view_transform, view.exposure))
    finally:
        bpy.data.batch_remove(copies)


class MEASUREDBRDF_OT_render_look(InBackground, bpy.types.Operator):
    """Render this material with Cycles, on the chosen shape in the chosen light, and the pinned material beside it. \
Nothing changes in this file"""

    bl_idname = "measured_brdf.render_look"
    bl_label = "Render Measured Material"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_measured(cls, context)

    def work(self, context: bpy.types.Context) -> Work:
        scene, target = not_none(context.scene), not_none(active_material(context))
        other = comparison.find_pinned(scene, target)
        wanted = [target] if other is None else [target, other]
        self._keys, self._folder = [render_key(scene, each) for each in wanted], process.temporary()
        _write(Path(self._folder.name), scene, wanted, *self._keys[0][1:])
        return Command("look", self._folder.name)

    def apply(self, _context: bpy.types.Context, _result: Any) -> None:
        pictures = look.pictures(Path(self._folder.name), len(self._keys))
        for key, picture in zip(self._keys, pictures, strict=True):
            renders[key] = picture, next(_numbers)
        self._folder.cleanup()


classes = (MEASUREDBRDF_OT_pin, MEASUREDBRDF_OT_render_look)


def unregister() -> None:
    """Forget all renders."""
    renders.clear()
