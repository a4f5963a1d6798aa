"""Writing .npz files, and reading those that may be damaged or hostile.

`numpy.load` trusts a file's directory, and the header, size and type of its arrays. This reader accepts only what
`numpy.savez` writes for arrays of plain numbers or text, compares every size with `LARGEST_ARCHIVE` before it allocates
memory, and inflates an array directly into its final place.
"""

import io
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Mapping
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

LARGEST_ARCHIVE = 256 << 20         # bytes of all arrays; a dense lattice of level 8 in three channels has 53 MB
_MOST_MEMBERS = 32
_END = struct.Struct("<4s4H2LH")        # the end of the central directory, in a file without a comment
_ENTRY = 46 + 64                        # largest size of a member's entry in the directory, bytes, its name included
_LOCATOR = 20                           # size of the record before the end that zip64 has, bytes
_ENTRY_NAME = re.compile(r"([a-z][a-z0-9_]{0,31})\.npy")
_MAGIC = b"\x93NUMPY\1\0"
_LONGEST_HEADER = 512
# what `numpy.savez` writes of plain numbers and text; NumPy's own reader parses it as Python source, with all of its
# errors
_HEADER = re.compile(rb"\{'descr': '([<>|][iufU]\d{1,6})', 'fortran_order': (True|False), "
                     rb"'shape': \(((?:\d+, ?)*(?:\d+)?)\),? ?\} *\n?")
_LONGEST_TEXT = 1 << 20     # bytes, four for a character
_PIECE = 1 << 18


def to_bytes(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays as an .npz file, compressed; unlike those of `numpy.savez_compressed`, equal arrays have equal files."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, array in arrays.items():
            member, entry = io.BytesIO(), zipfile.ZipInfo(f"{name}.npy")        # without the time of its making
            entry.compress_type = zipfile.ZIP_DEFLATED
            np.lib.format.write_array(member, array, (1, 0), allow_pickle=False)
            file.writestr(entry, member.getbuffer())
    return content.getvalue()


def read(content: bytes, largest: int = LARGEST_ARCHIVE) -> dict[str, NDArray[Any]]:
    """The arrays of an .npz file, by name; they are read-only.

    Raises ValueError if the file is damaged, or is no archive of plain arrays, in all of `largest` bytes at most.
    """
    _check_directory(content)
    arrays: dict[str, NDArray[Any]] = {}
    allowance = largest
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as file:
            if sum(member.file_size for member in file.infolist()) > largest:
                raise ValueError(f"its arrays claim more than {largest:,} bytes, more than there may be")
            for member in file.infolist():
                name = _name(member)
                if name in arrays:
                    raise ValueError(f"{name} is there twice")
                with file.open(member) as stream:
                    arrays[name] = _array(stream, name, member.file_size, allowance)
                allowance -= arrays[name].nbytes
    except (KeyError, TypeError, EOFError, RuntimeError, OverflowError, zipfile.BadZipFile, zlib.error,
            OSError) as error:      # NotImplementedError is a RuntimeError
        raise ValueError(str(error)) from error
    return arrays


def _check_directory(content: bytes) -> None:
    """Refuse a directory that `numpy.savez` would not write: `zipfile` would read whatever it says."""
    start = len(content) - _END.size
    if start < 0 or content[start:start + 4] != b"PK\5\6":
        raise ValueError("no archive, or one that does not end with its directory")
    _, *disks, here, members, size, offset, comment = _END.unpack(content[start:])
    if any(disks) or comment or here != members or content.startswith(b"PK\6\7", max(start - _LOCATOR, 0)):
        raise ValueError("an archive in parts, with a comment, or in zip64")
    if members > _MOST_MEMBERS or size > members * _ENTRY or offset + size != start:
        raise ValueError(f"a directory of {size:,} bytes for {members:,} members, more than there may be")


def _name(member: zipfile.ZipInfo) -> str:
    name = _ENTRY_NAME.fullmatch(member.filename)
    if name is None:
        raise ValueError(f"a member {member.filename[:40]!r}, expected the name of an array")
    if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name[1]} is compressed by method {member.compress_type}, expected deflation")
    return name[1]


def _array(stream: IO[bytes], name: str, stated: int, allowance: int) -> NDArray[Any]:
    """The array of a member whose directory entry states its size, in bytes."""
    start = stream.read(len(_MAGIC) + 2)
    length = int.from_bytes(start[len(_MAGIC):], "little")
    if not start.startswith(_MAGIC) or length > _LONGEST_HEADER:
        raise ValueError(f"{name} begins with {start!r}, expected a short header of version 1.0")
    text = stream.read(length)
    header = _HEADER.fullmatch(text)
    if header is None:
        raise ValueError(f"{name} is described by {text[:80]!r}, expected plain numbers")
    dtype, shape = np.dtype(header[1].decode()), tuple(int(size) for size in header[3].split(b",") if size.strip())
    size = math.prod(shape) * dtype.itemsize
    if size > (min(allowance, _LONGEST_TEXT) if dtype.kind == "U" else allowance):
        raise ValueError(f"{name} claims {size:,} bytes, more than there may be")
    if len(start) + length + size != stated:
        raise ValueError(f"{name} is shorter or longer than it says")
    data = bytearray(size)
    view = memoryview(data)
    count = sum(stream.readinto(view[place:place + _PIECE])     # type: ignore[attr-defined] # a ZipExtFile has it
                for place in range(0, size, _PIECE))
    if count != size or stream.read(1):
        raise ValueError(f"{name} is shorter or longer than it says")
    array = np.frombuffer(data, dtype).reshape(shape, order="F" if header[2] == b"True" else "C")
    array.flags.writeable = False
    return array
