"""MBSDF files made for tests."""

import struct

import numpy as np

START = b'NVIDIA ARC MBSDF V1\ncreator="a test"\n'


def made(shape=(3, 3, 5, 3), block=b"MBSDF_DATA_REFLECTION=\n", values=None):
    """The bytes of a file; its values are 0, 1, 2 ..."""
    values = np.arange(np.prod(shape)) if values is None else values
    return START + block + struct.pack("<3I", int(shape[3] == 3), *shape[1:3]) + values.astype("<f4").tobytes()
