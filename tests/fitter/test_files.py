"""Files are written beside and renamed, no other thread notices, and what cannot be written is an OSError."""

import os
import stat
import sys

import pytest

from fitter.files import locked, replacing


@pytest.fixture
def loop(tmp_path):
    """A link to itself."""
    path = tmp_path / "loop"
    try:
        path.symlink_to(path)
    except OSError:
        pytest.skip("this system lets nobody make links")
    return path


@pytest.mark.parametrize("write", [replacing, locked])
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
            with replacing(tmp_path / "fit.npz") as stream:
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
          locked(tmp_path / "library.blend")):
        raise AssertionError
    assert raised.value.filename == str(lock)
    assert thesis.read_text() == "Ten years of work."
    assert os.path.samestat(os.lstat(lock), before)
    assert os.lstat(lock).st_size == before.st_size
    assert not (tmp_path / "nowhere").exists()


def test_a_lock_file_that_a_killed_process_has_left_is_taken_and_goes(tmp_path):
    lock = tmp_path / "library.blend.lock"
    lock.write_text("process 123456789 on a-machine-with-a-long-name, and more of it")
    with locked(tmp_path / "library.blend"):
        assert lock.read_text().startswith(f"process {os.getpid()} on ")
        assert "and more of it" not in lock.read_text()
    assert not lock.exists()


def test_a_lock_file_that_was_replaced_meanwhile_stays(tmp_path):
    lock = tmp_path / "library.blend.lock"
    with locked(tmp_path / "library.blend"):
        lock.unlink()
        lock.write_text("another's")
    assert lock.read_text() == "another's"
