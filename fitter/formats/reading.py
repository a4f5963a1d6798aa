"""Options of reading: what a file's numbers mean, where it does not say it; how spectra become colours; and what is
known of the material's symmetry."""

from dataclasses import dataclass
from math import pi
from typing import NamedTuple

from ..errors import DatasetError
from ..samples import SYMMETRIES
from .illuminants import DEFAULT, ILLUMINANTS

ANGLES = ("degrees", "radians")


class Quantity(NamedTuple):
    """What values are: the angle whose cosine is in them, as `names.ANGLES` calls it, or "", and the BRDF over them."""

    cosine: str
    scale: float


QUANTITIES = {"brdf": Quantity("", 1.0), "brdf_cos": Quantity("s", 1.0), "brdf_cos_i": Quantity("i", 1.0),
              "reflectance_factor": Quantity("", 1 / pi), "reflectance_percent": Quantity("", 0.01 / pi),
              "brdf_percent": Quantity("", 0.01)}
"""What values may be: the BRDF, also with a cosine; pi times it; that in percent; the BRDF in percent."""
LONGEST_COLUMNS = 20_000    # characters
ENCODINGS = ("raw", "srgb", "srgb140")


def one_of(option: str, value: object, expected: tuple[str, ...]) -> None:
    """Raise `DatasetError` unless the value of an option is one of those expected."""
    if value not in expected:
        raise DatasetError(f"{option} {value!r} found, expected {', '.join(expected[:-1])} or {expected[-1]}")


@dataclass(frozen=True)
class Reading:
    """Options of reading. `Format.options` says which of them matter to a format.

    Attributes
    ----------
    angles : str, or None
        One of `ANGLES`: the unit, whatever the file says.
    quantity : str, or None
        One of `QUANTITIES`, whatever the file says.
    illuminant : str
        One of `ILLUMINANTS`.
    isotropic : bool, or None
        Whether to take the material as isotropic, whatever its values tell.
    symmetry : str, or None
        One of `samples.SYMMETRIES`: what was measured stands for that, too, whatever the file says.
    encoding : str, or None
        One of `ENCODINGS`: how the values of a UTIA file are stored (`utia`).
    keep_unmeasured : bool
        Whether to keep values that nobody measured (`unmeasured`).
    columns : str, or None
        What the columns of a table are, in their order, separated by commas: names as a table of one's own has them
        (`names`), "-" for those that are not read. Whatever the table calls them, and where it has no names.

    Raises
    ------
    DatasetError
        If they are anything else.

    Examples
    --------
    >>> try:
    ...     Reading(angles="grad")
    ... except DatasetError as error:
    ...     print(error)
    angles 'grad' found, expected degrees or radians
    """

    angles: str | None = None
    quantity: str | None = None
    illuminant: str = DEFAULT
    isotropic: bool | None = None
    symmetry: str | None = None
    encoding: str | None = None
    keep_unmeasured: bool = False
    columns: str | None = None

    def __post_init__(self) -> None:
        for name, choices in (("angles", ANGLES), ("quantity", tuple(QUANTITIES)), ("symmetry", SYMMETRIES),
                              ("encoding", ENCODINGS)):
            if getattr(self, name) is not None:
                one_of(name, getattr(self, name), choices)
        if self.isotropic not in (None, True, False):
            raise DatasetError(f"isotropic {self.isotropic!r} found, expected True, False or None")
        if self.keep_unmeasured not in (True, False):
            raise DatasetError(f"keep_unmeasured {self.keep_unmeasured!r} found, expected True or False")
        if self.columns is not None and not (isinstance(self.columns, str)
                                             and 0 < len(self.columns.strip(", ")) < LONGEST_COLUMNS):
            raise DatasetError(f"columns {str(self.columns)[:40]!r} found, expected names, such as "
                               "theta_i,theta_o,phi,BRDF")
        one_of("illuminant", self.illuminant, ILLUMINANTS)

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say of spectra that were converted: nothing of the default."""
        return () if self.illuminant == DEFAULT else (f"Spectra seen under the illuminant {self.illuminant}",)


BY_DEFAULT = Reading()
