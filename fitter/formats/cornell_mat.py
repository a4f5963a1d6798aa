"""Cornell's measurements of a house paint, paint.reformat.mat: four arrays, any of which may be transposed
(docs/layouts.md, Cornell's house paint)."""


import numpy as np

from ..arrays import FloatArray
from ..errors import DatasetError
from ..samples import RGB, Samples
from . import mat5
from .format import Format
from .reading import BY_DEFAULT, Reading
from .spectra import to_linear_srgb

_ARRAYS = ("dir_in", "dir_out", "fr", "wavelength")


def read(content: bytes, reading: Reading = BY_DEFAULT) -> Samples:
    """Read the paint file; spectra become linear sRGB.

    Raises DatasetError if the file is damaged, or an array is missing or has an unexpected shape.
    """
    arrays = mat5.read(content, _ARRAYS)
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


FORMAT = Format("Cornell", "Cornell paint.reformat.mat", (".mat",),
                lambda content: content.startswith(mat5.MAT_MAGIC), read, ("illuminant",), is_text=False)
