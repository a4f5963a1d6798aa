"""Options of reading: what a file's numbers mean, where it does not say it; how spectra become colours; and what is
known of the material's symmetry."""

from dataclasses import dataclass, field, fields
from itertools import starmap
from math import pi
from typing import Any, NamedTuple

from ..errors import DatasetError
from ..samples import HALF_TURN, HALF_TURN_AND_MIRROR, MIRROR, NO_SYMMETRY
from .spectra import DEFAULT


class Quantity(NamedTuple):
    """What values are: the angle whose cosine is in them, as `names.ANGLES` calls it, or "", and the BRDF over them."""

    cosine: str
    scale: float


QUANTITIES = {"brdf": Quantity("", 1.0), "brdf_cos": Quantity("s", 1.0), "brdf_cos_i": Quantity("i", 1.0),
              "reflectance_factor": Quantity("", 1 / pi), "reflectance_percent": Quantity("", 0.01 / pi),
              "brdf_percent": Quantity("", 0.01)}
"""What values may be: the BRDF, also with a cosine; pi times it; that in percent; the BRDF in percent."""
LONGEST_COLUMNS = 20_000    # characters
# of choices that are no text: what Blender stores, and the word of the command line
_KEYS: dict[str | bool | None, str] = {None: "auto", True: "isotropic", False: "anisotropic"}
_ANSWER_WORDS: dict[str | bool | None, str] = {True: "yes", False: "no"}


class Choice(NamedTuple):
    """A value of an option, which `load` takes, its label and its tooltip."""

    value: str | bool | None
    label: str
    tooltip: str

    @property
    def key(self) -> str:
        """What Blender stores of it, and its operators are given."""
        return _KEYS.get(self.value, str(self.value))


class Option(NamedTuple):
    """An option of reading: of it the keyword argument of `load`, the command line's argument and its help, and
    Blender's property and its tooltip are made.

    Without choices it is switched on, where the default is a bool, or else a text.
    """

    default: str | bool | None
    label: str
    tooltip: str
    choices: tuple[Choice, ...]

    @property
    def values(self) -> tuple[str | bool, ...]:
        """What it may be, beside None for what the file says; empty for a text."""
        if isinstance(self.default, bool):
            return True, False
        return tuple(choice.value for choice in self.choices if choice.value is not None)

    @property
    def help(self) -> str:
        """What the command line says of it, as argparse takes it: its tooltips."""
        means = [f"{_ANSWER_WORDS.get(choice.value, choice.value)}: {_lower(choice.tooltip)}" for choice in self.choices
                 if choice.value is not None]
        default = f"default: {self.default}" if isinstance(self.default, str) else ""
        return "; ".join(filter(None, (_lower(self.tooltip), *means, default))).replace("%", "%%")

    def value(self, stored: object) -> Any:
        """The value for what Blender has stored; the default for what was no choice."""
        if not self.choices:
            return stored or self.default
        return next((choice.value for choice in self.choices if choice.key == stored), self.default)

    def to_stored(self, value: object) -> Any:
        """What Blender stores for a value."""
        if not self.choices:
            return "" if value is None else value
        return next(choice.key for choice in self.choices if choice.value == value)


def _option(default: str | bool | None, label: str, tooltip: str, *choices: tuple[str | bool | None, str, str]) -> Any:
    return field(default=default, metadata={"option": Option(default, label, tooltip, tuple(starmap(Choice, choices)))})


def _lower(text: str) -> str:
    """A sentence that goes on after another; what begins with an abbreviation stays."""
    return text if text[1:2].isupper() else text[0].lower() + text[1:]


def check_choice(option: str, value: object, expected: tuple[object, ...]) -> None:
    """Raise `DatasetError` unless the value of an option is one of those expected."""
    if value not in expected:
        names = tuple(map(str, expected))
        raise DatasetError(f"{option} {value!r} found, expected {', '.join(names[:-1])} or {names[-1]}")


@dataclass(frozen=True)
class Reading:
    """Options of reading, each with an `Option`, which says what it means. `Format.options` says which of them matter
    to a format. Raises DatasetError if one has another value.
    """

    angles: str | None = _option(
        None, "Angles", "Unit of the angles of a table. Only needed where the file does not say it, or says it wrongly",
        (None, "As the File Says", "In the unit that the file names, or that its format defines"),
        ("degrees", "Degrees", "In degrees, whatever a table or an ASTM file says"),
        ("radians", "Radians", "In radians, whatever a table or an ASTM file says"))
    quantity: str | None = _option(
        None, "Values",
        "What the values of a table are. Only needed where the file does not say it, or says it wrongly",
        (None, "As the File Says", "What the file names, or what its format defines"),
        ("brdf", "BRDF", "Reflected radiance divided by irradiance"),
        ("brdf_cos", "BRDF times Cosine",
         "Times the cosine of the outgoing angle, as goniometers usually print it (cosine-corrected)"),
        ("brdf_cos_i", "BRDF times Incident Cosine", "Times the cosine of the incident angle"),
        ("reflectance_factor", "Reflectance Factor", "Times pi: relative to a white diffuser"),
        ("reflectance_percent", "Reflectance Factor, Percent", "Times 100 pi: a white diffuser has about 100"),
        ("brdf_percent", "BRDF, Percent", "Times 100"))
    illuminant: str = _option(
        DEFAULT, "Illuminant", "The light under which spectra are seen when they become colours. White stays white",
        ("D65", "Daylight (D65)", "Daylight of noon; white is that of screens"),
        ("D50", "Horizon Daylight (D50)", "Warmer daylight, the standard of print"),
        ("A", "Incandescent (A)", "A light bulb"),
        ("E", "Equal Energy (E)", "The same power at every wavelength"))
    isotropic: bool | None = _option(
        None, "Isotropic",
        "Whether the surface looks the same however it is turned. Found from three rotations on",
        (None, "As Measured", "Found from the values, or as the format defines it"),
        (True, "Isotropic", "The surface looks the same however it is turned, whatever its values tell"),
        (False, "Anisotropic", "The surface changes when it is turned, as brushed metal does"))
    symmetry: str | None = _option(
        None, "Symmetry", "What stands for rotations of an anisotropic surface at which a table, an ASTM, a Zemax or a "
        "Speos file has no values",
        (None, "As the File Says", "What the file names; most name none"),
        (NO_SYMMETRY, "None", "Nothing stands for directions that were not measured"),
        (HALF_TURN, "Half Turn", "The surface is the same after half a turn"),
        (MIRROR, "Mirror", "The plane of normal and tangent is a mirror"),
        (HALF_TURN_AND_MIRROR, "Half Turn and Mirror", "Both: a quarter of a turn was measured"))
    encoding: str = _option(
        "raw", "UTIA Values", "How the values of a UTIA file are stored. Its readers differ",
        ("raw", "As Stored", "The BRDF"),
        ("srgb", "sRGB", "The BRDF, encoded as sRGB"),
        ("srgb140", "sRGB times 140", "A hundredth of the BRDF, encoded as sRGB, times 140"))
    keep_unmeasured: bool = _option(
        False, "Keep Unmeasured", "Fit values that nobody measured too: those drawn beyond the angle at which the "
        "instrument ended, as a straight line to 0 or the last value again")
    columns: str | None = _option(
        None, "Columns", "What the columns of a table are, in their order, where their names mean nothing or are not "
        "there: names separated by commas, and - for those that are not read, such as theta_i, -, theta_o, phi, BRDF. "
        "By default as the file names them")

    def __post_init__(self) -> None:
        for name, option in OPTIONS.items():
            value = getattr(self, name)
            if option.values and (value is not None or option.default is not None):
                check_choice(name, value, option.values)
        if self.columns is not None and not (isinstance(self.columns, str)
                                             and 0 < len(self.columns.strip(", ")) < LONGEST_COLUMNS):
            raise DatasetError(f"columns {str(self.columns)[:40]!r} found, expected names, such as "
                               "theta_i,theta_o,phi,BRDF")

    @property
    def notes(self) -> tuple[str, ...]:
        """What there is to say of spectra that were converted: nothing of the default."""
        return () if self.illuminant == DEFAULT else (f"Spectra seen under the illuminant {self.illuminant}",)


OPTIONS: dict[str, Option] = {each.name: each.metadata["option"] for each in fields(Reading)}
BY_DEFAULT = Reading()
