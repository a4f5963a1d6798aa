"""Operators that work in another process while the window stays responsive: with a progress bar, and Esc to cancel.

One works at a time; those that are started meanwhile wait for it, in their order. Users may undo, open another file, or
delete anything. So between two timer events no reference to Blender's data is kept, but the `session_uid` of a target.
"""

import time
import traceback
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager
from typing import Any

import bpy
from bpy.app.handlers import persistent

from ..core.annotations import OperatorMixIn, OperatorResult, not_none
from ..core.blender import transaction
from ..core.shading import compiler
from . import blender_process, process, queue
from .job import Job, Work

Steps = Generator[tuple[float, str], None, Any]
"""Work in pieces: yields (fraction, doing) after each, and returns its result."""

EXPECTED_ERRORS = compiler.CompileError, process.WorkerError, blender_process.CommandError, ValueError, OSError

running: Job[Any] | None = None             # the job whose progress the panel shows
waiting: list[Work] = []                    # what begins when it has ended, one after the other


class InBackground(OperatorMixIn):
    """A mix-in for operators. The whole is one undo step; an operator that fails or is cancelled changes nothing.

    An operator defines `work` and `apply`, and `prepare` if there is something to prepare.
    """

    _work: Work | None = None
    _job: Job[Any] | None = None
    _steps: Steps | None = None
    _timer: bpy.types.Timer | None = None

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        return self.run(context)

    def work(self, context: bpy.types.Context) -> Work:
        """What to do in another process."""
        raise NotImplementedError

    def prepare(self, result: Any) -> Steps:
        """Make of the result what `apply` takes, in pieces, without changing Blender's data. By default, return it."""
        return result
        yield

    def apply(self, context: bpy.types.Context, prepared: Any) -> None:
        """Change Blender's data, in one step."""
        raise NotImplementedError

    def run(self, context: bpy.types.Context) -> OperatorResult:
        """Do everything at once, for scripts: what `execute` returns."""
        try:
            with closing(self.prepare(self.work(context).run())) as steps:
                while self._prepare_next(steps) is not None:
                    pass
            self._apply(context)
        except Exception as error:
            return self._report_failure(error)
        return {"FINISHED"}

    def start(self, context: bpy.types.Context) -> OperatorResult:
        """Begin, and continue in `modal`: what `invoke` returns."""
        if bpy.app.background:
            return self.execute(context)
        try:
            work = self.work(context)
            if running is None and not waiting:
                self._begin(work)
            else:               # begin when all that was started before has ended
                self._work, self._job, self._steps = work, None, None
                waiting.append(work)
                self.report({"INFO"}, "Queued: it begins when what is running has ended")
        except Exception as error:
            return self._report_failure(error)
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if self._job is None and self._work in waiting:
            return self._modal_in_line(context, event)
        if (event.type == "ESC" and event.value == "PRESS") or self._job is None or running is not self._job:
            self._end(context)
            self.report({"INFO"}, "Cancelled; nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            done = self._step(context)
        except Exception as error:
            self._end(context)
            return self._report_failure(error)
        except BaseException:
            self._end(context)
            raise
        if done:
            self._end(context)
            return {"FINISHED"}
        if context.workspace is not None:
            context.workspace.status_text_set("    ".join(filter(None, (
                self._job.doing, f"{self._job.fraction:.0%}", self._job.time_left(time.monotonic()), "Esc: Cancel"))))
        queue.redraw()
        return {"PASS_THROUGH"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender calls this when it ends the operator, for example because another file is opened."""
        self._end(context)

    def _begin(self, work: Work) -> None:
        global running
        self._work, self._job, self._steps = work, None, None
        self._job = running = work.start()

    def _modal_in_line(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        """Begin if it is this operator's turn. Esc is for what is running."""
        if event.type == "TIMER" and running is None and waiting[0] is self._work:
            try:
                self._begin(waiting.pop(0))
            except Exception as error:
                self._end(context)
                return self._report_failure(error)
        return {"PASS_THROUGH"}

    def _step(self, context: bpy.types.Context) -> bool:
        """Do the next piece: whether all is done."""
        job = not_none(self._job)
        if not job.poll():
            return False
        if job.error is not None:
            raise job.error
        if self._steps is None:
            self._steps = self.prepare(job.result)
        progress = self._prepare_next(self._steps)
        if progress is None:
            self._apply(context)
            return True
        job.fraction, job.doing = progress
        return False

    def _prepare_next(self, steps: Steps) -> tuple[float, str] | None:
        """Prepare the next piece: its progress; None when all is prepared."""
        try:
            return next(steps)
        except StopIteration as end:
            self._prepared = end.value
            return None

    def _apply(self, context: bpy.types.Context) -> None:
        with transaction.new_data_removed_on_error():
            self.apply(context, self._prepared)

    def _report_failure(self, error: Exception) -> OperatorResult:
        """Report an error, an unexpected one with a traceback on the console: what `execute` or `modal` returns."""
        if isinstance(error, EXPECTED_ERRORS):
            self.report({"ERROR"}, str(error))
        else:
            traceback.print_exception(error)
            self.report({"ERROR"}, f"{type(error).__name__}: {error}. Nothing has changed; the console has the details")
        return {"CANCELLED"}

    def _end(self, context: bpy.types.Context) -> None:
        global running
        if self._work in waiting:
            waiting.remove(self._work)
        if self._job is not None:
            if running is self._job:    # another operator may have begun since this one was cancelled
                running = None
            self._job.cancel()
        if self._steps is not None:
            self._steps.close()
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        queue.redraw()


@contextmanager
def errors_reported(operator: bpy.types.Operator) -> Iterator[None]:
    """Report the errors of other operators that the block calls as errors of this one: Blender raises them."""
    try:
        yield
    except RuntimeError as error:
        operator.report({"ERROR"}, str(error).strip().removeprefix("Error: "))


def begin_another(operator: bpy.types.Operator, name: str, **options: Any) -> OperatorResult:
    """Begin another operator of the extension, in the place of one that ends: what that returns."""
    with errors_reported(operator):
        getattr(bpy.ops.measured_brdf, name)("INVOKE_DEFAULT", **options)
    return {"CANCELLED"}


class AsksForPath(InBackground):
    """A mix-in for operators that ask for files or a folder, unless they are given them."""

    path_name = "directory"         # the property that holds what is asked for

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> OperatorResult:
        if getattr(self, self.path_name):
            return self.begin(context, event)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def begin(self, context: bpy.types.Context, _event: bpy.types.Event) -> OperatorResult:
        """Continue with what was chosen: what `invoke` returns."""
        return self.start(context)

    def execute(self, context: bpy.types.Context) -> OperatorResult:
        # called by the file browser or a dialog, it starts anew as a modal operator: the window stays responsive
        if not self.options.is_invoke or self.options.is_repeat or bpy.app.background:
            return self.run(context)
        return begin_another(self, type(self).__name__.partition("_OT_")[2], **self.property_values())

    def property_values(self) -> dict[str, Any]:
        """What the operator was given, for another that goes on with it."""
        properties: dict[str, Any] = not_none(self.as_keywords(ignore=("filter_glob",)))
        return {name: [{"name": item.name} for item in value] if name == "files" else value
                for name, value in properties.items()}


class MEASUREDBRDF_OT_cancel(bpy.types.Operator):
    """Stop fitting and leave everything unchanged. Esc does the same"""

    bl_idname = "measured_brdf.cancel"
    bl_label = "Cancel Fitting"

    def execute(self, _context: bpy.types.Context) -> OperatorResult:
        stop()
        return {"FINISHED"}


def stop() -> None:
    """End the running job, as Esc does; its operator then ends with the next event."""
    global running
    if running is not None:
        running.cancel()
    running = None


@persistent
def _on_load(_file: object) -> None:
    waiting.clear()                 # the file that the jobs were for is being closed
    stop()


def unregister() -> None:
    _on_load(None)


classes = (MEASUREDBRDF_OT_cancel,)
handlers = {"load_pre": _on_load}
