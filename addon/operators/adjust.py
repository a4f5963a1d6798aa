"""Applies the adjustments of a material to its shader, by itself while the user changes them in a window."""

import time
from contextlib import suppress
from functools import partial

import bpy
from bpy.props import BoolProperty

from ..annotations import OperatorResult, present
from ..jobs import modal, process, queries, tasks
from ..jobs.modal import InBackground, Steps
from ..materials import adjustments, compiler
from ..materials import material as materials
from ..materials.properties import is_as_adjusted
from ..transaction import by_session_uid
from .active_material import active_material, is_editable

_PAUSE = 0.4                # s without a change, after which adjustments are applied
_AGAIN = 0.1                # s, after which is asked again whether they can be
_changed: dict[int, float] = {}         # session_uid of materials with adjustments to apply, and when they were changed


class MEASUREDBRDF_OT_adjust(InBackground, bpy.types.Operator):
    """Render this material as it is adjusted. The measurements are not needed"""

    bl_idname = "measured_brdf.adjust"
    bl_label = "Adjust Measured BRDF"
    bl_options = {"REGISTER", "UNDO"}

    reset: BoolProperty(name="Reset", options={"SKIP_SAVE"}, description="Take all adjustments back first")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and materials.is_measured(target) and is_editable(cls, context)

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        return self.run(context)

    def work(self, context: bpy.types.Context) -> process.Calculation:
        target = present(active_material(context))
        self._target = target.session_uid
        _changed.pop(self._target, None)
        edit = {} if self.reset else adjustments.edit_arguments(target.measured_brdf)
        return process.Calculation(partial(tasks.adjusted, present(queries.kept(target)), edit))

    def prepare(self, adjusted: tasks.Adjusted) -> Steps:
        yield 0.95, "Compiling"
        return adjusted, compiler.compile_shader(adjusted.source, adjusted.nodes)

    def apply(self, context: bpy.types.Context, prepared: tuple[tasks.Adjusted, compiler.Shader]) -> None:
        target = by_session_uid(bpy.data.materials, self._target)
        if target is None or not target.is_editable or not materials.is_measured(target):
            raise ValueError("The material has been removed meanwhile")
        adjusted, shader = prepared
        if not self.reset and adjustments.edit_arguments(target.measured_brdf) != adjusted.edit:
            _apply_soon(target)             # the user has undone or changed something meanwhile
        materials.adjust(target, adjusted, context, shader)
        if self.reset:
            adjustments.reset(target.measured_brdf)


def _apply_soon(material: bpy.types.Material) -> None:
    """Apply adjustments once the user has stopped changing them; scripts call the operator."""
    if bpy.app.background or not materials.is_measured(material) or not material.is_editable:
        return
    _changed[material.session_uid] = time.monotonic()
    if not bpy.app.timers.is_registered(_apply):
        bpy.app.timers.register(_apply, first_interval=_PAUSE)


def _apply() -> float | None:
    """A timer, which runs until nothing is left to apply."""
    now = time.monotonic()
    for uid, when in [*_changed.items()]:
        if now - when < _PAUSE or modal.running is not None:
            continue
        del _changed[uid]
        target = by_session_uid(bpy.data.materials, uid)
        windows = present(bpy.context.window_manager).windows
        if target is not None and windows and not is_as_adjusted(target.measured_brdf):
            with bpy.context.temp_override(window=windows[0], material=target):
                if MEASUREDBRDF_OT_adjust.poll(bpy.context):
                    with suppress(RuntimeError):            # the operator has reported what is wrong
                        bpy.ops.measured_brdf.adjust("INVOKE_DEFAULT")
    return _AGAIN if _changed else None


classes = (MEASUREDBRDF_OT_adjust,)


def register() -> None:
    adjustments.listeners.append(_apply_soon)


def unregister() -> None:
    adjustments.listeners.remove(_apply_soon)
    _changed.clear()
    if bpy.app.timers.is_registered(_apply):
        bpy.app.timers.unregister(_apply)
