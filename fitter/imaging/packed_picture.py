"""A small picture of a lit sphere as text, which a material keeps: 128 pixels square in some 10 KB, as differences
along rows are compressed, and what the sphere covers is known."""

import base64
import zlib

import numpy as np

from ..arrays import SingleArray
from .pictures import sphere

SIZE = 128                  # pixels


def pack(picture: SingleArray) -> str:
    """A picture of a lit sphere, (SIZE, SIZE, 4) float32 as `pictures.lit_sphere` returns it, as text."""
    levels = np.round(255 * np.clip(picture[..., :3], 0, 1)).astype(np.uint8)
    differences = np.diff(levels, axis=1, prepend=np.uint8(0))
    return base64.b85encode(zlib.compress(differences.transpose(2, 0, 1).tobytes(), 9)).decode()


def unpack(text: str) -> SingleArray | None:
    """The picture in a text that `pack` made, (SIZE, SIZE, 4) float32; None for any other text."""
    unzip = zlib.decompressobj()
    try:
        content = unzip.decompress(base64.b85decode(text), 3 * SIZE ** 2)
    except (ValueError, zlib.error):
        return None
    if len(content) != 3 * SIZE ** 2:
        return None
    differences = np.frombuffer(content, np.uint8).reshape(3, SIZE, SIZE).transpose(1, 2, 0)
    colours = np.cumsum(differences, axis=1, dtype=np.uint8) / np.float32(255)
    return np.dstack([colours, sphere(SIZE)[2]]).astype(np.float32)
