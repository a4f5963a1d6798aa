"""Reading real arrays from MATLAB 5 files (docs/layouts.md, Cornell's house paint).

At most a few times the file's size is inflated and converted, so that a small file cannot fill the memory.
"""

import struct
import zlib
from collections.abc import Collection, Iterator

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError

MAT_MAGIC = b"MATLAB 5.0 MAT-file"
_MAT_HEADER = 128
_MATRIX_TYPE, _COMPRESSED_TYPE = 14, 15
_MAT_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_NUMERIC = range(6, 16)     # mxDOUBLE_CLASS to mxUINT64_CLASS
_COMPLEX = 0x800
_MATRIX_PARTS = 6, 5, 1     # a matrix begins with flags (uint32), dimensions (int32) and name (int8)
_GROWTH, _FREE = 3, 1 << 20     # most bytes inflated: times the file's size, plus; measured data deflate to about half


def read(content: bytes, names: Collection[str]) -> dict[str, FloatArray]:
    """Read the arrays with the given names, of two dimensions or more; those that the file does not have are missing.

    Raises DatasetError if the file is damaged, one of the arrays does not hold plain real numbers, or inflates too
    much.
    """
    allowance = _GROWTH * len(content) + _FREE
    arrays: dict[str, FloatArray] = {}
    try:
        order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
        if order is None:
            raise ValueError("no mark of the byte order")
        for kind, data in _elements(memoryview(content)[_MAT_HEADER:], order):
            if kind == _COMPRESSED_TYPE:
                inflater = zlib.decompressobj()
                inflated = inflater.decompress(data, max(allowance, 1))
                if not inflater.eof:
                    raise ValueError("it ends early, or inflates to more than a file of this size should")
                allowance -= len(inflated)
                kind, data = next(_elements(memoryview(inflated), order))
            if kind == _MATRIX_TYPE:
                name, array = _matrix(data, order, names, allowance)
                if array is not None:
                    allowance -= array.nbytes
                    arrays[name] = array
    except (struct.error, zlib.error, ValueError) as error:
        raise DatasetError(f"a damaged MATLAB file ({error})") from error
    return arrays


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """The data elements of a file or of a matrix: (type, data). `order` is "<" or ">", the byte order."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        at += 8
        if kind >> 16:                          # small element: one word has type and size, the next the data
            kind, size, start, end = kind & 0xFFFF, kind >> 16, at - 4, at
        else:
            start, end = at, at + size if kind == _COMPRESSED_TYPE else at + -(-size // 8) * 8
        if size > len(data) - start:
            raise ValueError("it ends early")
        yield kind, data[start:start + size]
        at = end


def _matrix(data: memoryview, order: str, names: Collection[str], allowance: int) -> tuple[str, FloatArray | None]:
    """The name of a matrix, and its numbers if it is one of `names`."""
    parts = _elements(data, order)
    missing = 0, memoryview(b"")
    kinds, (flags, dimensions, name_bytes) = zip(*(next(parts, missing) for _ in range(3)), strict=True)
    if kinds != _MATRIX_PARTS:
        raise ValueError("a matrix without flags, dimensions and name")
    name = bytes(name_bytes).decode("latin-1")
    if name not in names:
        return name, None
    flag, = struct.unpack_from(order + "I", flags)
    kind, real_part = next(parts, missing)
    if flag & 0xFF not in _NUMERIC or flag & _COMPLEX or kind not in _MAT_TYPES:
        raise ValueError(f"{name} is not a plain array of real numbers")
    shape = np.frombuffer(dimensions, order + "i4").tolist()
    values = np.frombuffer(real_part, order + _MAT_TYPES[kind])
    if 8 * values.size > allowance:
        raise ValueError(f"{name} holds more numbers than a file of this size should")
    if len(shape) < 2 or min(shape) < 0 or np.prod(shape, dtype=object) != values.size:
        raise ValueError(f"{name} has {values.size} numbers for the shape {tuple(shape)}")
    return name, values.astype("f8").reshape(shape, order="F")
