"""Shows pictures of a material large, in an Image Editor.

The image is no part of the file: nothing but editors uses it, and it is not there while the file is saved. Undo removes
it, or brings back an earlier one; the last picture is then shown again.
"""

from functools import partial
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent
from bpy.props import EnumProperty

from ...fitter.arrays import SingleArray
from ...fitter.drawing import BACKGROUND
from ...fitter.pictures import split
from ..annotations import OperatorResult, present
from ..jobs import comparisons, process, queries
from ..jobs.job import Work
from ..jobs.modal import InBackground, errors_reported
from ..materials import comparison
from .active_material import active_material
from .compare import LARGE, Look, has_measured

NAME = "Measured BRDF View"
_MARK = "measured_brdf_view"         # custom property of the image
_DRAWN = 768                            # pixels on a side, where nothing is rendered
SPHERE, SPLIT, POLAR, LOOK = "SPHERE", "SPLIT", "POLAR", "LOOK"
KINDS = ((SPHERE, "Sphere", "The lit sphere of the material"),
         (SPLIT, "Split Sphere", "A sphere of this material and of the pinned one"),
         (POLAR, "Polar Plot", "The plane of incidence, with the pinned material if there is one"),
         (LOOK, "Render", "A render by Cycles, with the pinned material if there is one"))
_shown: tuple[SingleArray, list[int]] | None = None     # the last picture, and the areas that show it, by `as_pointer`


class MEASUREDBRDF_OT_large_view(InBackground, bpy.types.Operator):
    """Show a picture of this material large, in a window with an Image Editor. Nothing changes in this file"""

    bl_idname = "measured_brdf.large_view"
    bl_label = "Large View of Measured Material"
    bl_options = {"REGISTER"}
    bl_property = "kind"

    kind: EnumProperty(name="Picture", items=KINDS, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_measured(cls, context)

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: "MEASUREDBRDF_OT_large_view") -> str:
        return next((f"{text}, large" for kind, _, text in KINDS if kind == properties.kind), "")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        if not self.properties.is_property_set("kind"):         # from the search of operators
            context.window_manager.invoke_search_popup(self)
            return {"FINISHED"}
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        if bpy.app.background or not self.options.is_invoke:
            return self.run(context)
        # a kind was chosen in the search: start anew as a modal operator, so that the window stays responsive
        with errors_reported(self):
            bpy.ops.measured_brdf.large_view("INVOKE_DEFAULT", kind=self.kind)
        return {"FINISHED"}

    def work(self, context: bpy.types.Context) -> Work:
        scene, target = present(context.scene), present(active_material(context))
        other = comparison.pinned(scene, target)
        chosen = comparison.of(scene)
        self._at = float(chosen.divide)
        self._flipped, self._look = bool(chosen.flipped), None
        mine = present(queries.kept(target))
        pinned = None if other is None else present(queries.kept(other))
        if self.kind == SPHERE:
            return process.Calculation(partial(comparisons.sphere, mine, _DRAWN))
        if self.kind == LOOK:
            self._look = Look(scene, [target] if other is None else [target, other], LARGE)
            return self._look.work
        if self.kind == POLAR:
            return process.Calculation(partial(comparisons.polar, mine, pinned, chosen.theta, _DRAWN))
        if pinned is None:
            raise ValueError("No other material is pinned: choose one under Compare With")
        pair = (pinned, mine) if self._flipped else (mine, pinned)
        return process.Calculation(partial(comparisons.split_sphere, *pair, self._at, _DRAWN))

    def apply(self, _context: bpy.types.Context, result: Any) -> None:
        picture = result
        if self._look is not None:
            rendered = self._look.store()
            picture, other = rendered[0], rendered[-1]
            if len(rendered) > 1:
                picture = split(*((other, picture) if self._flipped else (picture, other)), self._at)
        show(picture)


def show(picture: SingleArray) -> None:
    """Show a picture, (size, size, 4), in the Image Editor that showed the last one, or else in a new window.

    In scripts no window opens.
    """
    global _shown
    image, areas = _image(picture), _areas()
    if bpy.app.background:
        return
    _shown = picture, [area.as_pointer() for area in areas]
    for area in areas:
        area.spaces.active.image = image
        area.tag_redraw()
    if not areas:
        # not now: the operator that is running belongs to another window
        bpy.app.timers.register(_open_window, first_interval=0)


def _open_window() -> None:
    """Show the last picture in a window of its own."""
    global _shown
    manager, image = present(bpy.context.window_manager), _ours()
    if _shown is None or image is None:         # undone meanwhile
        return
    with bpy.context.temp_override(window=manager.windows[0]):
        bpy.ops.wm.window_new()
    area = manager.windows[-1].screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image
    _shown = _shown[0], [area.as_pointer()]


def _image(picture: SingleArray) -> bpy.types.Image:
    """The image, with a picture over a plain background."""
    height, width = picture.shape[:2]
    image = _ours()
    if image is None or tuple(image.size) != (width, height):
        new = bpy.data.images.new(NAME, width, height, alpha=False)
        new[_MARK] = True
        if image is not None:
            image.user_remap(new)
            bpy.data.images.remove(image)
            new.name = NAME
        image = new
    cover = picture[..., 3:]
    opaque = np.ones_like(picture)
    opaque[..., :3] = picture[..., :3] * cover + np.array(BACKGROUND, dtype=np.float32) * (1 - cover)
    present(image.pixels).foreach_set(opaque.ravel())
    image.update()
    image.pack()                # or Blender would ask on quitting whether to save it
    return image


def _ours() -> bpy.types.Image | None:
    """The image of this module: one that has its mark, and that users have not taken for themselves."""
    return next((image for image in bpy.data.images if image.get(_MARK) is not None and _is_ours(image)), None)


def _is_ours(image: bpy.types.Image) -> bool:
    """Whether nothing but editors uses an image: else it has become part of the file."""
    return not image.use_fake_user and all(isinstance(user, bpy.types.Screen)
                                           for user in bpy.data.user_map(subset=[image])[image])


def _areas() -> list[bpy.types.Area]:
    """The Image Editors that show the last picture."""
    known = [] if _shown is None else _shown[1]
    return [area for window in bpy.context.window_manager.windows for area in window.screen.areas
            if area.as_pointer() in known and area.type == "IMAGE_EDITOR"]


def _take_from_editors() -> bpy.types.Image | None:
    """Take the image from all editors, so that it is not saved: the image, if it was there and is ours."""
    image = _ours()
    if image is None:
        return None
    for screen in bpy.data.screens:
        for area in screen.areas:
            for space in area.spaces:
                if space.type == "IMAGE_EDITOR" and space.image == image:
                    space.image = None
    return image


@persistent
def _on_save_pre(*_: object) -> None:
    image = _take_from_editors()
    if image is not None:
        bpy.data.images.remove(image)


@persistent
def _show_again(*_: object) -> None:
    global _shown
    if _shown is None:
        return
    if not _areas():
        _shown = None           # the window has been closed
        return
    image = _image(_shown[0])
    for area in _areas():
        area.spaces.active.image = image


@persistent
def _on_load(*_: object) -> None:
    global _shown
    _shown = None


_HANDLERS = {"save_pre": _on_save_pre, "save_post": _show_again, "save_post_fail": _show_again,
             "undo_post": _show_again, "redo_post": _show_again, "load_pre": _on_load}

classes = (MEASUREDBRDF_OT_large_view,)


def register() -> None:
    for name, handler in _HANDLERS.items():
        getattr(bpy.app.handlers, name).append(handler)


def unregister() -> None:
    for name, handler in _HANDLERS.items():
        if handler in getattr(bpy.app.handlers, name):
            getattr(bpy.app.handlers, name).remove(handler)
    _on_load()
