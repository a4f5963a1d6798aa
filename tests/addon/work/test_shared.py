"""What the workers of one Blender have worked out is worked out once, and their progress moves."""

import errno
import os
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import pytest
from measured_brdf.addon.core.storage.outcomes import FitRequest
from measured_brdf.addon.work import process, shared, tasks
from measured_brdf.addon.work.job import Job, read_progress, write_progress
from measured_brdf.fitter.storage import files

import fitter
from fitter.samples import subset
from support.cases import release
from support.checkout import ROOT


@pytest.fixture
def making(monkeypatch):
    """Workers that make everything, also what the tests' own keep."""
    monkeypatch.setattr(process, "_WORKER_SCRIPT", ROOT / "addon" / "work" / "worker.py")


@pytest.fixture
def file(tmp_path, glossy, write_astm):
    return str(write_astm(tmp_path / "glossy.astm", subset(glossy, slice(300))))


def begun(name, function):
    job = process.Job(function)
    process.worker(name).begin(job)
    return job


def wait(*jobs, seconds=120):
    end = time.monotonic() + seconds
    while not all(job.poll() for job in jobs):
        assert time.monotonic() < end
        time.sleep(0.01)
    assert [job.error for job in jobs] == [None] * len(jobs)
    return [job.result for job in jobs]


def results():
    return sorted((path.name, path.stat().st_ino) for path in Path(process.folder()).glob("*.result"))


STANDARD, DRAFT = dict(fitter.PRESETS["Standard"]), dict(fitter.PRESETS["Draft"])


def test_after_an_import_no_worker_fits_the_same_again(making, file):
    """The time that a fit took is another one every time that it is made."""
    (imported,), = wait(begun("operator", partial(tasks.outcomes, [(file, "")], STANDARD)))
    outcome = imported[2]
    assert len(results()) == 2           # a preparation, and the fit
    before = results()
    data, = wait(begun("read", partial(tasks.read, file, "")))
    shown, _, _ = wait(begun("fit", partial(tasks.fit_data, data, STANDARD)),
                       begun("slow", partial(tasks.polar_plot, [(FitRequest(data, STANDARD), ())], data, 0.7)),
                       begun("draw", partial(tasks.lit_sphere, FitRequest(data, STANDARD), None)))
    assert shown.seconds == outcome.fitted.seconds
    assert shown.errors == outcome.fitted.errors
    assert results() == before
    wait(begun("fit", partial(tasks.fit_data, data, DRAFT)))
    assert len(results()) == 3           # another fit, by the same preparation


def test_two_workers_that_are_asked_at_once_fit_once(file):
    data, = wait(begun("read", partial(tasks.read, file, "")))
    for name in ("fit", "operator"):
        wait(begun(name, partial(tasks.read, file, "")))       # both have started
    first, second = (begun(name, partial(tasks.fit_data, data, STANDARD)) for name in ("fit", "operator"))
    wait(first, second)
    assert first.result.seconds == second.result.seconds
    assert len(results()) == 2


def test_a_worker_that_is_killed_leaves_its_work_to_others(file):
    data, = wait(begun("read", partial(tasks.read, file, "")))
    first = begun("fit", partial(tasks.fit_data, data, STANDARD))
    while first.doing == "Starting":
        assert not first.poll()
    first.cancel()
    fitting, = wait(begun("operator", partial(tasks.fit_data, data, STANDARD)))
    assert fitting.errors.rmse > 0


_BLENDER = """
import os, sys, time
from functools import partial
from support import checkout
package = checkout.extension()
package.register()
from measured_brdf.addon.work import blender_process
from measured_brdf.addon.work import process
from measured_brdf.addon.work import tasks
from measured_brdf.fitter import load
long = partial(tasks.held_out, tasks.read(sys.argv[1], ""), {"diffuse_level": 7, "specular_level": 8})
worker = process.Calculation(long).start()
other = blender_process.Command("starter", "-o", sys.argv[2]).start()
while "Starting" in (worker.doing, other.doing):
    assert not worker.poll() and not other.poll(), (worker.error, other.error)
    time.sleep(0.01)
print(worker.worker._process.pid, other.worker._process.pid, flush=True)
if sys.argv[3] == "exit":
    raise SystemExit
time.sleep(600)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="ps")
@pytest.mark.parametrize("end", ["exit", "kill"])
def test_workers_end_with_blender_and_leave_no_folder(file, tmp_path, end):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    blender = subprocess.Popen([sys.executable, "-c", _BLENDER, file, str(tmp_path / "starter"), end], cwd=ROOT,
                               env={**os.environ, "TMPDIR": str(temporary)}, stdout=subprocess.PIPE, text=True)
    working = [int(number) for number in blender.stdout.readline().split()]
    assert len(working) == 2
    if end == "kill":
        assert len([*temporary.glob("measured_brdf_*")]) == 1
        blender.kill()
    blender.wait()
    blender.stdout.close()
    deadline = time.monotonic() + 10
    while any(map(is_running, working)) or [*temporary.glob("measured_brdf_*")]:
        assert time.monotonic() < deadline
        time.sleep(0.05)


def is_running(number):
    shown = subprocess.run(["ps", "-o", "stat=", "-p", str(number)], capture_output=True, text=True, check=False)
    return shown.stdout.strip()[:1] not in ("", "Z")


@release
def test_errors_are_raised_in_every_worker_and_not_kept(file):
    data, = wait(begun("read", partial(tasks.read, file, "")))
    for name in ("fit", "operator"):
        job = begun(name, partial(tasks.fit_data, data, {"tolerance": 1e-9}))
        while not job.poll():
            time.sleep(0.01)
        assert "no fit is within" in str(job.error)
    assert results() == []


def test_a_single_process_shares_nothing(extension, monkeypatch, tmp_path):
    done = []
    for _ in range(2):
        assert shared.once("key", lambda: done.append(1) or len(done)) == len(done)
    monkeypatch.setenv(shared.WORKERS_FOLDER, str(tmp_path))
    assert [shared.once("key", lambda: done.append(1) or len(done)) for _ in range(2)] == [3, 3]


@pytest.mark.skipif(sys.platform == "win32", reason="fcntl")
def test_where_files_cannot_be_locked_the_work_is_done_all_the_same(extension, monkeypatch, tmp_path):
    answers = [OSError(errno.ENOLCK, "No locks available"), AssertionError("it waits for a lock that it cannot get")]

    def flock(_file, _operation):
        raise answers.pop(0)

    monkeypatch.setenv(shared.WORKERS_FOLDER, str(tmp_path))
    monkeypatch.setattr(files.fcntl, "flock", flock)
    assert shared.once("key", lambda: 5) == 5


def test_a_result_that_another_process_forgets_meanwhile_is_worked_out_again(extension, monkeypatch, tmp_path):
    monkeypatch.setenv(shared.WORKERS_FOLDER, str(tmp_path))
    assert shared.once("key", lambda: 5) == 5
    path, = tmp_path.glob("*.result")
    monkeypatch.setattr(shared.os, "utime", lambda _path: path.unlink() or path.stat())
    assert shared.once("key", lambda: 6) == 6


def test_only_the_latest_results_are_kept(extension, monkeypatch, tmp_path):
    monkeypatch.setenv(shared.WORKERS_FOLDER, str(tmp_path))
    monkeypatch.setattr(shared, "_KEPT_RESULTS", 3)
    for number in range(5):
        shared.once(str(number), lambda number=number: number)
        for path in tmp_path.glob("*.result"):
            os.utime(path, (path.stat().st_mtime - 10,) * 2)
    done = []
    for number in range(4, -1, -1):
        shared.once(str(number), lambda number=number: done.append(number))
    assert done == [1, 0]


def test_the_bar_of_an_import_moves_to_its_end_through_the_words_of_its_steps(making, file):
    job = begun("operator", partial(tasks.outcomes, [(file, ""), (file, "")], STANDARD))
    told = []
    while not job.poll():
        if not told or told[-1] != (job.fraction, job.doing):
            told.append((job.fraction, job.doing))
    fractions = [fraction for fraction, _ in told]
    assert fractions == sorted(fractions)
    assert len({*fractions}) > 15
    assert max(fractions) > 0.95
    steps = "Fitting shape", "Fitting the sparse lattice", "Writing the shader", "Matching nodes"
    assert {f"glossy.astm: {step}" for step in steps} <= {doing for _, doing in told}


def test_progress_is_replaced_as_a_whole(extension, tmp_path):
    """A reader at any moment finds a number and words, never half of them."""
    path, end = tmp_path / "1.progress", threading.Event()
    write_progress(path, 0.0, "x" * 10_000)

    def write():
        while not end.is_set():
            for number in range(10):
                write_progress(path, number / 10, str(number) * 10_000)

    writer = threading.Thread(target=write)
    writer.start()
    seen = set()
    for _ in range(3000):
        job = Job(None)
        read_progress(path, job)
        assert len(job.doing) == 10_000
        assert len({*job.doing}) == 1
        seen.add(job.fraction)
    end.set()
    writer.join()
    assert len(seen) > 1
