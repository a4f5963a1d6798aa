"""What the columns of a table are: by their names, by what is said before them, or by what a user says."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..arrays import FloatArray
from ..errors import ColumnsUnknownError, DatasetError, UnitsUnknownError
from . import names
from .names import ANGLES
from .plane import PLANE_SIDES
from .reading import QUANTITIES, Quantity, Reading
from .table_layout import MOST_COLUMNS, SKIPPED, Layout
from .text import decode, floats, lines, parse_number

EXPECTED = "theta_i, theta_o, phi (or phi_i and phi_o), and values: BRDF, or R, G and B"
OTHERWISE = "the option columns says which is which"
_SAID = re.compile(rb"[#%!/\s\"]*([^:=;,\t|\"]{1,60}?)[\s\"]*[:=;,\t|]+[\s\"]*([^\r\n]{0,200}?)[\s;,|\"]*\Z")
_NUMBER = re.compile(r"([-+]?\d+(?:[.,]\d+)?)\s*[;,\t|]?\s*(.*)")
_STRANGE_UNITS = frozenset({"gon", "grad", "grads", "gradian", "gradians", "mrad", "milliradians", "arcmin", "turns"})
_NAMES = ("name", "sample", "sample name", "material")


@dataclass(frozen=True)
class Columns:
    """What the columns of a table are; of those that are read, in the order of `used`.

    Attributes
    ----------
    used : list of int
        The columns that are read.
    angles : dict
        The column of each of `ANGLES` that is there.
    constants : dict
        Of the others, the angle that is said before the table.
    values : list of int
    channels : list of str
        The name of each of `values`.
    unit : str, or None
        "deg" or "rad", if it is said; anything that is said, where `Reading` has the unit.
    quantity : Quantity
        What the values are: the cosine that is in them, and what they are multiplied by.
    note : str
        What is said of the values, for the description; empty of the BRDF.
    cosine : str
        What the file says of the cosine: "i", "s" or "".
    wavelength : int, or None
        The column of the wavelength, where each has a row of its own, ...
    in_microns : bool, or None
        ... and whether it is in micrometres, if that is said.
    standard : int, or None
        The column of the standard, ...
    reflectance : float
        ... and what it reflects.
    side : int
        The sign that theta_o has on the mirror's side, if the table says it, or 0.
    """

    used: list[int]
    angles: dict[str, int]
    constants: dict[str, float]
    values: list[int]
    channels: list[str]
    unit: str | None
    quantity: Quantity
    note: str
    cosine: str
    wavelength: int | None
    in_microns: bool | None
    standard: int | None
    reflectance: float
    side: int

    @property
    def in_plane(self) -> bool:
        """Whether there are no azimuths: a scan in the plane of incidence."""
        return not {"phi_i", "phi_s"} & {*self.angles, *self.constants}

    def angles_of(self, numbers: FloatArray) -> FloatArray:
        """(n, 4); azimuths that the table does not have are 0."""
        angles = np.zeros((len(numbers), len(ANGLES)))
        for role, constant in self.constants.items():
            angles[:, ANGLES.index(role)] = constant
        for role, column in self.angles.items():
            angles[:, ANGLES.index(role)] = numbers[:, column]
        return angles


def said_before(content: bytes, layout: Layout) -> dict[str, str]:
    """What comments and title lines before the names say, by keyword in lower case."""
    begin, end = layout.titles
    matches = (_SAID.match(line[0]) for line in lines(content[begin:end]))
    return {decode(match[1]).strip().lower(): decode(match[2]).strip() for match in matches if match}


def name_of(said: dict[str, str]) -> str:
    """What was measured, if the table says it, or ""."""
    return next((said[key] for key in _NAMES if said.get(key)), "")


@dataclass
class _ColumnsSoFar:
    """What has been found of the columns so far."""

    roles: dict[str, int] = field(default_factory=dict)
    values: list[int] = field(default_factory=list)
    kinds: list[names.Value] = field(default_factory=list)
    unknown: list[str] = field(default_factory=list)


def meaning(layout: Layout, said: dict[str, str], reading: Reading, path: str | Path) -> Columns:
    """What the columns of a table are.

    Raises ColumnsUnknownError if their names mean nothing, or too little; UnitsUnknownError if the values may be
    several things, and `reading` does not say which.
    """
    if len(layout.names) > MOST_COLUMNS:
        raise DatasetError(f"more than {MOST_COLUMNS} columns found", path, layout.line)
    found = _assign_roles(layout, path)
    constants, constant_units = _constants(said, found.roles)
    _resolve(found, constants)
    missing = [name for role, name in (("theta_i", "theta_i"), ("theta_s", "theta_o")) if role not in found.roles
               and role not in constants]
    if "phi_i" in found.roles and "phi_s" not in found.roles:
        missing.append("phi_o or phi")
    if not found.values:
        missing.append("values, such as R, G and B")
    if missing or found.unknown:
        lacking = f"expected also {', '.join(missing)}" if missing else (
            f"of which {', '.join(found.unknown[:4])} mean{'s' * (len(found.unknown) == 1)} nothing here")
        raise ColumnsUnknownError(f"columns {shorten(layout.names)} found, {lacking}; {OTHERWISE}", path, layout.line)
    used = sorted([*found.roles.values(), *found.values])
    place = {column: k for k, column in enumerate(used)}
    angles = {role: place[column] for role, column in found.roles.items() if role in ANGLES}
    units = [layout.units[used[k]] for k in angles.values()] + constant_units
    unit = _unit([each for each in units if each], said, reading, path, layout.line)
    has_standard = names.STANDARD in found.roles
    quantity, note, cosine = _quantity(found, layout, said, reading, has_standard, path)
    wavelength = found.roles.get(names.WAVELENGTH)
    band_unit = None if wavelength is None else layout.units[wavelength]
    if wavelength is not None and len(found.values) != 1:
        raise ColumnsUnknownError(f"{len(found.values)} columns of values found beside one of wavelengths, expected "
                                  f"one; {OTHERWISE}", path, layout.line)
    reflected = 1.0
    if has_standard:
        reflected = parse_number(said.get("standard", "1").encode(), path)
        if not 0 < reflected <= 2:
            raise DatasetError(f"a standard of reflectance {reflected:g} found, expected 0 to 1", path)
    return Columns(used, angles, constants, [place[column] for column in found.values],
                   [kind.channel for kind in found.kinds], unit, quantity, note, cosine,
                   None if wavelength is None else place[wavelength],
                   {"um": True, "nm": False}.get(band_unit or ""), place[found.roles[names.STANDARD]] if has_standard
                   else None, reflected, _side(said))


def shorten(columns: list[str], most: int = 8) -> str:
    """The first names of columns, for a message."""
    return ", ".join(name[:24] for name in columns[:most]) + (" ..." if len(columns) > most else "")


def _assign_roles(layout: Layout, path: str | Path) -> _ColumnsSoFar:
    """The role of each column, or its kind of values."""
    found = _ColumnsSoFar()
    # in remote sensing s is the sun
    sun = {names.parse(name).words for name in layout.names} >= {("theta", "s"), ("theta", "v")}
    for column, name in enumerate(layout.names):
        if name in ("", SKIPPED):
            continue
        role = names.role(name)
        if sun and role in ("theta_s", "phi_s") and names.parse(name).words[1:] == ("s",):
            role = role.replace("_s", "_i")
        if role == names.RELATIVE:
            role = "phi_s"
        if role is not None:
            if role in found.roles:
                raise ColumnsUnknownError(f"'{name[:40]}' is the second column of its kind; {OTHERWISE}", path,
                                          layout.line)
            if role != names.BESIDE:
                found.roles[role] = column
        elif (kind := names.value(name)) is None:
            found.unknown.append(name)
        elif kind.kind == names.TRANSMITTED:
            raise DatasetError(f"'{name[:40]}' found, expected a BRDF: transmitted light cannot be used", path,
                               layout.line)
        else:
            found.values.append(column)
            found.kinds.append(kind._replace(percent=kind.percent or layout.units[column] in ("%", "%/sr")))
    return found


def _constants(said: dict[str, str], roles: dict[str, int]) -> tuple[dict[str, float], list[str]]:
    """The angles that are said before the table and have no column, and their units."""
    constants, units = {}, []
    for key, text in said.items():
        role, number = names.role(key), _NUMBER.fullmatch(text)
        role = "phi_s" if role == names.RELATIVE else role
        if role not in ANGLES or role in roles or role in constants or number is None:
            continue
        unit = names.parse(key).unit or names.unit_of(number[2])
        value = floats(b"", [number[1].replace(",", ".").encode()])
        if value is not None and (not number[2] or unit in ("deg", "rad")):
            constants[role] = value[0]
            units += [unit] if unit in ("deg", "rad") else []
    return constants, units


def _resolve(found: _ColumnsSoFar, constants: dict[str, float]) -> None:
    """Tell which direction a polar angle is of that names none: the one that no other column is of."""
    if names.THETA in found.roles:
        free = [role for role in ("theta_s", "theta_i") if role not in found.roles and role not in constants]
        if len(free) == 1:
            found.roles[free[0]] = found.roles.pop(names.THETA)
        else:
            found.roles.pop(names.THETA)
            found.unknown.append("the polar angle that names no side")


def _unit(units: list[str], said: dict[str, str], reading: Reading, path: str | Path, line: int) -> str | None:
    """The unit of angles that names, numbers or a comment say."""
    told = {*units}
    if "angles" in said:
        word = said["angles"].lower().split(" ")[0].strip(".,")
        unit = names.unit_of(word)
        if unit in ("deg", "rad") or word in _STRANGE_UNITS:
            told.add(unit if unit in ("deg", "rad") else word)
    if reading.angles is None and (len(told) > 1 or not told <= {"deg", "rad"}):
        raise DatasetError("angles must all be in degrees, or all in radians", path, line)
    return " and ".join(sorted(told)) or None


def _quantity(found: _ColumnsSoFar, layout: Layout, said: dict[str, str], reading: Reading, has_standard: bool,
              path: str | Path) -> tuple[Quantity, str, str]:
    """What the values are, a note of it, and the cosine that the file says; as `reading` says where it does."""
    kinds, cosines, percents = ({getattr(kind, name) for kind in found.kinds} for name in ("kind", "cosine", "percent"))
    if "values" in said:
        comment = names.value(said["values"])
        has_cosine = "cos" in said["values"].lower()
        cosines = {*(cosines - {""}), comment.cosine if comment and comment.cosine else "?" if has_cosine else ""}
        if comment and comment.kind != names.UNSAID:
            kinds = {*(kinds - {names.UNSAID}), comment.kind}
        if (comment and comment.percent) or names.unit_of(said["values"]) in ("%", "%/sr"):
            percents = {True}
    cosine = " and ".join(sorted(cosines))
    if reading.quantity is not None:
        return QUANTITIES[reading.quantity], "", cosine if cosine in ("i", "s") else ""
    line = layout.line
    if len(cosines) > 1 or not cosines <= {"", "i", "s"}:
        raise UnitsUnknownError("values with a cosine must name it, one for all: BRDF*cos_i or BRDF*cos_o; or choose "
                                "what they are (the option quantity of reading; in Blender's import, Values)", path,
                                line)
    if has_standard:
        return Quantity(cosine, 1.0), "", cosine
    said_kinds = kinds - {names.UNSAID}
    if len(said_kinds) > 1 or len(percents) > 1:
        raise UnitsUnknownError("columns of different kinds of values found, expected one for all (the option quantity "
                                "of reading; in Blender's import, Values)", path, line)
    kind, in_percent = next(iter(said_kinds), names.UNSAID), True in percents
    per_steradian = any(layout.units[column] == "%/sr" for column in found.values)
    if in_percent and kind in (names.UNSAID, names.REFLECTANCE) and not per_steradian:
        kind = names.FACTOR
    if kind == names.REFLECTANCE or (kind == names.BRDF and in_percent and not per_steradian):
        raise UnitsUnknownError("the values may be the BRDF or a reflectance factor, which is pi times as much: "
                                "choose which (the option quantity of reading; in Blender's import, Values), or "
                                "name them BRDF or reflectance_factor", path, line)
    name = {(names.FACTOR, False): "reflectance_factor", (names.FACTOR, True): "reflectance_percent"}.get(
        (kind, in_percent), "brdf_percent" if in_percent else "brdf")
    scale = QUANTITIES[name].scale
    note = {"reflectance_factor": "Reflectance factors, divided by pi",
            "reflectance_percent": "Reflectance factors in percent, divided by 100 pi",
            "brdf_percent": "In percent, divided by 100"}.get(name, "")
    return Quantity(cosine, scale), note, cosine


def _side(said: dict[str, str]) -> int:
    """The sign of theta_o on the mirror's side, of a comment such as ``positive: mirror side``; 0 without one."""
    for key, sign in (("positive", 1), ("negative", -1)):
        for word in _words(said.get(key, "")):
            if word in PLANE_SIDES:
                return sign * PLANE_SIDES[word]
    return 0


def _words(text: str) -> Iterator[str]:
    return (word.strip("'s.,") if word.endswith("'s") else word for word in text.lower().split())
