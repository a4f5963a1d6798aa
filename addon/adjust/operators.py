"""Applies the adjustments of a material to its shader, by itself while the user changes them in a window.

Blender then has two steps to undo: the slider, and what it does. What lies between them is no state to stop at, so that
undo and redo take both.
"""

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty

from ...fitter.library.variations import variation
from ..core.annotations import OperatorResult, not_none
from ..core.blender.active_material import active_material, is_editable
from ..core.blender.transaction import find_by_session_uid
from ..core.shading import compiler
from ..core.shading import material as materials
from ..core.storage import edits
from ..core.storage.outcomes import Surface
from ..work import modal, process, queries, tasks
from ..work.modal import InBackground, Steps
from . import settings as adjustments

_NO_VARIATION = "NONE"
VARIATION_ITEMS = ((_NO_VARIATION, "None", "What the sliders have"),
                   ("SATIN", "Satin", "The highlight twice as wide"),
                   ("AGED", "Aged", "Yellower and darker, with a wider and weaker highlight"),
                   ("LACQUERED", "Lacquered", "A smooth clear coat above"),
                   ("WET", "Wet", "A coat of water; what is porous gets darker"),
                   ("DUSTY", "Dusty", "Two fifths of the surface under dust. Metals get dull, not grey"))
_PAUSE = 0.4                # s without a change, after which adjustments are applied
_AGAIN = 0.1                # s, after which is asked again whether they can be
_changed: dict[int, float] = {}         # session_uid of materials with adjustments to apply, and when they were changed
_applied: set[int] = set()              # session_uid of materials whose adjustments were applied by themselves


class MEASUREDBRDF_OT_adjust(InBackground, bpy.types.Operator):
    """Render this material as it is adjusted. The measurements are not needed"""

    bl_idname = "measured_brdf.adjust"
    bl_label = "Adjust Measured BRDF"
    bl_options = {"REGISTER", "UNDO"}

    reset: BoolProperty(name="Reset", options={"SKIP_SAVE"}, description="Take all adjustments back first")
    variation: EnumProperty(name="Variation", items=VARIATION_ITEMS, default=_NO_VARIATION, options={"SKIP_SAVE"},
                            description="Adjust as this variation of what was measured has it")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: Any) -> str:
        told = next((told for name, _, told in VARIATION_ITEMS[1:] if name == properties.variation), None)
        return not_none(cls.__doc__) if told is None else f"{told}. All sliders below follow"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        target = active_material(context)
        return target is not None and materials.is_measured(target) and is_editable(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """A click moves the sliders, which is what is undone; they are applied as if the user had moved them."""
        if bpy.app.background or not (self.reset or self.variation != _NO_VARIATION):
            return super().invoke(context, event)
        target = not_none(active_material(context))
        try:
            adjustments.move(target, self._chosen(target))
        except Exception as error:
            return self._report_failure(error)
        apply_soon(target)
        return {"FINISHED"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        target = find_by_session_uid(bpy.data.materials, self._target)
        if event.type == "TIMER" and target is not None and adjustments.edit_arguments(target) != self._edit:
            self._end(context)              # the user has undone or changed something meanwhile
            apply_soon(target)
            return {"CANCELLED"}
        return super().modal(context, event)

    def _chosen(self, target: bpy.types.Material) -> dict[str, Any]:
        """The sliders that a variation has, or those of what was measured."""
        if self.variation == _NO_VARIATION:
            return {}
        kept = not_none(queries.embedded_fit(target))
        return adjustments.adjustment_values(variation(self.variation.lower(), tasks.kept_fit(kept)))

    def work(self, context: bpy.types.Context) -> process.Calculation:
        target = not_none(active_material(context))
        self._target = target.session_uid
        _changed.pop(self._target, None)
        self._values = self._chosen(target) if self.reset or self.variation != _NO_VARIATION else None
        self._edit = (adjustments.edit_arguments(target) if self._values is None else
                      adjustments.requested_edit(SimpleNamespace(**self._values)) if self._values else {})
        return process.Calculation(partial(tasks.edit_surface, not_none(queries.embedded_fit(target)), self._edit))

    def prepare(self, surface: Surface) -> Steps:
        yield 0.95, "Compiling"
        return surface, compiler.compile_surface(surface)

    def apply(self, context: bpy.types.Context, prepared: tuple[Surface, compiler.Shader]) -> None:
        target = find_by_session_uid(bpy.data.materials, self._target)
        if target is None or not target.is_editable or not materials.is_measured(target):
            raise ValueError("The material has been removed meanwhile")
        surface, shader = prepared
        materials.edit(target, surface, context, shader)
        if self._values is not None:
            adjustments.move(target, self._values)


def apply_soon(material: bpy.types.Material) -> None:
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
        target = find_by_session_uid(bpy.data.materials, uid)
        windows = not_none(bpy.context.window_manager).windows
        if target is not None and windows and not edits.is_as_wanted(target):
            with bpy.context.temp_override(window=windows[0], material=target):
                if MEASUREDBRDF_OT_adjust.poll(bpy.context):
                    with suppress(RuntimeError):            # the operator has reported what is wrong
                        bpy.ops.measured_brdf.adjust("INVOKE_DEFAULT")
                        _applied.add(uid)
    return _AGAIN if _changed else None


@persistent
def _on_load(*_: object) -> None:
    """A file may have been saved, or a slider undone, before its adjustments were applied."""
    for item in bpy.data.materials:
        if materials.is_measured(item) and not edits.is_as_wanted(item):
            apply_soon(item)


@persistent
def _on_undo(_scene: object, *_: object) -> None:
    _step_once_more(_undo)


@persistent
def _on_redo(_scene: object, *_: object) -> None:
    _step_once_more(_redo)


def _step_once_more(step: Callable[[], None]) -> None:
    """If Blender has stopped between a slider and its effect, take a step: soon, since handlers must not."""
    if not bpy.app.background and _is_between():
        bpy.app.timers.register(step, first_interval=0)


def _is_between() -> bool:
    return any(item.session_uid in _applied and item.session_uid not in _changed and materials.is_measured(item)
               and not edits.is_as_wanted(item) for item in bpy.data.materials)


def _step(name: str) -> None:
    windows = not_none(bpy.context.window_manager).windows
    if windows and modal.running is None and _is_between():
        try:
            with bpy.context.temp_override(window=windows[0]):
                getattr(bpy.ops.ed, name)()
        except RuntimeError:                # there is no step: the click was undone before it had its effect
            _on_load()


_undo, _redo = partial(_step, "undo"), partial(_step, "redo")       # timers
classes = (MEASUREDBRDF_OT_adjust,)
handlers = {"load_post": _on_load, "undo_post": _on_undo, "redo_post": _on_redo}


def unregister() -> None:
    _changed.clear()
    _applied.clear()
    for timer in (_apply, _undo, _redo):
        if bpy.app.timers.is_registered(timer):
            bpy.app.timers.unregister(timer)
