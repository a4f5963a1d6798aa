"""Files that are either whole or not there."""

import errno
import os
import platform
import stat
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path

from .errors import DatasetError

_INTERVAL = 0.1             # s, between two attempts where the system cannot wait for a lock


def read_bytes(path, largest):
    """The content of a regular file that nobody writes meanwhile.

    Raises
    ------
    DatasetError
        If it is no such file, cannot be read, or has more than `largest` bytes.
    """
    path = Path(path)
    try:
        if path.is_dir():
            raise DatasetError("a folder, not a file", path)
        with open(path, "rb", opener=_open_at_once) as stream:
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


def _open_at_once(path, flags):
    """Open a pipe without waiting for its writer."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextmanager
def replacing(path, mode="wb"):
    """Open a file beside `path` and rename it to `path` once all is written; on an error leave `path` as it was."""
    path = Path(path).resolve()             # through a link, to what it names
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "not a file that can be replaced", str(path))
    try:
        descriptor, beside = tempfile.mkstemp(dir=path.parent, prefix=path.name + ".", suffix=".part")
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        with os.fdopen(descriptor, mode, **({} if "b" in mode else {"encoding": "utf-8", "newline": "\n"})) as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(beside, 0o666 & ~_umask())
        os.replace(beside, path)
    except BaseException as error:
        Path(beside).unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename in (None, beside):
            raise OSError(error.errno, error.strerror or str(error), str(path)) from error
        raise


@contextmanager
def locked(path, wait=False):
    """Be the only one, of all processes that ask, who writes a file.

    A file beside it, `path` with ".lock", is locked by the operating system, which unlocks it when the process ends,
    however it ends.

    Parameters
    ----------
    path : path-like
        It need not exist; its folder does.
    wait : bool
        Wait until whoever has the lock is done, instead of raising an error.

    Raises
    ------
    BlockingIOError
        If another process has the lock; the message names it.
    """
    path = Path(path).resolve()
    beside = path.with_name(path.name + ".lock")
    while True:
        stream = open(beside, "a+", encoding="utf-8")       # noqa: SIM115 - closed by whoever ends the lock
        try:
            _lock(stream, wait)
        except BlockingIOError:
            stream.seek(0)
            holder = stream.read().strip()
            stream.close()
            raise BlockingIOError(errno.EWOULDBLOCK, f"another process is writing it{holder and f' ({holder})'}; try "
                                  "again when it is done", str(path)) from None
        if beside.exists() and os.path.samestat(os.stat(beside), os.fstat(stream.fileno())):
            break
        stream.close()                      # whoever had the lock has removed the file meanwhile
    try:
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {platform.node()}")
        stream.flush()
        yield
    finally:
        with suppress(OSError):             # Windows does not remove an open file: an empty one stays
            beside.unlink()
        stream.close()


if os.name == "nt":
    import msvcrt

    _LOCKED_BYTE = 1 << 30

    def _lock(stream, wait):
        os.lseek(stream.fileno(), _LOCKED_BYTE, os.SEEK_SET)      # far from the text, which others may read
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

    # some network file systems have none: there, writers must be kept apart in another way
    _NO_LOCKS = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP)

    def _lock(stream, wait):
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
