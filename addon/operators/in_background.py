"""Operators that work in another process while the window stays alive, with a progress bar, and Esc to cancel."""

import time

import bpy

from ...fitter import DatasetError
from .. import background, node_group, osl_support
from ..work import silent

EXPECTED = (DatasetError, node_group.CompileError, ValueError)

running = None              # what the panel shows progress of


class InBackground:
    """A mix-in for operators: the whole is one undo step, and cancelling it changes nothing.

    An operator defines ``work(context)``, which returns what `background.Job` takes, or None where there is nothing
    to be done in another process; and ``apply(context, result)``, a generator of (fraction, doing) that does the rest
    here, piece by piece. Where it is closed early it takes back what it has done.
    """

    def run(self, context):
        """All of it at once, for scripts: what `execute` returns."""
        try:
            work = self._checked(context)
            for _ in self.apply(context, work and work(silent)):
                time.sleep(0.01)        # for processes that some of them wait for
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def start(self, context):
        """Begin, and go on in `modal`: what `invoke` returns."""
        global running
        if bpy.app.background:
            return self.execute(context)
        if running is not None:
            self.report({"ERROR"}, "Another fit is under way: wait for it, or cancel it with Esc")
            return {"CANCELLED"}
        try:
            work = self._checked(context)
        except EXPECTED as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._begin(work)
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if (event.type == "ESC" and event.value == "PRESS") or running is not self._job:
            self._end(context)
            self.report({"INFO"}, "Cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            done = self._step(context)
        except EXPECTED as error:
            self._end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except BaseException:
            self._end(context)
            raise
        if done:
            self._end(context)
            return {"FINISHED"}
        if context.workspace is not None:
            context.workspace.status_text_set(f"{self._job.doing}    {self._job.fraction:.0%}    Esc: Cancel")
        background.redraw()
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Blender ends the operator, as it does when another file is opened."""
        self._end(context)

    def _checked(self, context):
        """The work, unless it would be for nothing."""
        if osl_support.missing():
            raise node_group.CompileError(osl_support.missing())
        return self.work(context)

    def _begin(self, work):
        global running
        self._applying = None
        self._job = running = background.start(work) if work is not None else background.finished()

    def _step(self, context):
        """Whether all is done, after having done the next piece."""
        if not self._job.poll():
            return False
        if self._job.error is not None:
            raise self._job.error
        if self._applying is None:
            self._applying = self.apply(context, self._job.result)
        step = next(self._applying, None)
        if step is not None:
            self._job.fraction, self._job.doing = step
        return step is None

    def _end(self, context):
        global running
        running = None
        self._job.cancel()
        if self._applying is not None:
            self._applying.close()
        context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        background.redraw()


class MEASUREDBRDF_OT_cancel(bpy.types.Operator):
    """Stop fitting and leave everything as it was, as Esc does"""

    bl_idname = "measured_brdf.cancel"
    bl_label = "Cancel Fitting"

    def execute(self, _context):
        global running
        running = None                  # which the operator that runs takes notice of
        return {"FINISHED"}


classes = (MEASUREDBRDF_OT_cancel,)
