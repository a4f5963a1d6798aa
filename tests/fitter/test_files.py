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
