"""What the name of a column means: an angle, a value, or something beside them; and its unit.

Names are taken word by word, as people write them: ``theta_i[deg]``, ``AOI``, ``Incident Angle (°)``, ``θr``, ``sza``,
``BSDF [1/sr]``, ``BRDF_550nm``, ``Reflectance factor, %``. Letters are folded first (Unicode's NFKC), Greek ones spelt
out.
"""

import re
import unicodedata
from functools import lru_cache
from typing import NamedTuple

ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")
RELATIVE, THETA, WAVELENGTH, STANDARD, BESIDE = "phi", "theta", "wavelength", "standard", ""
"""Further roles: the azimuth between the directions, a polar angle of no named side, ..., and what is not read."""
UNSAID, BRDF, FACTOR, REFLECTANCE, TRANSMITTED = "", "brdf", "factor", "reflectance", "btdf"
"""Kinds of values: not said; the BRDF; pi times it; one of both; transmitted light."""

_DEGREES = "\u00b0\u00ba\u02da"
_SPELT = {"\u03b8": "theta", "\u03c6": "phi", "\u03bb": "lambda", "\u03b4": "delta", "\u2206": "delta",
          "\u03c1": "rho", "\u03bc": "u", "\u2212": "-"}      # after NFKC and in lower case
_UNITS = {
    **dict.fromkeys(("deg", "degs", "deg.", "degree", "degrees", "grad\u00b0", "\u00b0"), "deg"),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), "rad"),
    **dict.fromkeys(("1/sr", "sr-1", "/sr", "persr", "1/steradian", "steradian-1", "persteradian"), "1/sr"),
    **dict.fromkeys(("%", "percent", "pct", "inpercent", "in%"), "%"), **dict.fromkeys(("%/sr", "%sr-1"), "%/sr"),
    **dict.fromkeys(("nm", "nanometer", "nanometers", "nanometre", "nanometres"), "nm"),
    **dict.fromkeys(("um", "micron", "microns", "micrometer", "micrometers", "micrometre", "micrometres"), "um"),
    **dict.fromkeys(("", "-", "1", "unitless", "dimensionless", "none"), "")}
_BRACKETED = re.compile(r"(.*?)[\s_,;]*[\[(]([^\[\]()]{0,24})[\])]")
_UNIT_AFTER = re.compile(r"(.*?)(?:[\s_,;/-]+(?:in\s+)?(deg|degs|degrees?|rads?|radians?|%|percent|1/sr|sr\^?-1|per sr|"
                         r"nm|um)|(?<=.)(\u00b0|%))")
_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])")
_WORD_PATTERN = re.compile(r"[a-z]+|\d+(?:\.\d+)?")
_JOINED = re.compile(r"(d|delta)?(theta|zenith|polar|phi|azimuth(?:al)?)([a-z]*)")
_POLAR_WORDS = frozenset({"theta", "zenith", "polar"})
_AZIMUTH_WORDS = frozenset({"phi", "azimuth", "azimuthal", "az", "azi"})
_INCIDENT = frozenset({"i", "in", "inc", "incident", "incidence", "incoming", "illumination", "illuminating",
                       "illum", "source", "light", "lamp", "l", "sun", "solar", "irradiation", "input"})
_OUTGOING = frozenset({"o", "out", "outgoing", "r", "refl", "reflected", "reflection", "s", "scat", "scatter",
                       "scattered", "scattering", "v", "view", "viewing", "viewer", "sensor", "observation",
                       "observer", "obs", "detector", "det", "detection", "e", "exit", "exitance", "exitant",
                       "emergent", "emergence", "emission", "receiver", "receive", "received", "receiving", "camera",
                       "output"})
_RELATIVE_WORDS = frozenset({"relative", "rel", "delta", "d", "difference", "diff", "between"})
_FILLER_WORDS = frozenset({"angle", "angles", "ang", "of", "the", "direction", "to", "from", "normal"})
_ONE_WORD = {"aoi": "theta_i", "aos": "theta_s", "aoe": "theta_s", "aor": "theta_s", "aov": "theta_s", "sza": "theta_i",
             "iza": "theta_i", "vza": "theta_s", "oza": "theta_s", "saa": "phi_i", "vaa": "phi_s", "raa": RELATIVE,
             "incidence": "theta_i", "emergence": "theta_s", "exitance": "theta_s", "receive": "theta_s",
             "receiver": "theta_s", "receiving": "theta_s"}     # of names that are no more than it
_BESIDE = frozenset({"index", "no", "nr", "number", "id", "point", "time", "timestamp", "date", "temperature",
                     "uncertainty", "std", "stdev", "stddev", "sigma", "error", "comment", "comments", "remark",
                     "remarks", "note", "notes", "scan", "repeat", "rep"})
_COLOUR_WORDS = {"r": "R", "g": "G", "b": "B", "red": "R", "green": "G", "blue": "B"}
_VALUE_KINDS = {
    **dict.fromkeys(("", "grey", "gray", "value", "values", "y"), UNSAID),
    **dict.fromkeys(("brdf", "bsdf", "fr", "f r", "f", "brdf value", "bsdf value", "brdf values", "bsdf values"), BRDF),
    **dict.fromkeys(("reflectance factor", "brf", "hdrf", "hcrf", "bcrf", "radiance factor", "r factor",
                     "bidirectional reflectance factor", "brdf pi", "pi brdf"), FACTOR),
    **dict.fromkeys(("reflectance", "reflectivity", "refl", "rho", "bidirectional reflectance"), REFLECTANCE),
    **dict.fromkeys(("btdf", "transmittance", "btf", "transmission"), TRANSMITTED)}
_COSINE = re.compile(r"(.*?)\s*(?:\*|_|x|times)\s*cos\s*[_(]?\s*(?:theta_?)?\s*([iosrv]?)\s*\)?", re.IGNORECASE)
_LONGEST = 200              # characters of a name that means anything
_WAVELENGTH_RANGE = (200, 20_000)  # nm
_MICRONS = 20               # below which a number with a point, such as 0.55, is in micrometres


class Name(NamedTuple):
    """The words of a name, its unit as `find_unit` has it, or None, and the text without that."""

    words: tuple[str, ...]
    unit: str | None
    text: str


class Value(NamedTuple):
    """What a column of values is: a channel, its kind, the angle whose cosine is in it, and whether it is in percent.

    `channel` is R, G, B, a wavelength such as 550nm, or BRDF; `cosine` is "i", "s", "?" or "".
    """

    channel: str
    kind: str
    cosine: str
    percent: bool


def find_unit(text: str) -> str | None:
    """A unit by one of its names: deg, rad, 1/sr, %, %/sr, nm, um, or "" of none; None for what is no unit."""
    bare = re.sub(r"[\s^*{}\u00b7\[\]()]", "", _fold(text).lower())
    return _UNITS.get(bare)


def _fold(text: str) -> str:
    """Letters as they are in ASCII, as far as they are: subscripts, Greek letters, the signs of degrees."""
    if text.isascii():
        return text
    for sign in _DEGREES:
        text = text.replace(sign, "\u00b0")
    text = "".join("\u00b0" if sign == "\u00b0" else unicodedata.normalize("NFKC", sign) for sign in text)
    return "".join(_SPELT.get(sign.lower(), sign) for sign in text)


@lru_cache(maxsize=4096)
def parse(name: str) -> Name:
    """Split a name such as ``ThetaI [deg]`` into words and a unit."""
    text = _fold(name[:_LONGEST]).strip()
    unit = None
    for pattern in (_BRACKETED, _UNIT_AFTER):
        match = pattern.fullmatch(text) if pattern is _BRACKETED else pattern.fullmatch(text.lower())
        found = match and next((group for group in match.groups()[1:] if group), "")
        if match and found and (unit := find_unit(found)) is not None:
            text = text[:len(match[1])].rstrip(" ,;")
            break
    words: list[str] = []
    for word in _WORD_PATTERN.findall(_HUMP.sub(" ", text).lower()):
        joined = _JOINED.fullmatch(word)
        rest = joined and joined[3]
        if joined and (not rest or rest in _INCIDENT or rest in _OUTGOING or rest in _RELATIVE_WORDS):
            words += [part for part in joined.groups() if part]
        else:
            words.append(word)
    return Name(tuple(words), unit or None, text)


def role(name: str) -> str | None:
    """What a column is, if it is no value: one of `ANGLES` or of the further roles; None for everything else.

    Examples
    --------
    >>> [role(name) for name in ("theta_o[deg]", "PhiIn", "AOS", "Angle of incidence", "raa", "\u03b8\u1d62", "R")]
    ['theta_s', 'phi_i', 'theta_s', 'theta_i', 'phi', 'theta_i', None]
    """
    words = parse(name).words
    if len(words) == 1 and words[0] in _ONE_WORD:
        return _ONE_WORD[words[0]]
    kept = [word for word in words if word not in _FILLER_WORDS]
    polar, azimuth = _POLAR_WORDS.intersection(kept), _AZIMUTH_WORDS.intersection(kept)
    rest = [word for word in kept if word not in polar and word not in azimuth]
    side = "i" if rest and _INCIDENT.issuperset(rest) else "s" if rest and _OUTGOING.issuperset(rest) else ""
    if (polar and not azimuth) or (not azimuth and {"angle", "angles", "ang"}.intersection(words)):
        return f"theta_{side}" if side else None if rest else THETA
    if azimuth and (not polar or polar == {"polar"}):
        return f"phi_{side}" if side else RELATIVE if _RELATIVE_WORDS.issuperset(rest) else None
    if kept in (["wavelength"], ["lambda"], ["wl"], ["wave", "length"]):
        return WAVELENGTH
    if kept in (["standard"], ["reference"]):
        return STANDARD
    return BESIDE if kept and all(word in _BESIDE or word.isdigit() for word in kept) and kept[0] in _BESIDE else None


def value(name: str) -> Value | None:
    """What values a column holds; None if its name says nothing that is known.

    Examples
    --------
    >>> value("BSDF [1/sr]"), value("R*cos_o")[:3]
    (Value(channel='BRDF', kind='brdf', cosine='', percent=False), ('R', '', 's'))
    >>> value("Reflectance factor (%)").kind, value("BRDF_0.55um").channel, value("550").channel, value("humidity")
    ('factor', '550nm', '550nm', None)
    """
    _, unit, text = parse(name)
    cosine = ""
    if with_cosine := _COSINE.fullmatch(text):
        text, side = with_cosine.groups()
        cosine = "?" if not side else "i" if side.lower() == "i" else "s"
    words = list(_WORD_PATTERN.findall(text.lower()))
    if words and words[0] in ("ccbrdf", "ccbsdf"):
        words[0], cosine = "brdf", "s"
    if unit in ("deg", "rad"):
        return None
    channel = "BRDF"
    band = next((word for word in words if word[0].isdigit()), None)
    if band is not None:
        number = float(band)
        is_micron = unit == "um" or "um" in words or (
            unit != "nm" and "nm" not in words and number < _MICRONS and "." in band)
        nanometres = number * 1000 if is_micron else number
        if not _WAVELENGTH_RANGE[0] <= nanometres <= _WAVELENGTH_RANGE[1]:
            return None
        channel = f"{round(nanometres, 6):g}nm"
        words = [word for word in words if word not in (band, "nm", "um", "lambda", "wavelength", "at")]
        if words in (["r"], ["l"]):
            words = []              # R550: of whatever the table has
    elif " ".join(words) not in _VALUE_KINDS and (colours := [word for word in words if word in _COLOUR_WORDS]):
        if len(colours) > 1:
            return None
        channel = _COLOUR_WORDS[colours[0]]
        words.remove(colours[0])
    kind = _VALUE_KINDS.get(" ".join(words))
    if kind is None or (not words and channel == "BRDF"):
        return None
    return Value(channel, kind, cosine, unit in ("%", "%/sr"))
