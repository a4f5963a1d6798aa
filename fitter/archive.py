"""Arrays from .npz files that may be damaged or hostile.

`numpy.load` takes an array's word for its size and type. Here no array is read that claims to be of anything but plain
numbers or text, and no more is inflated than `LARGEST`.
"""

import io
import math
import zipfile
import zlib

import numpy as np

LARGEST = 256 << 20         # bytes; a dense lattice of level 8 in three channels has 53 MB
_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_PLAIN = "iufU"


def read(content):
    """The arrays of an .npz file: bytes to {name: array}.

    Raises
    ------
    ValueError
        If it is damaged, or anything else than an archive of plain arrays.
    """
    arrays, allowance = {}, LARGEST
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as file:
            for member in file.infolist():
                name = member.filename.removesuffix(".npy")
                if name in arrays:
                    raise ValueError(f"{name} is there twice")
                with file.open(member) as stream:
                    arrays[name] = _array(stream, name, allowance)
                allowance -= arrays[name].nbytes
    except (KeyError, TypeError, EOFError, RuntimeError, SyntaxError, OverflowError, zipfile.BadZipFile, zlib.error,
            OSError) as error:      # NotImplementedError and RecursionError are RuntimeErrors
        raise ValueError(str(error)) from error
    return arrays


def _array(stream, name, allowance):
    shape, is_fortran, dtype = _HEADERS[np.lib.format.read_magic(stream)](stream)
    if dtype.kind not in _PLAIN or min(shape, default=0) < 0:
        raise ValueError(f"{name} is of {dtype} {shape}, expected plain numbers")
    size = math.prod(shape) * dtype.itemsize
    if size > allowance:
        raise ValueError(f"{name} claims {size:,} bytes, more than a fit has")
    data = stream.read(size)
    if len(data) != size or stream.read(1):
        raise ValueError(f"{name} is shorter or longer than it says")
    return np.frombuffer(data, dtype).reshape(shape, order="F" if is_fortran else "C")
