"""Files are written beside and renamed, and no other thread notices."""

import os
import stat
import sys

import pytest

from fitter.files import replacing


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
