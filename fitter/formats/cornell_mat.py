"""Cornell's measurements of a house paint, paint.reformat.mat: four arrays of a MATLAB 5 file, any of which may be
transposed (docs/layouts.md, Cornell's house paint).

At most a few times the file's size is inflated and converted, so that a small file cannot fill the memory.
"""


import struct
import zlib
from collections.abc import Collection, Iterator

import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import RGB, Samples
from .format import Format
from .reading import BY_DEFAULT, Reading
from .spectra import to_linear_srgb

_MAT_MAGIC = b"MATLAB 5.0 MAT-file"
_MAT_HEADER = 128
_MATRIX_TYPE, _COMPRESSED_TYPE = 14, 15
_MAT_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_NUMERIC = range(6, 16)     # mxDOUBLE_CLASS to mxUINT64_CLASS
_COMPLEX = 0x800
_MATRIX_PARTS = 6, 5, 1     # a matrix begins with flags (uint32), dimensions (int32) and name (int8)
_GROWTH, _FREE = 3, 1 << 20     # most bytes inflated: times the file's size, plus; measured data deflate to about half
_ARRAYS = ("dir_in", "dir_out", "fr", "wavelength")


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read the paint file; spectra become linear sRGB."""
    arrays = _read_arrays(content, _ARRAYS)
    missing = [name for name in _ARRAYS if name not in arrays]
    if missing:
        raise DatasetError(f"no array {', '.join(missing)}; expected {', '.join(_ARRAYS)}")
    wavelength = arrays["wavelength"].ravel()
    fr = _orient(arrays["fr"], len(wavelength), "fr")
    theta_i, phi_i = _angles(arrays["dir_in"], len(fr), "dir_in")
    theta_o, phi_o = _angles(arrays["dir_out"], len(fr), "dir_out")
    if not np.isfinite(fr).all():
        raise DatasetError("fr holds numbers that are not finite")
    values = to_linear_srgb(wavelength, fr, illuminant=reading.illuminant)
    return Samples(theta_i, phi_i, theta_o, phi_o, values, RGB, "", notes=reading.notes)


def _orient(array: FloatArray, columns: int, name: str) -> FloatArray:
    """A matrix with the given number of columns, transposed if necessary."""
    if array.ndim == 2 and array.shape[1] == columns:
        return array
    if array.ndim == 2 and array.shape[0] == columns:
        return array.T
    raise DatasetError(f"{name} has the shape {array.shape}, expected {columns} columns")


def _angles(vectors: FloatArray, count: int, name: str) -> tuple[FloatArray, FloatArray]:
    """The polar angles and azimuths of vectors, radians: (count,) each."""
    vectors = _orient(vectors, 3, name)
    if len(vectors) != count:
        raise DatasetError(f"{name} has {len(vectors)} vectors, expected {count} as in fr")
    length = np.linalg.norm(vectors, axis=1)
    if not np.isfinite(length).all() or not length.all():
        raise DatasetError(f"{name} holds a vector that is not a direction")
    x, y, z = (vectors / length[:, None]).T
    return np.arccos(np.clip(z, -1, 1)), np.arctan2(y, x)


def _read_arrays(content: bytes, names: Collection[str]) -> dict[str, FloatArray]:
    """The arrays of a MATLAB 5 file with the given names, of two dimensions or more, as far as they are there."""
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


FORMAT = Format("Cornell", "Cornell paint.reformat.mat", (".mat",),
                lambda content: content.startswith(_MAT_MAGIC), read, ("illuminant",), is_text=False)
