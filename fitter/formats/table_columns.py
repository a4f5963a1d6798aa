"""What the columns of a table are: by their names, by what is said before them, or by what a user says."""

import re
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray
from ..errors import ColumnsUnknownError, DatasetError, UnitsUnknownError
from . import names
from .names import ANGLES
from .plane import PLANE_SIDES
from .reading import QUANTITIES, Quantity, Reading
from .table_layout import MOST_COLUMNS, SKIPPED, Layout
from .text import decode, floats, lines

EXPECTED = "theta_i, theta_o, phi (or phi_i and phi_o), and values: BRDF, or R, G and B"
OTHERWISE = "the option columns says which is which"
_SAID = re.compile(rb"[#%!/\s\"]*([^:=;,\t|\"]{1,60}?)[\s\"]*[:=;,\t|]+[\s\"]*([^\r\n]{0,200}?)[\s;,|\"]*\Z")
_NUMBER = re.compile(r"([-+]?\d+(?:[.,]\d+)?)\s*[;,\t|]?\s*(.*)")
_STRANGE_UNITS = frozenset({"gon", "grad", "grads", "gradian", "gradians", "mrad", "milliradians", "arcmin", "turns"})
_ANGULAR = {"deg", "rad"}
_AZIMUTH = {names.RELATIVE: "phi_s"}        # the light is at azimuth 0
_SAID_QUANTITIES = {        # whether they are reflectance factors, and in percent
    (False, False): ("brdf", ""), (False, True): ("brdf_percent", "In percent, divided by 100"),
    (True, False): ("reflectance_factor", "Reflectance factors, divided by pi"),
    (True, True): ("reflectance_percent", "Reflectance factors in percent, divided by 100 pi")}


@dataclass
class Columns:
    """What the columns of a table are, by their numbers, and what is said of them."""

    line: int                       # of their names, for errors
    units: list[str | None]         # as `Layout.units`
    said: dict[str, str]            # what comments and title lines before the names say, by keyword in lower case
    # the columns of angles (`names.ANGLES`), of the wavelength and of the standard, as far as they are there
    roles: dict[str, int] = field(default_factory=dict)
    values: dict[int, names.Value] = field(default_factory=dict)
    # of the other angles, those that are said before the table, each with its unit, or ""
    constants: dict[str, tuple[float, str]] = field(default_factory=dict)

    @property
    def indices(self) -> list[int]:
        """The columns that are read."""
        return sorted([*self.roles.values(), *self.values])

    @property
    def is_scan(self) -> bool:
        """Whether there are no azimuths: a scan in the plane of incidence."""
        return not {"phi_i", "phi_s"} & {*self.roles, *self.constants}

    def angles(self, numbers: FloatArray) -> FloatArray:
        """The angles of rows, (n, columns) to (n, 4); azimuths that the table does not have are 0."""
        angles = np.zeros((len(numbers), len(ANGLES)))
        for column, role in enumerate(ANGLES):
            if role in self.roles or role in self.constants:
                angles[:, column] = numbers[:, self.roles[role]] if role in self.roles else self.constants[role][0]
        return angles


def assign_columns(content: bytes, layout: Layout) -> Columns:
    """What the columns of a table are, by their names and by what is said before them.

    Raises ColumnsUnknownError if their names mean nothing, or too little.
    """
    if len(layout.names) > MOST_COLUMNS:
        raise DatasetError(f"more than {MOST_COLUMNS} columns found", line=layout.line)
    matches = (_SAID.match(line[0]) for line in lines(content, end=layout.titles))
    said = {decode(match[1]).strip().lower(): decode(match[2]).strip() for match in matches if match}
    found = Columns(layout.line, layout.units, said)
    unknown = _classify(found, layout)
    known = {*found.roles}
    for key, text in said.items():
        role, number = _AZIMUTH.get(names.role(key) or "", names.role(key)), _NUMBER.fullmatch(text)
        if role in ANGLES and role not in known and number is not None:
            unit = names.parse(key).unit or names.find_unit(number[2])
            value = floats(b"", [number[1].replace(",", ".").encode()])
            if value is not None and (not number[2] or unit in _ANGULAR):
                known.add(role)
                found.constants[role] = value[0], unit or ""
    # a polar angle that names no side is that of the direction that no other column is of
    free = [role for role in ("theta_s", "theta_i") if role not in known]
    if (column := found.roles.pop(names.THETA, None)) is not None:
        if len(free) == 1:
            found.roles[free.pop()] = column
        else:
            unknown.append("the polar angle that names no side")
    missing = [{"theta_i": "theta_i", "theta_s": "theta_o"}[role] for role in reversed(free)]
    if "phi_i" in found.roles and "phi_s" not in found.roles:
        missing.append("phi_o or phi")
    if not found.values:
        missing.append("values, such as R, G and B")
    if missing or unknown:
        lacking = f"expected also {', '.join(missing)}" if missing else (
            f"of which {', '.join(unknown[:4])} mean{'s' * (len(unknown) == 1)} nothing here")
        raise ColumnsUnknownError(f"columns {shorten(layout.names)} found, {lacking}; {OTHERWISE}", line=layout.line)
    if names.WAVELENGTH in found.roles and len(found.values) != 1:
        raise ColumnsUnknownError(f"{len(found.values)} columns of values found beside one of wavelengths, expected "
                                  f"one; {OTHERWISE}", line=layout.line)
    return found


def shorten(columns: list[str], most: int = 8) -> str:
    """The first names of columns, for a message."""
    return ", ".join(name[:24] for name in columns[:most]) + (" ..." if len(columns) > most else "")


def _classify(found: Columns, layout: Layout) -> list[str]:
    """Find the role of each column, or what values it holds; the names that mean nothing."""
    unknown = []
    # in remote sensing s is the sun
    sun = {names.parse(name).words for name in layout.names} >= {("theta", "s"), ("theta", "v")}
    for column, name in enumerate(layout.names):
        if name in ("", SKIPPED):
            continue
        role = names.role(name)
        if sun and role in ("theta_s", "phi_s") and names.parse(name).words[1:] == ("s",):
            role = role.replace("_s", "_i")
        role = _AZIMUTH.get(role or "", role)
        if role in found.roles:
            raise ColumnsUnknownError(f"'{name[:40]}' is the second column of its kind; {OTHERWISE}", line=layout.line)
        if role is not None:
            found.roles |= {role: column} if role != names.BESIDE else {}
        elif (value := names.value(name)) is None:
            unknown.append(name)
        elif value.kind == names.TRANSMITTED:
            raise DatasetError(f"'{name[:40]}' found, expected a BRDF: transmitted light cannot be used",
                               line=layout.line)
        else:
            found.values[column] = value
    return unknown


def unit_of_angles(columns: Columns, reading: Reading) -> str | None:
    """The unit of angles, "deg" or "rad", that names, numbers or a comment say; anything, where `reading` says it."""
    found = {unit for unit in (*(columns.units[column] for role, column in columns.roles.items() if role in ANGLES),
                               *(unit for _, unit in columns.constants.values())) if unit}
    if "angles" in columns.said:
        word = columns.said["angles"].lower().split(" ")[0].strip(".,")
        unit = names.find_unit(word)
        found |= {unit or ""} & _ANGULAR or {word} & _STRANGE_UNITS
    if reading.angles is None and (len(found) > 1 or not found <= _ANGULAR):
        raise DatasetError("angles must all be in degrees, or all in radians", line=columns.line)
    return " and ".join(sorted(found)) or None


def quantity(columns: Columns, reading: Reading) -> tuple[Quantity, str, str]:
    """What the values are, a note of it, and the cosine that the file says; as `reading` says where it does.

    Raises UnitsUnknownError if the values may be several things, and `reading` does not say which.
    """
    units, said, kinds = columns.units, columns.said.get("values"), {value.kind for value in columns.values.values()}
    cosines = {value.cosine for value in columns.values.values()}
    percents = {value.percent or units[column] in ("%", "%/sr") for column, value in columns.values.items()}
    if said is not None:
        comment = names.value(said)
        has_cosine = "cos" in said.lower()
        cosines = {*(cosines - {""}), comment.cosine if comment and comment.cosine else "?" if has_cosine else ""}
        if comment and comment.kind != names.UNSAID:
            kinds = {*(kinds - {names.UNSAID}), comment.kind}
        if (comment and comment.percent) or names.find_unit(said) in ("%", "%/sr"):
            percents = {True}
    cosine = " and ".join(sorted(cosines))
    if reading.quantity is not None:
        return QUANTITIES[reading.quantity], "", cosine if cosine in ("i", "s") else ""
    if len(cosines) > 1 or not cosines <= {"", "i", "s"}:
        raise UnitsUnknownError("values with a cosine must name it, one for all: BRDF*cos_i or BRDF*cos_o; or choose "
                                "what they are (the option quantity of reading; in Blender's import, Values)",
                                line=columns.line)
    if names.STANDARD in columns.roles:
        return Quantity(cosine, 1.0), "", cosine
    kinds -= {names.UNSAID}
    if len(kinds) > 1 or len(percents) > 1:
        raise UnitsUnknownError("columns of different kinds of values found, expected one for all (the option quantity "
                                "of reading; in Blender's import, Values)", line=columns.line)
    kind, in_percent = next(iter(kinds), names.UNSAID), True in percents
    per_steradian = any(units[column] == "%/sr" for column in columns.values)
    if in_percent and kind in (names.UNSAID, names.REFLECTANCE) and not per_steradian:
        kind = names.FACTOR
    if kind == names.REFLECTANCE or (kind == names.BRDF and in_percent and not per_steradian):
        raise UnitsUnknownError("the values may be the BRDF or a reflectance factor, which is pi times as much: "
                                "choose which (the option quantity of reading; in Blender's import, Values), or "
                                "name them BRDF or reflectance_factor", line=columns.line)
    name, note = _SAID_QUANTITIES[kind == names.FACTOR, in_percent]
    return Quantity(cosine, QUANTITIES[name].scale), note, cosine


def mirror_side(columns: Columns) -> int:
    """The sign of theta_o on the mirror's side, of a comment such as ``positive: mirror side``; 0 without one."""
    return next((sign * PLANE_SIDES[word] for key, sign in (("positive", 1), ("negative", -1))
                 for word in re.findall("[a-z]+", columns.said.get(key, "").lower()) if word in PLANE_SIDES), 0)
