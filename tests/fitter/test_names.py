"""Names and texts that no terminal and no text file can have, and commands that are ended."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import fitter
from fitter import cli, interrupts
from fitter.errors import printable
from fitter.formats import saved_samples
from fitter.storage import npz
from support import hostile_files
from support.cases import quick
from support.checkout import ROOT

ROWS = "# angles: degrees\ntheta_i,phi_i,theta_o,phi_o,BRDF\n" + "".join(
    f"{theta_i},0,{theta_o},{phi},0.1\n" for theta_i in (10, 40) for theta_o in (0, 30, 60) for phi in (0, 90, 180))


@pytest.fixture
def odd(tmp_path):
    """A folder of tables whose names are not UTF-8, or steer a terminal."""
    for name in (b"\xff\xfe.csv", b"red\x1b[31m.csv", b"good.csv"):
        try:
            with open(os.path.join(os.fsencode(tmp_path), name), "w") as stream:
                stream.write(ROWS)
        except OSError:
            pytest.skip("names of files are UTF-8 here")
    (tmp_path / "named.csv").write_text("# name: gold\x1b[2J\x07\n" + ROWS)
    return tmp_path


def run(*arguments, **options):
    environment = os.environ | {"LC_ALL": "C.UTF-8", "PYTHONIOENCODING": "utf-8:strict"}
    return subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, check=False, env=environment,
                          **options)


def test_names_are_told_without_what_steers_a_terminal(odd):
    for path in odd.iterdir():
        told = run("-m", "fitter", "info", path)
        assert told.returncode == 0, told.stderr
        assert b"18 direction pairs" in told.stdout
        assert b"\x1b" not in told.stdout + told.stderr
        told.stdout.decode("utf-8")
    missing = run("-m", "fitter", "info", os.fsdecode(b"\xff\x1b[31m"))
    assert missing.returncode == 1
    assert missing.stderr.startswith(rb"error: \udcff\x1b[31m: cannot be read")


def test_a_folder_with_odd_names_is_converted(blender, odd):
    done = run(".", "convert", odd, "-o", odd / "library.blend", "--preset", "Draft")
    assert done.returncode == 0, done.stderr
    assert b"4 done, 0 failed" in done.stdout
    assert b"\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize("encoding", quick(["cp1252", "ascii"], "ascii"))
def test_a_terminal_without_the_letters_of_a_name_shows_them_as_escapes(blender, tmp_path, encoding):
    path, library = tmp_path / "金.csv", tmp_path / "library.blend"
    path.write_text("# name: 金 Gold\n" + ROWS, "utf-8")
    fit = ["fit", path, "--preset", "Draft", "-o", tmp_path / "金.npz"]
    for command, shown in ((["-m", "fitter", "info", path], rb"\u91d1 Gold"), (["-m", "fitter", *fit], rb"\u91d1 Gold"),
                           (["-m", "fitter", "report", path, "--out", tmp_path / "金"], rb"| \u91d1 Gold | Draft |"),
                           ([".", "convert", path, "-o", library, "--preset", "Draft"], rb"\u91d1 Gold")):
        done = subprocess.run([sys.executable, *map(str, command)], cwd=ROOT, capture_output=True, check=False,
                              timeout=120, env=os.environ | {"PYTHONIOENCODING": encoding})
        assert (done.returncode, b"Traceback" in done.stderr) == (0, False), done.stderr
        assert shown in done.stdout
    assert "金 Gold" in (tmp_path / "金" / "results.md").read_text("utf-8")


def test_a_line_break_in_a_name_begins_no_line(tmp_path, capsys):
    samples = fitter.Samples(*np.full((4, 5), 0.5), np.full((5, 1), 0.1), name="gold\nerror: none\u2028x",
                             notes=("Read\nTwice",))
    saved_samples.write(samples, tmp_path / "a.npz")
    fitter.fit(samples, 1, None).save(tmp_path / "fit.npz")
    for command in (["info", tmp_path / "a.npz"], ["info", tmp_path / "fit.npz"],
                    ["report", tmp_path / "a.npz", "--out", tmp_path / "report"]):
        assert cli.main([str(each) for each in command]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert rb"gold\nerror: none\u2028x".decode() in "".join(lines)
        assert not [line for line in lines if line.startswith(("error", "Twice", "x"))]
    (tmp_path / "setup.toml").write_text('"x\\nerror: none" = 1\n')
    assert cli.main(["photographs", str(tmp_path / "setup.toml"), "-o", str(tmp_path / "b.npz")]) == 1
    assert rb"x\nerror: none is not known".decode() in capsys.readouterr().err


def test_progress_on_a_file_whose_name_is_not_utf_8_is_told(extension, tmp_path):
    job = extension.addon.work.job
    told = job.Job(None)
    job.write_progress(tmp_path / "progress", 0.5, "Reading \udcff")
    job.read_progress(tmp_path / "progress", told)
    assert (told.fraction, told.doing) == (0.5, "Reading \\udcff")


def test_saved_samples_may_have_half_a_character_for_a_name(tmp_path):
    content = npz.to_bytes({"samples": np.array(json.dumps({
        "format": "measured-brdf-samples", "version": 1, "name": "a\ud800", "source": "", "notes": ["\ud801"],
        "channels": ["grey"], "isotropic": True})), "directions": np.full((4, 5), 0.5, np.float32),
        "values": np.full((5, 1), 0.1, np.float32)})
    (tmp_path / "a.npz").write_bytes(content)
    samples = fitter.load(tmp_path / "a.npz")
    for text in (samples.name, *samples.notes):
        text.encode()
    assert samples.name == r"a\ud800"


def test_printable_text_stays_as_it_is():
    assert printable("Gold, 30°, 色 \u00a0x") == "Gold, 30°, 色 \u00a0x"


def test_a_small_file_does_not_fill_memory(tmp_path):
    """110 kB that claim 112 MB."""
    (tmp_path / "a.npz").write_bytes(hostile_files.CONTENTS["saved samples: 4 million of one value"]())
    assert (tmp_path / "a.npz").stat().st_size < 130_000
    with pytest.raises(fitter.DatasetError, match="its arrays claim more than"):
        fitter.load(tmp_path / "a.npz")


def test_no_path_is_no_folder():
    with pytest.raises(fitter.DatasetError, match="no file is named"):
        fitter.load("")


def test_an_interrupted_command_says_so_in_one_line(tmp_path, monkeypatch, capsys):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    (tmp_path / "a.csv").write_text(ROWS)
    monkeypatch.setattr(cli, "load", interrupted)
    assert cli.main(["info", str(tmp_path / "a.csv")]) == interrupts.CANCELLED
    assert capsys.readouterr().err == "cancelled\n"


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize(("module", "command"), [("numpy", ["-m", "fitter", "info", "a.csv"]),
                                                 ("bpy", [".", "convert", "a", "-o", "a.blend"])])
def test_an_interrupt_during_imports_is_said_in_one_line(tmp_path, module, command):
    (tmp_path / f"{module}.py").write_text("import os, signal, time\ntry:\n    os.kill(os.getpid(), signal.SIGINT)\n"
                                           "    time.sleep(9)\nexcept BaseException as error:\n    raise ImportError")
    done = subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, text=True, check=False, timeout=60,
                          env=os.environ | {"PYTHONPATH": str(tmp_path)},
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert (done.returncode, done.stdout, done.stderr) == (interrupts.CANCELLED, "", "cancelled\n")


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_an_interrupted_conversion_says_so_in_one_line(blender, tmp_path):
    (tmp_path / "files").mkdir()
    for number in range(60):
        (tmp_path / "files" / f"{number}.csv").write_text(ROWS)
    process = subprocess.Popen([sys.executable, ".", "convert", tmp_path / "files", "-o", tmp_path / "library.blend"],
                               cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    while not [*tmp_path.glob("*/*.npz"), *tmp_path.glob("*.blend")]:       # until the first fit is there
        assert process.poll() is None
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)       # as a terminal does it: its workers, too
    _, said = process.communicate(timeout=60)
    assert process.returncode == interrupts.CANCELLED
    assert said.decode().splitlines()[-1] == "cancelled"
    assert b"Traceback" not in said
