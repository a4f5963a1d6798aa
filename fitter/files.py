"""Files that are either whole or not there."""

import errno
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path


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


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
