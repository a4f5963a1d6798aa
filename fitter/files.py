"""Reading and writing files without ever leaving, or accepting, one that is half written."""

import errno
import os
import platform
import re
import secrets
import stat
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from .errors import DatasetError

_INTERVAL = 0.1             # s, between two attempts to lock on Windows, which cannot wait for a lock
_ATTEMPTS = 20              # to open a lock file that others make and remove
_HOLDER = re.compile(r"process \d+ on [^\r\n]*")      # what a lock file says
_LONGEST_HOLDER = 300
_NOT_FOLLOWED = getattr(os, "O_NOFOLLOW", 0)        # Windows lets few make links


def read_bytes(path: str | Path, largest: int) -> bytes:
    """Read a regular file whole.

    Raises DatasetError if it is not a regular file, cannot be read, has more than `largest` bytes, or changes while it
    is read.
    """
    if not str(path):
        raise DatasetError("no file is named: the path is empty")
    path = Path(path)
    try:
        if path.is_dir():
            raise DatasetError("a folder, not a file", path)
        with open(path, "rb", opener=_open_without_waiting) as stream:
            before = os.fstat(stream.fileno())
            if not stat.S_ISREG(before.st_mode):
                raise DatasetError("not a file", path)
            if before.st_size > largest:
                raise DatasetError(f"{before.st_size:,} bytes, expected at most {largest:,}", path)
            content = stream.read(before.st_size + 1)
            after = os.fstat(stream.fileno())
    except (OSError, ValueError) as error:
        if isinstance(error, DatasetError):
            raise
        raise DatasetError(f"cannot be read: {getattr(error, 'strerror', None) or error}", path) from error
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns) or len(content) != after.st_size:
        raise DatasetError("has changed while it was read; try again once it is whole", path)
    return content


def time_and_size(path: str | Path) -> tuple[int, int] | None:
    """When a file was changed (ns), and its bytes: another pair means another content. None if there is no file."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_mtime_ns, status.st_size


def _open_without_waiting(path: str, flags: int) -> int:
    """Open a file; a pipe too, without waiting for its writer. An `opener` for `open`."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def real(path: str | Path) -> Path:
    """The absolute path that links lead to. Where they lead in a circle, an OSError follows when it is opened."""
    return Path(os.path.realpath(path))


@contextmanager
def replacing(path: str | Path, mode: str = "wb") -> Iterator[IO[Any]]:
    """Write a new file and put it in the place of `path` once it is complete; on an error `path` stays as it was.

    A link is followed: the file that it names is replaced.

    Raises OSError if the file cannot be written, or `path` is something else than a file; `filename` is the path.

    Parameters
    ----------
    mode : {"wb", "w"}
        Bytes, or text in UTF-8.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with replacing(folder / "notes.txt", "w") as stream:
    ...     _ = stream.write("complete")
    >>> with suppress(RuntimeError), replacing(folder / "notes.txt", "w") as stream:
    ...     _ = stream.write("half of")
    ...     raise RuntimeError
    >>> (folder / "notes.txt").read_text(), len(list(folder.iterdir()))
    ('complete', 1)
    """
    path = real(path)
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "not a file that can be replaced", str(path))
    beside = path.with_name(f"{path.name}.{secrets.token_hex(4)}.part")
    try:
        # exclusive: if another process has just taken the same name, its file stays
        stream = open(beside, mode.replace("w", "x"), encoding=None if "b" in mode else "utf-8",    # noqa: SIM115
                      newline=None if "b" in mode else "\n")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        with stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(beside, path)
    except BaseException as error:
        beside.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename in (None, str(beside)):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise


@contextmanager
def locked(path: str | Path, wait: bool = False) -> Iterator[None]:
    """Hold the lock of a file: of all processes that ask for it, one at a time has it.

    The operating system locks a file beside it, `path` with ".lock", and unlocks it when the process ends, even if it
    crashes.

    Raises BlockingIOError if another process has the lock; the message names that process; and FileExistsError if
    something else has the name of the lock file.

    Parameters
    ----------
    path : path-like
        The file need not exist; its folder must.
    wait : bool
        Wait for the lock, instead of raising an error.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "library.blend"
    >>> with locked(path):
    ...     path.with_name("library.blend.lock").exists()
    True
    """
    path = real(path)
    beside = path.with_name(path.name + ".lock")
    while True:
        stream = _lock_file(beside)
        try:
            _lock(stream, wait)
        except BlockingIOError:
            stream.seek(0)
            holder = stream.read(_LONGEST_HOLDER).strip()
            stream.close()
            raise BlockingIOError(errno.EWOULDBLOCK, f"another process is writing it{holder and f' ({holder})'}; try "
                                  "again when it is done", str(path)) from None
        if _is_still(beside, stream):
            break
        stream.close()                      # the last holder has removed this lock file: make a new one
    try:
        stream.seek(0)
        stream.truncate()
        stream.write(f"process {os.getpid()} on {platform.node()}")
        stream.flush()
        yield
    finally:
        with suppress(OSError):             # Windows cannot remove an open file: the lock file stays
            if _is_still(beside, stream):
                beside.unlink()
        stream.close()


def _lock_file(path: Path) -> IO[str]:
    """Open a new lock file, or one that a process has left; never a link, nor anything else.

    Raises FileExistsError if something else has its name.
    """
    for _ in range(_ATTEMPTS):
        with suppress(FileExistsError):
            return os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666), "r+", encoding="utf-8")
        with suppress(FileNotFoundError):   # removed meanwhile
            before = os.lstat(path)
            if not stat.S_ISREG(before.st_mode) or before.st_nlink != 1:
                break
            stream = os.fdopen(os.open(path, os.O_RDWR | _NOT_FOLLOWED), "r+", encoding="utf-8", errors="replace")
            if os.path.samestat(before, os.fstat(stream.fileno())):
                text = stream.read(_LONGEST_HOLDER)
                if _HOLDER.fullmatch(text):
                    return stream
                if text:
                    stream.close()
                    break
            stream.close()
        time.sleep(_INTERVAL)               # its maker has not written into it yet
    raise FileExistsError(errno.EEXIST, "not a lock that Measured BRDF has left; move it away", str(path))


def _is_still(path: Path, stream: IO[str]) -> bool:
    """Whether an open file is the one of a path, and no link to it."""
    try:
        return os.path.samestat(os.lstat(path), os.fstat(stream.fileno()))
    except FileNotFoundError:
        return False


if sys.platform == "win32":
    import msvcrt

    _LOCKED_BYTE = 1 << 30

    def _lock(stream: IO[str], wait: bool) -> None:
        os.lseek(stream.fileno(), _LOCKED_BYTE, os.SEEK_SET)      # beyond the text, which other processes may read
        while True:
            try:
                msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
                return
            except OSError as error:
                if not wait:
                    raise BlockingIOError from error
                time.sleep(_INTERVAL)
else:
    import fcntl

    # some network file systems have no locks: there, the user must keep writers apart
    _NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)

    def _lock(stream: IO[str], wait: bool) -> None:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise
