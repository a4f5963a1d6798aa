"""Files are written beside and renamed, no other thread notices, and what cannot be written is an OSError."""

import contextlib
import hashlib
import os
import stat
import subprocess
import sys
import time

import pytest

from fitter.storage.files import hold_lock, remove_stale_parts, replace_file, replace_folder
from support.checkout import ROOT


@pytest.fixture
def loop(tmp_path):
    """A link to itself."""
    path = tmp_path / "loop"
    try:
        path.symlink_to(path)
    except OSError:
        pytest.skip("this system lets nobody make links")
    return path


@pytest.mark.parametrize("write", [replace_file, hold_lock])
def test_a_loop_of_links_in_the_path_is_an_error_of_the_system(loop, write):
    with pytest.raises(OSError, match="loop"), write(loop / "fit.npz"):
        raise AssertionError


@pytest.mark.skipif(sys.platform == "win32", reason="modes of POSIX")
@pytest.mark.parametrize(("umask", "mode"), [(0o022, 0o644), (0o077, 0o600)])
def test_a_new_file_has_the_mode_of_the_process_whose_umask_no_moment_changes(tmp_path, monkeypatch, umask, mode):
    before = os.umask(umask)
    try:
        with monkeypatch.context() as patched:
            patched.delattr(os, "umask")
            with replace_file(tmp_path / "fit.npz") as stream:
                stream.write(b"complete")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "fit.npz").stat().st_mode) == mode
    assert [path.name for path in tmp_path.iterdir()] == ["fit.npz"]


@pytest.mark.skipif(sys.platform == "win32", reason="links")
@pytest.mark.parametrize("occupy", [
    lambda lock, thesis: lock.symlink_to(thesis), lambda lock, thesis: os.link(thesis, lock),
    lambda lock, thesis: lock.write_bytes(thesis.read_bytes()), lambda lock, thesis: os.mkfifo(lock),
    lambda lock, thesis: lock.mkdir(), lambda lock, thesis: lock.symlink_to(lock.with_name("nowhere"))],
    ids=["link", "second name", "file", "pipe", "folder", "broken link"])
def test_what_has_the_name_of_the_lock_file_is_neither_followed_nor_changed(tmp_path, occupy):
    thesis = tmp_path / "thesis.txt"
    thesis.write_text("Ten years of work.")
    lock = tmp_path / "library.blend.lock"
    occupy(lock, thesis)
    before = os.lstat(lock)
    with (pytest.raises(FileExistsError, match="not a lock that Measured BRDF has left") as raised,
          hold_lock(tmp_path / "library.blend")):
        raise AssertionError
    assert raised.value.filename == str(lock)
    assert thesis.read_text() == "Ten years of work."
    assert os.path.samestat(os.lstat(lock), before)
    assert os.lstat(lock).st_size == before.st_size
    assert not (tmp_path / "nowhere").exists()


def test_a_lock_file_that_a_killed_process_has_left_is_taken_and_goes(tmp_path):
    lock = tmp_path / "library.blend.lock"
    lock.write_text("process 123456789 on a-machine-with-a-long-name, and more of it")
    with hold_lock(tmp_path / "library.blend"):
        assert lock.read_text().startswith(f"process {os.getpid()} on ")
        assert "and more of it" not in lock.read_text()
    assert not lock.exists()


def test_a_lock_file_that_was_replaced_meanwhile_stays(tmp_path):
    lock = tmp_path / "library.blend.lock"
    with hold_lock(tmp_path / "library.blend"):
        lock.unlink()
        lock.write_text("another's")
    assert lock.read_text() == "another's"


KILLED = """
import os, signal, sys
from pathlib import Path
from fitter.storage.files import replace_file, replace_folder
folder = Path(sys.argv[1])
with replace_folder(folder) as part, replace_file(folder / "fit.npz") as stream:
    (part / "mask.png").write_bytes(b"half")
    stream.write(b"half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def killed(tmp_path):
    """A folder into which a process wrote when it was killed."""
    subprocess.run([sys.executable, "-c", KILLED, tmp_path / "maps"], cwd=ROOT, check=False, timeout=60)
    assert len([path for path in (tmp_path / "maps").iterdir() if path.name.endswith(".part")]) == 2
    return tmp_path / "maps"


def write_together(folder, **files):
    with replace_folder(folder) as part:
        for name, content in files.items():
            (part / f"{name}.png").write_text(content)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_what_a_killed_process_has_left_goes_with_the_next_that_writes_there(killed):
    write_together(killed, mask="whole")
    assert (killed / "mask.png").read_text() == "whole"
    left, = killed.glob("*.part")
    with replace_file(killed / "fit.npz") as stream:
        stream.write(b"complete")
    assert left.exists(), "another process may be writing it"
    os.utime(left, (time.time() - 4000,) * 2)
    for other in ("fit.npz.part", "fit2.npz.0123abcd.part", "notes.part"):
        (killed / other).write_text("another's")
        os.utime(killed / other, (time.time() - 4000,) * 2)
    with replace_file(killed / "fit.npz") as stream:
        stream.write(b"complete")
    assert sorted(path.name for path in killed.iterdir()) == [
        ".measured_brdf", "fit.npz", "fit.npz.part", "fit2.npz.0123abcd.part", "mask.png", "notes.part"]
    remove_stale_parts(killed)
    assert sorted(path.name for path in killed.glob("*.part")) == ["fit.npz.part", "notes.part"]


def test_what_cannot_be_written_is_an_error_of_the_folder(tmp_path):
    (tmp_path / "one.png").mkdir()
    with pytest.raises(OSError, match="directory") as raised:
        write_together(tmp_path, one="1")
    assert raised.value.filename == str(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["one.png"]


def test_files_of_an_earlier_time_go_unless_somebody_has_changed_them(tmp_path):
    folder = tmp_path / "maps"
    write_together(folder, one="1", two="2", three="3", four="4")
    (folder / "two.png").write_text("painted over")
    (folder / "four.png").unlink()
    (folder / "mine.png").write_text("mine")
    write_together(folder, one="new")
    assert {path.name: path.read_text() for path in folder.glob("*.png")} == {
        "one.png": "new", "two.png": "painted over", "mine.png": "mine"}
    with contextlib.suppress(RuntimeError), replace_folder(folder) as part:
        (part / "one.png").write_text("half")
        raise RuntimeError
    assert (folder / "one.png").read_text() == "new"
    assert not [path for path in folder.iterdir() if "part" in path.name]


@pytest.mark.parametrize("record", ["nonsense", "[1]",
                                    '{"../mine.png": "DIGEST", "link.png": "DIGEST", "mine.png": 1}'])
def test_a_record_of_what_was_written_takes_nothing_out_of_other_folders(tmp_path, record):
    folder, digest = tmp_path / "maps", hashlib.sha256(b"mine").hexdigest()
    folder.mkdir()
    for place in (tmp_path, folder):
        (place / "mine.png").write_text("mine")
    (folder / "link.png").symlink_to(tmp_path / "mine.png")
    (folder / ".measured_brdf").write_text(record.replace("DIGEST", digest))
    write_together(folder, one="1")
    assert all(path.read_text() == "mine" for path in (tmp_path / "mine.png", folder / "mine.png", folder / "link.png"))
    assert digest not in (folder / ".measured_brdf").read_text()
