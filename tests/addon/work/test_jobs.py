"""Jobs in another process: results, progress, and every way to end."""

import contextlib
import os
import pickle
import sys
import time
from functools import partial
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from measured_brdf.addon.core.storage.outcomes import Outcome
from measured_brdf.addon.work import blender_process, command, modal, process, queue, tasks
from measured_brdf.fitter import DatasetError, load

import fitter
from fitter.quality import cross_validation
from support import merl_files
from tests.addon.answers import answer_all

MOST_TICKS = 50             # of a window's timer, until what takes three steps has ended


@pytest.fixture
def long_work(extension, file):
    """Work that takes minutes."""
    return partial(tasks.held_out, tasks.read(str(file), ""), {"diffuse_level": 7, "specular_level": 8})


def begun(work):
    return process.Calculation(work).start()


def wait(job, seconds=60):
    end = time.monotonic() + seconds
    while not job.poll():
        assert time.monotonic() < end
        time.sleep(0.02)
    return job


def test_an_outcome_is_the_same_as_without_the_process(file):
    job = wait(begun(partial(tasks.outcome, str(file), "", fitter.PRESETS["Paper"])))
    expected = tasks.outcome(str(file), "", fitter.PRESETS["Paper"])
    assert job.error is None
    assert isinstance(job.result, Outcome)
    assert job.result.measured.digest == expected.measured.digest
    assert len(job.result.surface.source) == pytest.approx(len(expected.surface.source), rel=1e-3)
    directions = fitter.load(file).directions
    there, here = (each.fitted.fit.evaluate(*directions) for each in (job.result, expected))
    np.testing.assert_allclose(there, here, rtol=1e-6)
    assert job.doing != "Starting"


def test_errors_come_back_as_they_were_raised(tmp_path):
    job = wait(begun(partial(tasks.outcome, str(tmp_path / "gone.astm"), "", {})))
    assert isinstance(job.error, DatasetError)
    assert "gone.astm: cannot be read: No such file" in str(job.error)


def test_an_answer_that_cannot_be_read_is_an_error_and_the_next_is_done(file):
    """Reading it runs code of its class."""
    broken = 'type("Broken", (), {"__reduce__": lambda self: (int, ("nothing",))})()'
    assert isinstance(wait(begun(partial(eval, broken))).error, ValueError)
    assert wait(begun(partial(tasks.read, str(file), ""))).result.description.count == 500


def test_cancelled_work_ends_at_once_and_the_next_is_done(long_work, file):
    slow = begun(long_work)
    while slow.doing == "Starting":
        assert not slow.poll()
        time.sleep(0.02)
    child = slow.worker._process
    assert child.poll() is None
    slow.cancel()
    assert child.poll() is not None
    assert wait(begun(partial(tasks.read, str(file), ""))).result.description.count == 500


def test_a_large_file_is_read_once_and_never_sent(extension, tmp_path, monkeypatch):
    file = tmp_path / "made.binary"
    file.write_bytes(merl_files.pack(merl_files.random_cells(32, 1)))
    reads = []
    monkeypatch.setattr(tasks.fitter, "load", lambda path, *options, **how: reads.append(path) or load(path))
    data = tasks.read(str(file), "")
    assert len(tasks.load_samples(data)) == data.description.count > 10_000
    assert len(pickle.dumps(data)) < 10_000 < 0.01 * file.stat().st_size
    assert tasks.load_samples(pickle.loads(pickle.dumps(data))) is tasks.load_samples(data)
    tasks.fit_data(data, {"diffuse_level": 1, "specular_level": None})
    assert tasks.read(str(file), "").description is data.description
    outcome = tasks.outcome(str(file), "", {"diffuse_level": 1, "specular_level": None})
    assert len(pickle.dumps(outcome._replace(surface=outcome.surface._replace(source="")))) < 100_000
    assert reads == [str(file)]
    file.write_bytes(merl_files.pack(merl_files.random_cells(32, 2)))
    os.utime(file, (1, 1))
    with pytest.raises(DatasetError, match="has changed"):
        tasks.load_samples(data)
    assert tasks.read(str(file), "").digest != data.digest
    assert len(reads) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="resource.prlimit")
def test_an_answer_that_does_not_fit_onto_the_disk_is_an_error_that_says_so(file):
    import resource

    worker, nothing = process.worker("operator"), partial(tasks.rebake, [])
    large = partial(tasks.outcome, str(file), "", {"diffuse_level": 1, "specular_level": None})

    def done(function):
        job = process.Job(function)
        worker.begin(job)
        return wait(job)

    # before, because Python would leave half of its bytecode on a full disk
    assert [done(work).error for work in (large, nothing)] == [None, None]
    resource.prlimit(worker._process.pid, resource.RLIMIT_FSIZE, (1000, 1000))
    failed = done(large).error
    assert isinstance(failed, OSError)
    assert worker._folder.name in str(failed)
    assert done(nothing).error is None


def test_held_out_errors_are_those_of_cross_validation(extension, glossy, write_astm, tmp_path):
    arguments = fitter.PRESETS["Paper"]
    expected = cross_validation.cross_validate(glossy, lambda part: fitter.fit(part, **arguments)).rmse
    data = tasks.read(str(write_astm(tmp_path / "glossy.astm", glossy)), "")
    assert tasks.held_out(data, arguments) == pytest.approx(expected)


def test_answers_are_kept_and_stale_ones_asked_for_again():
    asked = []

    def function():
        asked.append(1)
        return len(asked)

    queue.ask("question", function)
    answer_all()
    assert queue.ask("question", function).result == 1
    answer_all()
    assert queue.ask("question", function, max_age=0).result == 1      # until the new one is there
    answer_all()
    assert queue.ask("question", function).result == 2


def test_questions_that_no_panel_asks_again_are_dropped():
    for number in range(3):
        queue.ask(number, lambda number=number: number)
    kept = queue.ask(1, None)
    lane = queue._lanes["fit"]
    lane.drop_unwanted(kept.asked + queue._UNWANTED / 2)
    assert [key for key, *_ in lane.queue] == [0, 1, 2]
    lane.queue[0][1].asked -= 10
    lane.queue[2][1].asked -= 10
    lane.drop_unwanted(kept.asked)
    assert [key for key, *_ in lane.queue] == [1]
    answer_all()
    assert kept.result == 1
    assert 0 not in queue._answers


def test_slow_questions_do_not_hold_up_others(long_work, file):
    slow = queue.ask("slow", long_work, "slow")
    quick = queue.ask("quick", partial(tasks.read, str(file), ""))
    end = time.monotonic() + 60
    while quick.finished is None and time.monotonic() < end:
        queue._poll()
        slow.asked = time.monotonic()
        time.sleep(0.02)
    assert quick.result.description.count == 500
    assert slow.finished is None


class Finished:
    """A job that has finished already."""

    def start(self):
        job = process.Job(None)
        job.finished = time.monotonic()
        return job


@pytest.fixture
def operator(extension):
    """An operator that works piece by piece, without Blender."""
    class Operator(modal.InBackground):
        def __init__(self):
            self.made, self.closed, self.reports, self._timer = [], False, [], None

        def work(self, _context):
            return Finished()

        def prepare(self, _result):
            try:
                for number in range(3):
                    yield number / 3, "Making"
            except GeneratorExit:
                self.closed = True
                raise
            return [0, 1, 2]

        def apply(self, _context, prepared):
            self.made += prepared

        def report(self, kind, text):
            self.reports.append((kind, text))

    yield Operator()
    modal.running = None
    modal.waiting.clear()


CONTEXT = SimpleNamespace(workspace=None, window_manager=SimpleNamespace(event_timer_remove=lambda timer: None))


def event(kind):
    return SimpleNamespace(type=kind, value="PRESS")


def test_a_modal_operator_goes_step_by_step_to_its_end_and_makes_all_in_the_last(operator):
    operator._begin(Finished())
    for _ in range(3):
        assert operator.modal(CONTEXT, event("TIMER")) == {"PASS_THROUGH"}
        assert operator.made == []
    assert operator.modal(CONTEXT, event("TIMER")) == {"FINISHED"}
    assert operator.made == [0, 1, 2]


def test_escape_while_it_prepares_ends_it_and_nothing_is_made(operator):
    operator._begin(Finished())
    operator.modal(CONTEXT, event("TIMER"))
    assert operator.modal(CONTEXT, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert operator.modal(CONTEXT, event("ESC")) == {"CANCELLED"}
    assert operator.closed
    assert operator.made == []


def test_escape_while_the_process_works_changes_nothing(operator, long_work):
    operator._begin(process.Calculation(long_work))
    child = operator._job.worker._process
    assert operator.modal(CONTEXT, event("TIMER")) == {"PASS_THROUGH"}
    assert operator.modal(CONTEXT, event("ESC")) == {"CANCELLED"}
    assert (operator.made, operator.closed) == ([], False)      # it had not begun to prepare
    assert child.poll() is not None


def test_a_process_that_dies_under_an_operator_is_reported(operator, long_work):
    operator._begin(process.Calculation(long_work))
    operator._job.worker._process.kill()
    operator._job.worker._process.wait()
    assert operator.modal(CONTEXT, event("TIMER")) == {"CANCELLED"}
    assert "ended early" in operator.reports[-1][1]
    assert operator.made == []


def test_a_process_that_died_before_it_got_work_is_reported(file):
    worker = process.Worker()
    worker._process.kill()
    worker._process.wait()
    job = process.Job(partial(tasks.read, str(file), ""))
    worker.begin(job)
    assert "ended early" in str(wait(job).error)


@pytest.fixture
def window(monkeypatch):
    """A stand-in for a window: its remaining timers, and a context to start operators in."""
    timers = []
    manager = SimpleNamespace(event_timer_add=lambda interval, window: timers.append(interval) or interval,
                              event_timer_remove=timers.remove, modal_handler_add=lambda operator: None)
    monkeypatch.setattr(modal, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    return SimpleNamespace(workspace=None, window=None, window_manager=manager, timers=timers)


def full(*_):
    raise OSError("disk full")


@pytest.fixture
def line(operator, window):
    """Three operators that were started at once."""
    made = [operator, type(operator)(), type(operator)()]
    for each in made:
        assert each.start(window) == {"RUNNING_MODAL"}
    return made


def to_the_end(line, window):
    """Send timer events to all that have not ended, the last started first as Blender does: who ended how, in order."""
    going, ended = [*line], []
    for _ in range(MOST_TICKS):
        for each in reversed([*going]):
            result = each.modal(window, event("TIMER"))
            if result != {"PASS_THROUGH"}:
                ended.append((line.index(each), *result))
                going.remove(each)
    assert not going
    return ended


def test_operators_that_are_started_while_another_works_wait_and_follow_in_their_order(line, window):
    assert [bool(each.reports) for each in line] == [False, True, True]
    assert "Queued" in line[1].reports[-1][1]
    assert to_the_end(line, window) == [(0, "FINISHED"), (1, "FINISHED"), (2, "FINISHED")]
    assert [each.made for each in line] == [[0, 1, 2]] * 3
    assert window.timers == []


def test_escape_is_for_the_one_that_works_and_the_next_follows(line, window):
    for each in reversed(line):         # as Blender passes it on
        if (result := each.modal(window, event("ESC"))) != {"PASS_THROUGH"}:
            break
    assert (line.index(each), *result) == (0, "CANCELLED")
    assert to_the_end(line[1:], window) == [(0, "FINISHED"), (1, "FINISHED")]
    assert [each.made for each in line] == [[], [0, 1, 2], [0, 1, 2]]


def test_one_that_cannot_begin_when_its_turn_comes_lets_the_next_begin(line, window):
    line[1]._work.start = full
    assert to_the_end(line, window) == [(0, "FINISHED"), (1, "CANCELLED"), (2, "FINISHED")]
    assert "disk full" in line[1].reports[-1][1]


def test_what_waits_ends_with_the_file_that_it_was_for(extension, line, window):
    modal._on_load("")
    assert [way for _, way in to_the_end(line, window)] == ["CANCELLED"] * 3
    assert [(each.made, each.reports[-1][1]) for each in line] == [([], "Cancelled; nothing has changed")] * 3
    assert (modal.waiting, window.timers) == ([], [])


def test_an_operator_that_begins_before_a_cancelled_one_has_ended_goes_on(extension, operator, window):
    second = type(operator)()
    assert operator.start(window) == {"RUNNING_MODAL"}
    assert bpy.ops.measured_brdf.cancel() == {"FINISHED"}
    assert second.start(window) == {"RUNNING_MODAL"}
    assert operator.modal(window, event("TIMER")) == {"CANCELLED"}
    assert to_the_end([second], window) == [(0, "FINISHED")]
    assert (operator.made, second.made) == ([], [0, 1, 2])
    assert window.timers == []


@pytest.mark.parametrize("error", [ValueError("no good"), ZeroDivisionError("by nobody expected"), KeyboardInterrupt()])
def test_an_operator_that_raises_ends_its_work_and_its_timer_and_the_next_can_start(operator, window, error, capfd):
    def fails(_context, _prepared):
        raise error

    operator.start(window)
    operator.apply = fails
    with contextlib.suppress(KeyboardInterrupt):
        for _ in range(MOST_TICKS):
            if (result := operator.modal(window, event("TIMER"))) != {"PASS_THROUGH"}:
                break
        assert result == {"CANCELLED"}
        assert str(error) in operator.reports[-1][1]
    assert modal.running is None
    assert window.timers == []
    assert ("Traceback" in capfd.readouterr().err) == isinstance(error, ZeroDivisionError)


@pytest.mark.parametrize("how", ["start", "run"])
def test_work_that_cannot_begin_is_reported_in_one_line(operator, window, how):
    operator.work = full
    assert getattr(operator, how)(window) == {"CANCELLED"}
    assert operator.reports == [({"ERROR"}, "disk full")]
    assert window.timers == []


def test_between_two_ticks_of_the_timer_nothing_is_done(operator, window):
    operator.start(window)
    for _ in range(10):
        assert operator.modal(window, event("MOUSEMOVE")) == {"PASS_THROUGH"}
    assert operator.made == []
    assert operator._steps is None


def test_without_a_window_all_is_done_at_once(operator):
    operator.execute = lambda context: {"FINISHED"}
    assert operator.start(CONTEXT) == {"FINISHED"}


@pytest.mark.parametrize("folder", ["", "/measurements"])
def test_the_file_browser_opens_unless_the_folder_is_named(extension, folder):
    asked = []
    asks = type("Asks", (modal.AsksForPath,), {"directory": folder, "start": lambda self, _: asked.append("start")})
    browser = SimpleNamespace(fileselect_add=lambda operator: asked.append("browser"))
    asks().invoke(SimpleNamespace(window_manager=browser), None)
    assert asked == ["start" if folder else "browser"]


@pytest.mark.parametrize(("is_invoke", "is_repeat", "background", "done"), [
    (True, False, False, "again"), (False, False, False, "run"), (True, True, False, "run"),
    (True, False, True, "run")])
def test_what_the_file_browser_answers_is_begun_anew_so_that_the_window_stays_responsive(
        extension, monkeypatch, is_invoke, is_repeat, background, done):
    asked = []
    operators = SimpleNamespace(asks=lambda how, **given: asked.append(("again", how, given["directory"])))
    monkeypatch.setattr(modal, "bpy", SimpleNamespace(app=SimpleNamespace(background=background),
                                                      ops=SimpleNamespace(measured_brdf=operators)))
    asks = type("MEASUREDBRDF_OT_asks", (modal.AsksForPath,), {
        "property_values": lambda self: {"directory": "/data"}, "run": lambda self, _: asked.append(("run",)),
        "options": SimpleNamespace(is_invoke=is_invoke, is_repeat=is_repeat)})
    asks().execute(None)
    assert asked == [("again", "INVOKE_DEFAULT", "/data") if done == "again" else ("run",)]


def test_the_bar_of_an_import_goes_on_from_the_fit_when_shaders_are_compiled(extension):
    outcomes = [(name, "", SimpleNamespace(measured=SimpleNamespace(name=name))) for name in "ab"]
    steps = extension.addon.work.making.MakesMaterials.prepare(None, outcomes)
    assert next(steps) == (0.95, "Compiling a")


def test_a_command_that_is_interrupted_takes_its_blender_with_it(extension, monkeypatch, tmp_path):
    jobs, start = [], blender_process.Command.start
    monkeypatch.setattr(blender_process.Command, "start", lambda command: jobs.append(start(command)) or jobs[-1])

    def interrupt(_seconds):
        raise KeyboardInterrupt

    monkeypatch.setattr(blender_process.time, "sleep", interrupt)
    with pytest.raises(KeyboardInterrupt):
        blender_process.Command("starter", "-o", tmp_path / "library").run()
    assert not jobs[0].worker.is_alive()


def test_a_command_whose_blender_was_killed_fails_and_says_so(extension, tmp_path):
    job = blender_process.Command("starter", "-o", tmp_path / "library").start()
    job.worker._process.kill()
    wait(job)
    assert isinstance(job.error, process.WorkerError)
    assert "Blender ended early, with exit code -9" in str(job.error)


def test_a_worker_answers_one_question_after_the_other_and_tells_each_answer():
    told, questions = [], [(number, partial(pow, 2, number)) for number in (3, 4)]
    end = time.monotonic() + 60
    while time.monotonic() < end and len(told) < 2:
        for number, function in questions:          # as panels do, time and again
            queue.ask(number, function, then=told.append)
        queue._poll()
        time.sleep(0.02)
    assert [job.result for job in told] == [8, 16]
    assert [queue.ask(number, function) for number, function in questions] == told


def test_a_second_blender_is_the_executable_that_runs_or_python_where_blender_is_a_module(extension, monkeypatch):
    assert blender_process._command_line()[0] == sys.executable
    app = SimpleNamespace(binary_path="/opt/blender/blender", python_args=())
    monkeypatch.setattr(blender_process, "bpy", SimpleNamespace(app=app))
    line = blender_process._command_line()
    assert line[:3] == ["/opt/blender/blender", "--background", "--factory-startup"]
    assert line[-3::2] == ["--python", "--"]


def test_a_command_that_closes_the_open_file_runs_in_a_second_blender(blender, extension, monkeypatch, tmp_path):
    asked = []

    class Second:
        def __init__(self, *arguments):
            asked.append(arguments)

        def run(self):
            return {"rows": [], "path": "library.blend"}

    blender.ops.wm.save_as_mainfile(filepath=str(tmp_path / "open.blend"))
    monkeypatch.setattr(command, "Command", Second)
    given = "convert", str(tmp_path), "-o", str(tmp_path / "library.blend")
    command.main(given)
    assert asked == [(*given, "--colours", "Rec.709")]
    assert blender.data.filepath == str(tmp_path / "open.blend")
