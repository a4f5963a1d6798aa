"""Reading and writing files without ever leaving, or accepting, one that is half written."""

import errno
import hashlib
import json
import os
import platform
import re
import secrets
import shutil
import stat
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PureWindowsPath
from typing import IO, Any

from ..errors import DatasetError

_INTERVAL = 0.1             # s, between two attempts to lock on Windows, which cannot wait for a lock
_ATTEMPTS = 20              # to open a lock file that others make and remove
_HOLDER = re.compile(r"process \d+ on [^\r\n]*")      # what a lock file says
_LONGEST_HOLDER = 300
_PART = re.compile(r"(.*)\.[0-9a-f]{8}\.part", re.DOTALL)      # what `replace_file` writes first
_LONGEST_WRITING = 3600.0   # s: files are written in seconds
_RECORD = ".measured_brdf"  # the file in a folder that says what was written there
_LARGEST_RECORD = 1 << 20   # bytes
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
        # a pipe, too, without waiting for its writer
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as stream:
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


def real_path(path: str | Path) -> Path:
    """The absolute path that links lead to. Where they lead in a circle, an OSError follows when it is opened."""
    return Path(os.path.realpath(path))


def strip_folders(source: str) -> str:
    r"""The name of a file of which there is a path, of this system or of another one: what may be handed on.

    Examples
    --------
    >>> strip_folders("/home/ann/scan.csv"), strip_folders("C:\\ann\\scan.csv"), strip_folders("published:gold")
    ('scan.csv', 'scan.csv', 'published:gold')
    """
    return PureWindowsPath(source).name


@contextmanager
def replace_file(path: str | Path, mode: str = "wb") -> Iterator[IO[Any]]:
    """Write a new file, of bytes or of text in UTF-8, and put it in the place of `path` once it is complete; on an
    error `path` stays as it was.

    A link is followed: the file that it names is replaced. What a process has left that was killed while it wrote the
    same file is removed.

    Raises OSError if the file cannot be written, or `path` is something else than a file; `filename` is the path.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with replace_file(folder / "notes.txt", "w") as stream:
    ...     _ = stream.write("complete")
    >>> with suppress(RuntimeError), replace_file(folder / "notes.txt", "w") as stream:
    ...     _ = stream.write("half of")
    ...     raise RuntimeError
    >>> (folder / "notes.txt").read_text(), len(list(folder.iterdir()))
    ('complete', 1)
    """
    path = real_path(path)
    if path.exists() and not path.is_file():
        raise OSError(errno.EINVAL, "not a file that can be replaced", str(path))
    beside = path.with_name(f"{path.name}.{secrets.token_hex(4)}.part")
    remove_stale_parts(path.parent, path.name, _LONGEST_WRITING)
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


def remove_stale_parts(folder: Path, name: str | None = None, age: float = 0.0) -> None:
    """Remove what `replace_file` has left in a folder where its process was killed, of the file of this name or of all.

    What is not so many seconds old may be written just now.
    """
    with suppress(OSError):
        for entry in list(os.scandir(folder)):
            found = _PART.fullmatch(entry.name)
            if found and name in (None, found[1]) and entry.is_file(follow_symlinks=False) and (
                    time.time() - entry.stat().st_mtime >= age):
                os.unlink(entry.path)


@contextmanager
def replace_folder(folder: Path) -> Iterator[Path]:
    """Write new files into a folder that this yields, and put them into another one, which is made, once they are
    complete; on an error that stays as it was.

    Files of an earlier time that are not among the new ones are removed, where nobody has changed them since: a hidden
    file keeps their names and digests. One process at a time does this, and removes what others have left that were
    killed.

    Raises OSError if they cannot be written; `filename` is the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    record, beside = folder / _RECORD, folder / f"{_RECORD}.part"
    with hold_lock(beside, wait=True):
        if os.path.lexists(beside):
            shutil.rmtree(beside)
        beside.mkdir()
        try:
            yield beside
            digests = {path.name: _digest(path) for path in beside.iterdir()}
            for name in digests:
                os.replace(beside / name, folder / name)
            for name, digest in _read_record(record).items():
                if name not in digests and Path(name).name == name and _digest(folder / name) == digest:
                    (folder / name).unlink()
            with replace_file(record, "w") as stream:
                json.dump(digests, stream)
        except OSError as error:
            raise OSError(error.errno, error.strerror or str(error), str(folder)) from error
        finally:
            shutil.rmtree(beside, ignore_errors=True)


def others_files(folder: Path, names: re.Pattern[str]) -> list[str]:
    """The files of such names in a folder that `replace_folder` has not written, or that were changed since."""
    written = _read_record(folder / _RECORD)
    return sorted(each.name for each in (folder.iterdir() if folder.is_dir() else ())
                  if names.fullmatch(each.name) and _digest(each) != written.get(each.name))


def check_not_read(path: str | Path, inputs: Iterable[str | Path]) -> None:
    """Raise DatasetError if a file that is to be written is one of those that are read."""
    if real_path(path) in map(real_path, inputs):
        raise DatasetError("is read, and would be replaced by what is made of it; choose another name to write", path)


def _digest(path: Path) -> str:
    """SHA-256 of a file; of anything else ""."""
    if path.is_symlink() or not path.is_file():
        return ""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _read_record(path: Path) -> dict[str, str]:
    """The names and digests in a file of them; empty where it is none."""
    with suppress(DatasetError, ValueError, RecursionError):
        found = json.loads(read_bytes(path, _LARGEST_RECORD))
        if isinstance(found, dict):
            return {name: digest for name, digest in found.items() if isinstance(digest, str) and digest}
    return {}


@contextmanager
def hold_lock(path: str | Path, wait: bool = False) -> Iterator[None]:
    """Hold the lock of a file, which need not exist: of all processes that ask for it, one at a time has it, and others
    wait or raise.

    The operating system locks a file beside it, `path` with ".lock", and unlocks it when the process ends, even if it
    crashes.

    Raises BlockingIOError if another process has the lock; the message names that process; and FileExistsError if
    something else has the name of the lock file.
    """
    path = real_path(path)
    beside = path.with_name(path.name + ".lock")
    # the lock of a file that is still in its place
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
    # say who holds it, for the message of others
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
