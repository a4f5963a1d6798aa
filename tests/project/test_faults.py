"""Processes killed while they write, and disks that fill up."""

import os
import random
import resource
import signal
import subprocess
import sys
import time

import pytest

import fitter
from support.cases import release
from support.checkout import ROOT, run_python

SAVE_AND_BAKE = """
import sys
import fitter
from fitter.cli import main
samples, fit, shader = sys.argv[1:]
while True:
    assert main(["fit", samples, "--preset", "Paper", "-o", fit]) == 0
    assert main(["bake", fit, "-o", shader]) == 0
    print("done", flush=True)
"""

IMPORT = """
import resource, sys
from support import checkout
extension = checkout.extension()
extension.register()
import bpy
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
count = lambda: [len(getattr(bpy.data, name)) for name in ("materials", "texts", "node_groups", "images", "objects")]
before = count()
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, resource.RLIM_INFINITY))
try:
    bpy.ops.measured_brdf.import_data(filepath=sys.argv[1])
except RuntimeError as error:
    print("REPORTED", error)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
assert count() == before, (before, count())
assert bpy.ops.measured_brdf.import_data(filepath=sys.argv[1]) == {"FINISHED"}
extension.unregister()       # bpy 4.2 as a module does not survive its end with operators registered
print("REPEATED")
"""


@pytest.fixture
def file(tmp_path):
    """A small ASTM file, in a folder of its own."""
    rows = [f"{i / 10},0,{o / 10},{p / 3},0.{i + 10},0.25,0.{o + 10}" for i in range(1, 15) for o in range(15)
            for p in range(10)]
    path = tmp_path / "data" / "white.astm"
    path.parent.mkdir()
    path.write_text("\n".join(["VARS theta_i,phi_i,theta_s,phi_s,R,G,B", *rows]))
    return path


def fitter_command(*arguments, **options):
    return run_python("-m", "fitter", *map(str, arguments), **options)


def test_a_process_killed_while_saving_or_baking_leaves_whole_files_and_a_rerun_finishes(file, tmp_path):
    fit, shader = tmp_path / "fit.npz", tmp_path / "fit.osl"
    expected = None
    chance = random.Random(7)
    for _ in range(3):
        process = subprocess.Popen([sys.executable, "-c", SAVE_AND_BAKE, file, fit, shader], cwd=ROOT,
                                   stdout=subprocess.PIPE)
        while b"done" not in (line := process.stdout.readline()):
            assert line, "it has ended by itself"
        time.sleep(chance.random() * 0.3)
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
        expected = expected or shader.read_bytes()
        assert shader.read_bytes() == expected
        assert fitter.Fit.load(fit).coefficient_count > 1000
    assert fitter_command("fit", file, "--preset", "Paper", "-o", fit).returncode == 0
    assert fitter_command("bake", fit, "-o", shader).returncode == 0


def limit_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, resource.RLIM_INFINITY))


def assert_reported(done, folder, path, before):
    assert done.returncode == 1
    assert done.stderr.startswith(f"error: {path}: ")
    assert len(done.stderr.splitlines()) == 1
    assert {entry.name: entry.read_bytes() for entry in folder.iterdir() if entry.is_file()} == before


def test_a_full_disk_is_reported_and_cleaned_up_after(file, tmp_path):
    """A process that may write no more than 20 kB into a file fails as on a full disk: in the middle of writing."""
    folder = tmp_path / "out"
    folder.mkdir()
    fit, shader = folder / "fit.npz", folder / "fit.osl"
    assert fitter_command("fit", file, "--preset", "Paper", "-o", fit).returncode == 0
    assert fitter_command("bake", fit, "-o", shader).returncode == 0
    before = {path.name: path.read_bytes() for path in (fit, shader)}
    assert all(len(content) > 20_000 for content in before.values())
    assert_reported(fitter_command("fit", file, "--preset", "Paper", "-o", fit, preexec_fn=limit_files), folder, fit,
                    before)
    assert_reported(fitter_command("bake", fit, "-o", shader, preexec_fn=limit_files), folder, shader, before)


@release
def test_a_file_system_without_room_is_reported_and_cleaned_up_after(file, tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if os.geteuid() or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=32k", "tmpfs", disk], check=False,
                                      capture_output=True).returncode:
        pytest.skip("only where a small file system may be mounted")
    try:
        done = fitter_command("fit", file, "--preset", "Paper", "-o", disk / "fit.npz")
        assert_reported(done, disk, disk / "fit.npz", {})
        assert "No space left" in done.stderr
        draft = fitter_command("fit", file, "--preset", "Draft", "--diffuse-level", 1, "-o", disk / "fit.npz")
        assert draft.returncode == 0, draft.stderr
    finally:
        subprocess.run(["umount", disk], check=True)


def test_an_import_that_finds_the_disk_full_leaves_the_blend_as_it_was_and_may_be_repeated(file):
    done = run_python("-c", IMPORT, file)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "REPORTED Error: The OSL compiler" in done.stdout
    assert "REPEATED" in done.stdout
    assert "Traceback" not in done.stdout + done.stderr
