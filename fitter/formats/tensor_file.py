"""Reading the container of RGL's files: named arrays of numbers (docs/layouts.md, RGL)."""

import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DatasetError
from .text import decode

TENSOR_MAGIC = b"tensor_file\0"
_TENSOR_VERSION = b"\1\0"
_TYPES = dict(enumerate(("<u1", "<i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f2", "<f4", "<f8"), 1))
_MOST_DIMENSIONS = 8


def read(content: bytes) -> dict[str, NDArray[Any]]:
    """Read the arrays, by name, of the type that the file has them in. They look into the content, so that nothing is
    copied, and are read-only. Raises DatasetError if the file is damaged.
    """
    start = len(TENSOR_MAGIC) + len(_TENSOR_VERSION)
    if content[:start] != TENSOR_MAGIC + _TENSOR_VERSION:
        raise DatasetError(f"tensor file of version {tuple(content[len(TENSOR_MAGIC):start])}, expected (1, 0)")
    arrays: dict[str, NDArray[Any]] = {}
    try:
        count, = struct.unpack_from("<I", content, start)
        at = start + 4
        for _ in range(count):
            size, = struct.unpack_from("<H", content, at)
            at += 2 + size
            name = decode(content[at - size:at])
            dimensions, kind, offset = struct.unpack_from("<HBQ", content, at)
            if dimensions > _MOST_DIMENSIONS:
                raise ValueError(f"{name!r:.40} has {dimensions} dimensions, expected at most {_MOST_DIMENSIONS}")
            shape = struct.unpack_from(f"<{dimensions}Q", content, at + 11)
            at += 11 + 8 * dimensions
            if name in arrays:
                raise ValueError(f"two arrays are named {name!r:.40}")
            arrays[name] = _array(content, name, kind, offset, shape)
    except struct.error as error:
        message = f"a damaged tensor file: {len(content):,} bytes end within the table of its arrays"
        raise DatasetError(message) from error
    except ValueError as error:
        raise DatasetError(f"a damaged tensor file: {error}") from error
    return arrays


def _array(content: bytes, name: str, kind: int, offset: int, shape: tuple[int, ...]) -> NDArray[Any]:
    if kind not in _TYPES:
        raise ValueError(f"{name!r:.40} is of the type {kind}, expected 1 to {len(_TYPES)}")
    size = math.prod(shape)
    end = offset + size * np.dtype(_TYPES[kind]).itemsize
    if end > len(content):
        raise ValueError(f"{name!r:.40} should end at byte {end:,}, and the file has {len(content):,}")
    return np.frombuffer(content, _TYPES[kind], size, offset).reshape(shape)
