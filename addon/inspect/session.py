"""A running inspection in a window: its draw handlers and timer, and what it asks workers for.

Users may undo, delete, close the area or open a file meanwhile: what is kept of Blender's is looked up again.
"""

import traceback
from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ...fitter.arrays import FloatArray
from ...fitter.model import Reflectance, published
from ...fitter.model.mix import Mix
from ..core.annotations import not_none
from ..core.blender.transaction import find_by_session_uid
from ..core.shading import comparison, mixing
from ..core.shading import material as materials
from ..work import queries
from ..work.job import Job
from . import overlay
from .inspection import InspectedSurface, Inspection, Measurements
from .plot import Plot, Rectangle, free_part, place_plot
from .view import View

INTERVAL = 0.1              # s, between two looks at what workers have answered
KEYS = ("Drag: Light    Arrows: By 1\u00b0    R: Cube Root or Linear    P: Plot    Ctrl Click: Another Point    "
        "Esc, Right Mouse: End")

running: "Session | None" = None


class Session:
    """An inspection, and the area that it is drawn in."""

    def __init__(self, inspection: Inspection, area: bpy.types.Area) -> None:
        self.inspection = inspection
        self.area_key = area.as_pointer()       # identifies the area while it is open
        self.failed = ""                        # what went wrong in drawing
        self._waiting = "Reading the fit ..."
        self._near: Any = None              # the answer that the shown samples are of
        self._handlers: list[Any] = []
        self._timer: bpy.types.Timer | None = None

    def begin(self, context: bpy.types.Context) -> None:
        global running
        running = self
        try:
            for draw, when in ((self._draw_view, "POST_VIEW"), (self._draw_pixels, "POST_PIXEL")):
                self._handlers.append(
                    bpy.types.SpaceView3D.draw_handler_add(self._guard(draw), (), "WINDOW", when))
            self._timer = context.window_manager.event_timer_add(INTERVAL, window=context.window)
            if context.workspace is not None:
                context.workspace.status_text_set(KEYS)
            self.refresh()
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """Take away everything that is drawn; it may be called again."""
        global running
        if running is self:
            running = None
        for handler in self._handlers:
            bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
        self._handlers = []
        if self._timer is not None:
            bpy.context.window_manager.event_timer_remove(self._timer)
            self._timer = None
            for workspace in bpy.data.workspaces:
                workspace.status_text_set(None)
        self.redraw()

    def area(self) -> bpy.types.Area | None:
        """The area, if it is open and still a 3D view."""
        for window in bpy.context.window_manager.windows:
            for area in window.screen.areas:
                if area.as_pointer() == self.area_key and area.type == "VIEW_3D":
                    return area
        return None

    def item(self) -> bpy.types.Object | None:
        return find_by_session_uid(bpy.data.objects, self.inspection.spot.item)

    def material(self) -> bpy.types.Material | None:
        """The material, if it is still there and measured."""
        material = find_by_session_uid(bpy.data.materials, self.inspection.spot.material)
        return None if material is None or not materials.is_shown(material) else material

    def redraw(self) -> None:
        area = self.area()
        if area is not None:
            area.tag_redraw()

    def refresh(self) -> None:
        material, inspection = self.material(), self.inspection
        if material is None:
            return
        job = queries.fit_job(material, inspection.spot.masked)
        if job is not None and job.error is not None:
            self._waiting = str(job.error)
        changed = inspection.show(_displayed_fit(material, job, inspection.spot.masked), _pinned_fit(material))
        samples = queries.samples_near_plane(material, inspection.theta_i, inspection.phi_i)
        if samples is not None and samples.finished is not None and samples.result is not self._near:
            changed, self._near = True, samples.result
            name = published.parse_virtual_path(material.measured_brdf.filepath)
            source = "measured" if name is None else "published fit"
            inspection.show_samples(None if samples.result is None else Measurements(*samples.result, source))
        if changed:
            self.redraw()

    def plot(self, area: bpy.types.Area, region: bpy.types.Region) -> Plot:
        others = [_rectangle(each) for each in area.regions
                  if each.type != "WINDOW" and min(each.width, each.height) > 1]
        return place_plot(free_part(_rectangle(region), others), self.inspection.side,
                          bpy.context.preferences.system.ui_scale)

    def frame(self) -> FloatArray | None:
        """The frame of the surface in the world; None without the object."""
        item = self.item()
        return None if item is None else self.inspection.spot.frame(np.array(item.matrix_world))

    def _guard(self, draw: Callable[[bpy.types.Area, bpy.types.Region, FloatArray], None]) -> Callable[[], None]:
        """What Blender calls: nothing raises in it."""
        def run_guarded() -> None:
            area, region = bpy.context.area, bpy.context.region
            if self.failed or area is None or region is None or area.as_pointer() != self.area_key:
                return
            try:
                frame = self.frame()
                if frame is not None and self.material() is not None:
                    draw(area, region, frame)
            except Exception as error:
                traceback.print_exception(error)
                self.failed = f"{type(error).__name__}: {error}"
        return run_guarded

    def _draw_view(self, _area: bpy.types.Area, _region: bpy.types.Region, frame: FloatArray) -> None:
        data = not_none(bpy.context.region_data)
        overlay.draw_lobe(self.inspection, frame, np.array(data.view_matrix)[:3, :3],
                          bpy.context.preferences.system.ui_scale)

    def _draw_pixels(self, area: bpy.types.Area, region: bpy.types.Region, frame: FloatArray) -> None:
        overlay.draw_labels(self.inspection, frame, make_view(region, bpy.context.region_data),
                            bpy.context.preferences.system.ui_scale)
        if self.inspection.with_plot:
            overlay.draw_plot(self.inspection, self.plot(area, region), self._waiting)


def make_view(region: bpy.types.Region, data: Any) -> View:
    """What a region of a 3D view shows, by its `RegionView3D`."""
    return View(np.array(data.perspective_matrix, dtype=float), region.width, region.height)


def stop() -> None:
    if running is not None:
        running.end()


def _displayed_fit(material: bpy.types.Material, job: Job[Reflectance] | None,
                   masked: float | None) -> InspectedSurface | None:
    if job is None or job.result is None:
        return None
    space, node = not_none(queries.shown_fits(material)).colours, materials.mix_node(material)
    note = ""
    if isinstance(job.result, Mix) and mixing.mixes.parts(not_none(node))[2] is None:
        note = "mask: half of each" if masked is None else f"mask here: {masked:.0%}"
    return InspectedSurface(job.result, material.name, space, queries.reaches(material), note)


def _pinned_fit(material: bpy.types.Material) -> InspectedSurface | None:
    other = comparison.find_pinned(not_none(bpy.context.scene), material)
    return None if other is None else _displayed_fit(other, queries.fit_job(other), None)


def _rectangle(region: bpy.types.Region) -> Rectangle:
    return region.x, region.y, region.width, region.height


@persistent
def _on_load(_file: object) -> None:
    stop()


unregister = stop
handlers = {"load_pre": _on_load}
