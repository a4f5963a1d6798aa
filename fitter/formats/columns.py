"""What the columns of a table of measurements mean, by their names: angles and their unit, channels, and cosines."""

import re
from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..errors import ColumnsUnknownError, DatasetError
from ..samples import RGB
from .names import ANGLES
from .reading import Quantity, Reading
from .spectra import SPAN, to_linear_srgb

GREY_NAMES = ("brdf", "fr", "f_r", "grey", "gray")
_LAMP_BANDS = (580, 700), (500, 580), (400, 500)    # nm, of red, green and blue
_LEAST_COSINE = 1e-3            # values that have a smaller cosine in them are left out
_WAVELENGTH_CELL = re.compile(r"(\d+(?:\.\d+)?)\s*nm", re.IGNORECASE)


def look_like_degrees(angles: FloatArray) -> bool:
    """Whether more than half of the angles that are not zero are too large for radians."""
    return bool(2 * np.count_nonzero(np.abs(angles) > 2 * np.pi + 1e-3) > np.count_nonzero(angles))


def angles_note(in_degrees: bool, said: str | None, reading: Reading) -> str:
    """What to say of the unit of angles: which it is, and if a user chose it, what the file says."""
    unit = "degrees" if in_degrees else "radians"
    if reading.angles is None:
        return f"Angles in {unit}"
    against = f"; the file says {said}" if said is not None and said != unit[:3] else ""
    return f"Angles in {unit}, as asked{against}"


def to_brdf(directions: FloatArray, values: FloatArray, quantity: Quantity, asked: str,
            line: int) -> tuple[FloatArray, FloatArray, list[str]]:
    """The BRDF by values of a quantity: directions, (n, 4) radians as in `ANGLES`, values, (n, channels), and notes.

    Values at the horizon hold nothing where a cosine is in them, and are left out. Raises DatasetError if no row is
    left. `asked` is what notes end with where a user chose the quantity, else empty; `line` is that of the names.
    """
    notes = [f"Multiplied by {quantity.scale:.4g}{asked}"] if asked and quantity.scale != 1 else []
    if not quantity.cosine:
        return directions, values * quantity.scale, notes or ["Values are the BRDF" + asked] * bool(asked)
    factor = np.cos(directions[:, ANGLES.index(f"theta_{quantity.cosine}")])
    kept = factor >= _LEAST_COSINE
    if not kept.any():
        raise DatasetError("all values are at the horizon, where their cosine is 0", line=line)
    without = "" if kept.all() else f"; {np.count_nonzero(~kept):,} at the horizon are left out"
    notes.append(f"Divided by the cosine of theta_{'i' if quantity.cosine == 'i' else 'o'}{without}{asked}")
    return directions[kept], values[kept] * quantity.scale / factor[kept, None], notes


def reflectance(names: Sequence[str], values: FloatArray, line: int,
                reading: Reading) -> tuple[tuple[str, ...], FloatArray, tuple[str, ...]]:
    """The channels, values converted to them, (n, channels), and notes; spectra become linear sRGB.

    `names` are those of the columns of `values`, (n, columns): R, G and B in any order; wavelengths; or one of `GREY`.
    Raises DatasetError, with the line of the names, if they are anything else.
    """
    upper = [name.upper() for name in names]
    if sorted(upper) == sorted(RGB):
        return RGB, values[:, [upper.index(channel) for channel in RGB]], ()
    matches = [match for name in names if (match := _WAVELENGTH_CELL.fullmatch(name))]
    bands = np.array([float(match[1]) for match in matches]) if len(matches) == len(names) else None
    if len(names) == 1 and (bands is not None or names[0].lower() in GREY_NAMES):
        return ("grey",), values, ()
    if bands is None:
        shown = ",".join(names[:4]) + "..." * (len(names) > 4)
        raise ColumnsUnknownError(f"channels {shown} found, expected R,G,B, or wavelengths such as 400nm, or BRDF",
                                  line=line)
    lamps = [np.flatnonzero((bands >= low) & (bands < high)) for low, high in _LAMP_BANDS]
    if len(names) == 3 and np.ptp(bands) < SPAN and all(len(lamp) == 1 for lamp in lamps):
        return RGB, values[:, np.concatenate(lamps)], ()
    return RGB, to_linear_srgb(bands, values, line, reading.illuminant), reading.notes
