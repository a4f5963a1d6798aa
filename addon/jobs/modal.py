"""Operators that work in another process while the window stays alive, with a progress bar, and Esc to cancel.

While they wait, users may undo, open a file, or delete anything. So nothing of `bpy` is held from one tick of the timer
to the next: what an operator is about is remembered by its `session_uid`, looked up again in the one step in which the
results are applied.
"""

import traceback

import bpy
from bpy.app.handlers import persistent

from ...fitter import DatasetError
from .. import transaction
from ..materials import compiler, osl_support
from . import blender_process, process, queue

EXPECTED = (DatasetError, compiler.CompileError, process.WorkerError, blender_process.CommandError, ValueError,
            OSError)

running = None              # what the panel shows progress of


class InBackground:
    """A mix-in for operators: the whole is one undo step; one that fails or is cancelled changes nothing.

    An operator defines

    - ``work(context)``: what is to be done in another process, `process.Calculation` or `blender_process.Command`;
    - ``prepare(result)``: optional, a generator of (fraction, doing) that goes on here, piece by piece, without data of
      Blender's, and returns what `apply` takes;
    - ``apply(context, prepared)``: does the rest, in one step.
    """

    needs_osl = True                # False for what compiles nothing

    def run(self, context):
        """All of it at once, for scripts: what `execute` returns."""
        try:
            self._steps = self.prepare(self._checked(context).run())
            while self._go_on() is not None:
                pass
            self._apply(context)
        except Exception as error:
            return self._failed(error)
        return {"FINISHED"}

    def start(self, context):
        """Begin, and go on in `modal`: what `invoke` returns."""
        if bpy.app.background:
            return self.execute(context)
        if running is not None:
            self.report({"ERROR"}, "Another fit is under way: wait for it, or cancel it with Esc")
            return {"CANCELLED"}
        try:
            self._begin(self._checked(context))
        except Exception as error:
            return self._failed(error)
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
        except Exception as error:
            self._end(context)
            return self._failed(error)
        except BaseException:
            self._end(context)
            raise
        if done:
            self._end(context)
            return {"FINISHED"}
        if context.workspace is not None:
            context.workspace.status_text_set(f"{self._job.doing}    {self._job.fraction:.0%}    Esc: Cancel")
        queue.redraw()
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Blender ends the operator, as it does when another file is opened."""
        self._end(context)

    def prepare(self, result):
        """By default there is nothing to prepare."""
        return result
        yield

    def _checked(self, context):
        """The work, unless it would be for nothing."""
        if self.needs_osl and osl_support.missing():
            raise compiler.CompileError(osl_support.missing())
        return self.work(context)

    def _begin(self, work):
        global running
        self._steps = None
        self._job = running = work.start()

    def _step(self, context):
        """Whether all is done, after having done the next piece."""
        if not self._job.poll():
            return False
        if self._job.error is not None:
            raise self._job.error
        if self._steps is None:
            self._steps = self.prepare(self._job.result)
        progress = self._go_on()
        if progress is None:
            self._apply(context)
            return True
        self._job.fraction, self._job.doing = progress
        return False

    def _go_on(self):
        """Prepare the next piece: (fraction, doing), or None once all is prepared."""
        try:
            return next(self._steps)
        except StopIteration as end:
            self._prepared = end.value
            return None

    def _apply(self, context):
        with transaction.new_data_removed_on_error():
            self.apply(context, self._prepared)

    def _failed(self, error):
        """Report an error: what `execute` or `modal` returns. What nobody expected is traced on the console too."""
        if isinstance(error, EXPECTED):
            self.report({"ERROR"}, str(error))
        else:
            traceback.print_exception(error)
            self.report({"ERROR"}, f"{type(error).__name__}: {error}. Nothing has changed; the console has the details")
        return {"CANCELLED"}

    def _end(self, context):
        global running
        running = None
        self._job.cancel()
        if self._steps is not None:
            self._steps.close()
        context.window_manager.event_timer_remove(self._timer)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        queue.redraw()


class MEASUREDBRDF_OT_cancel(bpy.types.Operator):
    """Stop fitting and leave everything as it was, as Esc does"""

    bl_idname = "measured_brdf.cancel"
    bl_label = "Cancel Fitting"

    def execute(self, _context):
        stop()
        return {"FINISHED"}


def stop():
    """End what runs, as Esc does: its operator takes notice of that."""
    global running
    if running is not None:
        running.cancel()
    running = None


@persistent
def _on_load(_file):
    stop()                          # the file for which it was meant is closed


classes = (MEASUREDBRDF_OT_cancel,)


def register():
    bpy.app.handlers.load_pre.append(_on_load)


def unregister():
    bpy.app.handlers.load_pre.remove(_on_load)
