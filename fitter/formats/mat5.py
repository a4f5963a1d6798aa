"""Real arrays from MATLAB 5 files, the format of MATLAB's `save` up to version 7.

The MathWorks: MAT-File Format, chapter 1. A file is a header of 128 bytes and data elements, each a tag (type, bytes)
and data padded to 8 bytes; a matrix is an element of elements: flags, dimensions, name, real part. No more is inflated
or converted than a few times the file's own size.
"""

import struct
import zlib

import numpy as np

from ..errors import DatasetError

MAGIC = b"MATLAB 5.0 MAT-file"
_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_NUMERIC = range(6, 16)     # mxDOUBLE_CLASS to mxUINT64_CLASS
_COMPLEX = 0x800
_PARTS = 6, 5, 1            # a matrix begins with flags (uint32), dimensions (int32) and name (int8)
_GROWTH, _FREE = 3, 1 << 20     # measured numbers deflate to a half or so


def read(content, path, names):
    """The arrays of these names.

    Returns
    -------
    {name: array}
        float64, of two dimensions or more; names that are not in the file are missing.

    Raises
    ------
    DatasetError
        If the file is damaged, one of the arrays is not plain real numbers, or they are more than its size allows.
    """
    try:
        return _arrays(content, names)
    except (struct.error, zlib.error, ValueError) as error:
        raise DatasetError(f"a damaged MATLAB file ({error})", path) from error


def _arrays(content, names):
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        raise ValueError("no mark of the byte order")
    allowance = _GROWTH * len(content) + _FREE
    arrays = {}
    for kind, data in _elements(memoryview(content)[_HEADER:], order):
        if kind == _COMPRESSED:
            inflated = _inflate(data, allowance)
            allowance -= len(inflated)
            kind, data = next(_elements(memoryview(inflated), order))
        if kind == _MATRIX:
            name, array = _matrix(data, order, names, allowance)
            if array is not None:
                allowance -= array.nbytes
                arrays[name] = array
    return arrays


def _elements(data, order):
    """The data elements of a file or of a matrix: (type, data)."""
    at = 0
    while at < len(data):
        kind, size = struct.unpack_from(order + "II", data, at)
        at += 8
        if kind >> 16:                          # small: type and size share one word, the data is the other
            kind, size, start, end = kind & 0xFFFF, kind >> 16, at - 4, at
        else:
            start, end = at, at + size if kind == _COMPRESSED else at + -(-size // 8) * 8
        if size > len(data) - start:
            raise ValueError("it ends early")
        yield kind, data[start:start + size]
        at = end


def _inflate(data, allowance):
    inflater = zlib.decompressobj()
    inflated = inflater.decompress(data, max(allowance, 1))
    if not inflater.eof:
        raise ValueError("it ends early, or inflates beyond measure")
    return inflated


def _matrix(data, order, names, allowance):
    """The name of a matrix, and its numbers where it is one of `names`, else None."""
    parts = _elements(data, order)
    kinds, (flags, dimensions, name) = zip(*(next(parts, (0, b"")) for _ in range(3)), strict=True)
    if kinds != _PARTS:
        raise ValueError("a matrix without flags, dimensions and name")
    name = bytes(name).decode("latin-1")
    if name not in names:
        return name, None
    flags, = struct.unpack_from(order + "I", flags)
    kind, values = next(parts, (0, b""))
    if flags & 0xFF not in _NUMERIC or flags & _COMPLEX or kind not in _TYPES:
        raise ValueError(f"{name} is not a plain array of real numbers")
    shape = np.frombuffer(dimensions, order + "i4").tolist()
    values = np.frombuffer(values, order + _TYPES[kind])
    if 8 * values.size > allowance:
        raise ValueError(f"{name} holds more numbers than a file of this size should")
    if len(shape) < 2 or min(shape) < 0 or np.prod(shape, dtype=object) != values.size:
        raise ValueError(f"{name} has {values.size} numbers for the shape {tuple(shape)}")
    return name, values.astype("f8").reshape(shape, order="F")
