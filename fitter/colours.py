"""Linear colour spaces: what red, green and blue mean, and the matrices between them.

Rec.709: ITU-R BT.709-6, 2015 (the primaries of sRGB). Rec.2020: ITU-R BT.2020-2, 2015. ACEScg: the primaries AP1 of
Academy S-2014-004, 2014. Matrices from chromaticities: SMPTE RP 177, 1993. Where whites differ, colours are adapted by
the Bradford transform: K. M. Lam: Metamerism and Colour Constancy, Ph.D. thesis, University of Bradford, 1985.
"""

from collections.abc import Sequence

import numpy as np

from .arrays import ArrayLike, FloatArray

_Chromaticity = tuple[float, float]

DEFAULT_COLOURS = "Rec.709"
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


# chromaticities (x, y) of red, green and blue, and of white
_SPACES: dict[str, tuple[Sequence[_Chromaticity], _Chromaticity]] = {
    "Rec.709": (((0.64, 0.33), (0.30, 0.60), (0.15, 0.06)), (0.3127, 0.3290)),
    "Rec.2020": (((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)), (0.3127, 0.3290)),
    "ACEScg": (((0.713, 0.293), (0.165, 0.830), (0.128, 0.044)), (0.32168, 0.33767))}
COLOURS = tuple(_SPACES)


def conversion(source: str, target: str) -> FloatArray:
    """The matrix from one of `COLOURS` to another: (3, 3). White stays white, since each row has the sum 1."""
    return np.eye(3) if source == target else conversion_from_primaries(*_SPACES[source], target)


def xyz_matrix(name: str) -> FloatArray:
    """The matrix from one of `COLOURS` to CIE XYZ relative to its own white, of which Y is 1: (3, 3)."""
    return matrix_from_primaries(*_SPACES[name])


def matrix_from_primaries(primaries: Sequence[_Chromaticity], white: _Chromaticity) -> FloatArray:
    """The matrix to CIE XYZ from the space of red, green and blue with these chromaticities, Y of white 1: (3, 3)."""
    columns = np.stack([_xyz(primary) for primary in primaries], axis=1)
    return np.asarray(columns * np.linalg.solve(columns, _xyz(white)))


def conversion_from_primaries(primaries: Sequence[_Chromaticity], white: _Chromaticity, target: str = DEFAULT_COLOURS,
                              ) -> FloatArray:
    """The matrix to one of `COLOURS` from the space with these chromaticities: (3, 3). White stays white."""
    whites = _xyz(white), _xyz(_SPACES[target][1])
    matrix = np.linalg.solve(xyz_matrix(target), adaptation(*whites) @ matrix_from_primaries(primaries, white))
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def decode_srgb(encoded: ArrayLike, threshold: float = 0.04045) -> FloatArray:
    """Linear values of those of sRGB (IEC 61966-2-1), of any shape; encoded ones up to a threshold are proportional.

    Examples
    --------
    >>> decode_srgb([0, 0.04, 0.5, 1]).round(4).tolist()
    [0.0, 0.0031, 0.214, 1.0]
    """
    encoded = np.asarray(encoded, dtype=float)
    return np.where(encoded > threshold, ((np.maximum(encoded, 0) + 0.055) / 1.055) ** 2.4, encoded / 12.92)


def luminance(values: FloatArray, name: str) -> FloatArray:
    """The luminance of colours in one of `COLOURS`: (n, 3) to (n,), 1 for white."""
    return np.asarray(values @ xyz_matrix(name)[1])


def adaptation(white: ArrayLike, other: ArrayLike) -> FloatArray:
    """The matrix that takes XYZ seen under one white, (3,), to those that look the same under another: (3, 3)."""
    gain = (_BRADFORD @ np.asarray(other)) / (_BRADFORD @ np.asarray(white))
    return np.asarray(np.linalg.solve(_BRADFORD, gain[:, None] * _BRADFORD))


def _xyz(chromaticity: _Chromaticity) -> FloatArray:
    """XYZ of a chromaticity, with Y = 1."""
    x, y = chromaticity
    return np.array([x, y, 1 - x - y]) / y
