"""The operator that shows the lobe of a material at a spot of a surface, and lets the light be dragged."""

from contextlib import suppress

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...fitter.arrays import FloatArray
from ..core.annotations import OperatorResult, not_none
from ..core.blender.targets import region_under_mouse
from ..core.shading import material as materials
from . import session, surface
from .inspection import Inspection
from .plot import Plot
from .session import Session, make_view
from .view import View

_SIZE = 0.19                # longest radius of the lobe, over the smaller side of the region
_LARGEST = 0.5              # bound of that radius, over the longest side of the object
_PLACES = (("MOUSE", "Under the Mouse", "The surface under the mouse or, where there is none, in the middle of the "
                                        "object as it is seen"),
           ("CURSOR", "At the 3D Cursor", "The surface nearest to the 3D cursor"))


class MEASUREDBRDF_OT_inspect(bpy.types.Operator):
    """Show how much the material reflects into each direction, as a lobe on the surface and as a plot, while you drag
    the light. Click again, or press Esc, to end"""

    bl_idname = "measured_brdf.inspect"
    bl_label = "Inspect Reflectance"

    place: EnumProperty(name="Place", items=_PLACES, default="MOUSE", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        item = context.object
        material = item.active_material if item is not None else None
        if material is None or not materials.is_shown(material):
            cls.poll_message_set("The active object has no measured material")
            return False
        return True

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        self.report({"ERROR"}, "Inspect Reflectance draws in a 3D viewport of Blender's window; scripts call it with "
                               "'INVOKE_DEFAULT', and without a window it cannot be shown")
        return {"CANCELLED"}

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if bpy.app.background or context.window is None:
            return self.execute(context)
        if session.running is not None:
            session.stop()
            return {"FINISHED"}
        area = _area(context)
        if area is None:
            self.report({"ERROR"}, "No 3D viewport is open in this window to show the lobe in")
            return {"CANCELLED"}
        region = region_under_mouse(area, event) or next(each for each in area.regions if each.type == "WINDOW")
        spot, why = None, ""
        try:
            spot = self._first_spot(context, region, event)
        except RuntimeError as error:           # Blender has no evaluated mesh, for example in Edit Mode
            why = f": {error}"
        if spot is None:
            self.report({"ERROR"}, f"{not_none(context.object).name} has no surface to inspect{why}")
            return {"CANCELLED"}
        self._begin(context, area, region, spot)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if session.running is not self._session:
            return {"CANCELLED"}
        area, frame = self._session.area(), self._session.frame()
        if area is None or frame is None or self._session.material() is None or self._session.failed:
            if self._session.failed:
                self.report({"ERROR"}, f"{self._session.failed}. The console has the details")
            self._session.end()
            return {"CANCELLED"}
        try:
            return self._handle(context, event, area, frame)
        except BaseException:
            self._session.end()
            raise

    def cancel(self, _context: bpy.types.Context) -> None:
        """Blender calls this when it ends the operator, for example because another file is opened."""
        self._session.end()

    def _first_spot(self, context: bpy.types.Context, region: bpy.types.Region,
                    event: bpy.types.Event) -> surface.Spot | None:
        item, depsgraph = not_none(context.object), context.evaluated_depsgraph_get()
        view = make_view(region, region.data)
        if self.place == "CURSOR":
            point = np.array(not_none(context.scene).cursor.location)
            return surface.nearest(item, depsgraph, point, view.direction_to_viewer(point))
        origin = np.array(item.matrix_world.translation)
        middle = (np.array(item.matrix_world) @ np.append(np.mean(np.array(item.bound_box), axis=0), 1))[:3]
        for at in (_mouse(region, event), view.project(middle), view.project(origin)):
            if np.isfinite(at).all() and (spot := surface.find_spot(item, depsgraph, *view.ray(at))) is not None:
                return spot
        return surface.nearest(item, depsgraph, middle, view.direction_to_viewer(middle))

    def _begin(self, context: bpy.types.Context, area: bpy.types.Area, region: bpy.types.Region,
               spot: surface.Spot) -> None:
        view = make_view(region, region.data)
        item = not_none(context.object)
        place = spot.frame(np.array(item.matrix_world))[:3, 3]
        at = view.project(place)
        size = min(_SIZE * min(region.width, region.height) * view.pixel(place), _LARGEST * max(item.dimensions[:]))
        settings = not_none(context.object.active_material).measured_brdf
        inspection = Inspection(spot, size or 1.0, settings.shown_theta, settings.shown_phi,
                                "LEFT" if at[0] > region.width / 2 else "RIGHT")
        self._session = Session(inspection, area)
        self._session.begin(context)

    def _handle(self, context: bpy.types.Context, event: bpy.types.Event, area: bpy.types.Area,
                frame: FloatArray) -> OperatorResult:
        inspection, pressed = self._session.inspection, event.value == "PRESS"
        if event.type == "TIMER":
            self._session.refresh()
            return {"PASS_THROUGH"}
        if event.type == "LEFTMOUSE" and event.value == "RELEASE" and inspection.drag:
            inspection.release()
            self._session.redraw()
            return {"RUNNING_MODAL"}
        region = region_under_mouse(area, event)
        if pressed and (event.type == "ESC" or (event.type == "RIGHTMOUSE" and region is not None)):
            self._session.end()
            return {"FINISHED"}
        if region is None and not inspection.drag:
            if inspection.mouse is not None:        # the mouse has left: nothing is under it
                inspection.mouse = None
                self._session.redraw()
            return {"PASS_THROUGH"}
        if region is None:              # a drag goes on beside the view
            region = max((each for each in area.regions if each.type == "WINDOW"), key=lambda each: each.width)
        view, at, plot = make_view(region, region.data), _mouse(region, event), self._session.plot(area, region)
        taken = self._use(context, event, view, frame, at, plot, pressed)
        if taken or event.type == "MOUSEMOVE":
            self._session.redraw()
        return {"RUNNING_MODAL"} if taken else {"PASS_THROUGH"}

    def _use(self, context: bpy.types.Context, event: bpy.types.Event, view: View, frame: FloatArray, at: FloatArray,
             plot: Plot, pressed: bool) -> bool:
        """Give an event in the view to the inspection: whether that took it."""
        inspection = self._session.inspection
        plain = not (event.ctrl or event.alt or event.shift or event.oskey)
        if event.type == "MOUSEMOVE":
            inspection.move(view, frame, plot, at)
            return bool(inspection.drag)
        if event.type == "LEFTMOUSE" and pressed and plain:
            return inspection.press(view, frame, plot, at)
        if event.type == "LEFTMOUSE" and pressed and event.ctrl:
            spot = None
            with suppress(RuntimeError):        # Blender has no evaluated mesh
                spot = surface.find_spot(not_none(self._session.item()), context.evaluated_depsgraph_get(),
                                         *view.ray(at))
            if spot is not None:
                inspection.spot = spot
                self._session.refresh()
            return spot is not None
        return pressed and plain and inspection.key(event.type)


def _area(context: bpy.types.Context) -> bpy.types.Area | None:
    """The 3D view that the operator was called in, else the largest of the window."""
    if context.area is not None and context.area.type == "VIEW_3D":
        return context.area
    views = [area for area in context.window.screen.areas if area.type == "VIEW_3D"]
    return max(views, key=lambda area: area.width * area.height, default=None)


def _mouse(region: bpy.types.Region, event: bpy.types.Event) -> FloatArray:
    """Where the mouse is in a region, pixels."""
    return np.array([event.mouse_x - region.x, event.mouse_y - region.y], dtype=float)


classes = (MEASUREDBRDF_OT_inspect,)
