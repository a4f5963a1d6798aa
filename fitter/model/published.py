"""A starter library of models, as if they were files: `formats.load` takes a virtual path, ``published:NAME``, and
samples of the model are made where fits need them.

Metals are microfacets (`model.conductor`) with the refractive indices of `data/metals_nk.csv` in some finishes;
translucent materials (`model.translucent`) the rows of `data/translucent.csv`, or described by their name; the others
the parameters (`model.low2012`) that Low and others fitted to measurements of W. Matusik, H. Pfister, M. Brand, L.
McMillan: A Data-Driven Reflectance Model, ACM TOG 22(3), 2003. Near the horizon their model has a ridge (the shadowing
of its grooves), which no fit of this size follows and no camera resolves: it is left out.
"""

import csv
import difflib
from collections.abc import Iterator, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Directions, FloatArray, select_directions
from ..coordinates.rusinkiewicz import half_to_directions
from ..errors import DatasetError
from ..samples import HORIZON, RGB, Samples
from . import is_isotropic
from .conductor import Conductor
from .low2012 import Low2012
from .translucent import TRANSLUCENT, WORDS, Translucent, parse_words

PREFIX = "published:"
COMPUTED = "Computed from measured optical constants"
SCATTERED = "Computed from measured scattering and absorption"
CITATION = "Low, Kronander, Ynnerman, Unger 2012, ACM TOG 31(1)"
METAL = "metal"
TYPED = f"{TRANSLUCENT};"       # how names begin that describe a material
TAGS = (METAL, TRANSLUCENT, "paint", "metallic", "plastic", "rubber", "fabric", "wood", "stone", "ceramic", "foam")
FINISHES = {"polished": (0.04, 0.04), "satin": (0.15, 0.15), "rough": (0.35, 0.35), "brushed": (0.08, 0.3)}
"""Widths of the lobe of metals, as slopes, along the tangent (of a brushed metal, along its grooves) and across it."""
_TYPED_KEPT = 64            # materials that names describe
_DATA = Path(__file__).parents[1] / "data"
_THETA_H, _DIFFERENCE_ANGLES, _AROUND = 20, 14, 8  # angles theta_h and theta_d, and azimuths phi_d in a quarter turn
_CROWDED = 1.4              # exponent by which these angles theta_d lie closer together toward grazing
_OF_METALS = 22, 24, 6                          # the same: their Fresnel term turns at grazing angles
_OF_BRUSHED, _BRUSHED_AZIMUTHS = (20, 14, 6), 16  # and of brushed metals, with azimuths of the half vector
_GRAZING_PUBLISHED, _GRAZING_OF_METALS = np.radians(85), np.radians(88)
_FALL, _FALL_ANGLE = 1.0, np.radians(8)  # changes of the lobe's logarithm, and of theta_h, that count the same


class PublishedMaterial(NamedTuple):
    """A material of the library."""

    name: str                   # in MERL's database; of a metal, with its finish
    label: str                  # what people call it
    tags: tuple[str, ...]       # what it is made of, of `TAGS`
    model: Low2012 | Conductor | Translucent
    source: str                 # whose numbers they are
    words: str = ""             # other words by which it is found
    excess: float = 1.0  # how many times as bright as the measurement it is off its highlight, where much brighter

    @property
    def path(self) -> str:
        """The virtual path, which `load` takes."""
        return PREFIX + self.name

    @property
    def is_computed(self) -> bool:
        """Whether it is computed from what was measured of its substance; else others fitted it to measurements."""
        return not isinstance(self.model, Low2012)

    @property
    def brightness(self) -> float:
        """The largest component of a published Lambertian's albedo; infinity of what is computed."""
        return float(self.model.kd.max()) if isinstance(self.model, Low2012) else np.inf

    @property
    def finish(self) -> str:
        """Of a metal, one of `FINISHES`; else empty."""
        return self.name.rpartition("-")[2] if METAL in self.tags and self.is_computed else ""

    @property
    def substance(self) -> str:
        """Of a metal, what people call it without its finish; else its label."""
        return self.label[len(self.finish):].strip().capitalize() if self.finish else self.label

    @property
    def brief(self) -> str:
        """What it is, in a line."""
        return self._computation if self.is_computed else (
            f"Published fit of MERL's {self.name} (Low et al. 2012), not a measurement{self._too_bright}")

    @property
    def description(self) -> str:
        """What it is, with the source."""
        return f"{self._computation} ({self.source}), not a measurement of a surface" if self.is_computed else (
            f"Published fit of MERL's {self.name}, not a measurement ({self.source}){self._too_bright}")

    @property
    def _computation(self) -> str:
        return SCATTERED if isinstance(self.model, Translucent) else COMPUTED

    @property
    def _too_bright(self) -> str:
        return "" if self.excess == 1 else f"; off its highlight {self.excess:g} times as bright as what was measured"


def list_published() -> list[str]:
    """The names of the materials, in alphabetical order.

    Examples
    --------
    >>> len(list_published()), list_published()[:2]
    (175, ['alum-bronze', 'alumina-oxide'])
    """
    return sorted(materials())


def list_offered() -> list[PublishedMaterial]:
    """The materials that users are offered to begin with: all but MERL's metals, whose published fits reflect 3 to 19 %
    of light that falls straight on them, where a metal reflects more than half: the mirror peak is not in them."""
    return [each for each in materials().values() if each.is_computed or METAL not in each.tags]


def load_published(name: str) -> Samples:
    """Samples of a material's model.

    Parameters
    ----------
    name
        One of `list_published`, or ``translucent; scattering 2.19 2.62 3; absorption .0021 .0041 .0071; index 1.5``:
        a translucent material by `model.translucent.WORDS`.

    They are red, green and blue, linear Rec.709. Their `notes` say that they are not measured.

    Raises
    ------
    DatasetError
        If there is no material of this name; the message has similar ones.

    Examples
    --------
    >>> chrome = load_published("chrome")
    >>> chrome.name, chrome.source
    ('Chrome', 'published:chrome')
    """
    material = find(name)
    return sample_model(material.model, material.label, material.path, material.description)


def sample_words(words: Mapping[str, str], name: str, source: str) -> Samples:
    """Samples of a translucent material by `model.translucent.WORDS`. Raises ValueError as that does."""
    return sample_model(parse_words(words), name, source,
                        "Computed from scattering and absorption, not a measured BRDF")


def sample_model(model: Low2012 | Conductor | Translucent, name: str, source: str, note: str) -> Samples:
    """Samples of a model: red, green and blue, linear Rec.709."""
    at = directions(model)
    return Samples(*at, model.evaluate(*at), RGB, name, source, (note,), isotropic=is_isotropic(model),
                   subsurface=getattr(model, "subsurface", None))


def find(name: str) -> PublishedMaterial:
    """The material of a name. Raises DatasetError, as `load_published` does."""
    if name.startswith(TYPED):
        return _parse_description(name)
    if name in materials():
        return materials()[name]
    close = difflib.get_close_matches(name.lower(), materials(), n=4, cutoff=0.4)
    close += [each for each in list_published() if name and name.lower() in each and each not in close][:4]
    expected = f"did you mean {', '.join(close)}?" if close else "fitter.list_published() has the names"
    raise DatasetError(f"no published material {name!r}; {expected}", PREFIX + name)


def parse_virtual_path(path: str | Path) -> str | None:
    """The material that a virtual path names; None for the path of a file."""
    text = str(path)
    return text[len(PREFIX):] if text.startswith(PREFIX) else None


@cache
def materials() -> dict[str, PublishedMaterial]:
    """All materials by name."""
    by_name = {each.name: each for each in (*_metals(), *translucent())}
    names = {row["name"]: row for row in _rows("merl_names.csv")}
    for row in _rows("low2012.csv"):
        name = row["name"]
        kd, a = ([float(row[f"{what}_{channel}"]) for channel in "rgb"] for what in ("kd", "a"))
        model = Low2012(np.array(kd), np.array(a), float(row["b"]), float(row["c"]), float(row["eta"]))
        told = names[name]
        by_name[name] = PublishedMaterial(name, told["label"], tuple(told["tags"].split()), model, CITATION,
                                          excess=float(told["excess"] or 1))
    return by_name


def _metals() -> Iterator[PublishedMaterial]:
    """Each metal in each finish."""
    spectra: dict[str, FloatArray] = {}
    for row in _rows("metals_nk.csv"):
        name, quantity, *numbers = row.values()
        spectra[f"{name} {quantity}"] = np.array(numbers, dtype=float)
    weights = np.array([spectra[f"weight {channel}"] for channel in "rgb"])
    for finish, widths in FINISHES.items():
        for row in _rows("metals.csv"):
            if finish == "brushed" and row["brushed"] != "yes":
                continue
            name = row["name"]
            model = Conductor(spectra[f"{name} n"], spectra[f"{name} k"], weights, *widths)
            yield PublishedMaterial(f"{name}-{finish}", f"{finish.capitalize()} {row['label']}", (METAL,), model,
                                    f"{row['sample']}: {row['source']}", row["words"])


def translucent() -> Iterator[PublishedMaterial]:
    """Each translucent material."""
    for row in _rows("translucent.csv"):
        yield PublishedMaterial(row["name"], row["label"], tuple(row["tags"].split()), parse_words(row), row["source"],
                                row["words"])


@lru_cache(_TYPED_KEPT)
def _parse_description(name: str) -> PublishedMaterial:
    """The translucent material that a name describes."""
    parts = [part.split(maxsplit=1) for part in name[len(TYPED):].split(";") if part.strip()]
    words = {part[0]: part[1] if part[1:] else "" for part in parts}
    try:
        if unknown := sorted(words.keys() - {*WORDS, "name"}):
            raise ValueError(f"{unknown[0]!r}, expected {', '.join(WORDS)} or name")
        model = parse_words(words)
    except ValueError as error:
        raise DatasetError(str(error), PREFIX + name) from error
    return PublishedMaterial(name, words.get("name", "").strip() or TRANSLUCENT.capitalize(), (TRANSLUCENT,), model,
                             "numbers of one's own")


def _rows(name: str) -> list[dict[str, str]]:
    with open(_DATA / name, encoding="utf-8", newline="") as stream:
        return [*csv.DictReader(line for line in stream if not line.startswith("#"))]


def directions(model: Low2012 | Conductor | Translucent) -> Directions:
    """Where samples of a model are made: pairs of directions, radians."""
    grazing = _GRAZING_PUBLISHED if isinstance(model, Low2012) else _GRAZING_OF_METALS
    half, difference, around = ((_THETA_H, _DIFFERENCE_ANGLES, _AROUND) if isinstance(model, Low2012) else
                                _OF_METALS if model.isotropic else _OF_BRUSHED)
    phi_d, phi_h = np.linspace(0, HORIZON, around), np.zeros(1)
    if not is_isotropic(model):
        phi_d = np.arange(2 * around) * np.pi / around
        phi_h = np.arange(_BRUSHED_AZIMUTHS) * 2 * np.pi / _BRUSHED_AZIMUTHS
    crowded = _CROWDED if isinstance(model, Low2012) else 1.0
    theta_h, theta_d, phi_d, phi_h = (grid.ravel() for grid in np.meshgrid(
        _half_angles(model, half), grazing * (1 - np.linspace(1, 0, difference) ** crowded), phi_d, phi_h,
        indexing="ij"))
    at_normal = theta_h == 0                # there, phi_d turns both directions alike
    distinct = ~at_normal | (phi_d == HORIZON) if is_isotropic(model) else ~at_normal | (phi_h == 0)
    distinct &= (theta_d > 0) | (phi_d == 0)        # and there both directions are one
    theta_h, theta_d, phi_d, phi_h = (each[distinct] for each in (theta_h, theta_d, phi_d, phi_h))
    theta_i, phi_i, theta_o, phi_o = half_to_directions(
        theta_h, np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d))
    above = np.maximum(theta_i, theta_o) < grazing + 1e-9
    return select_directions((theta_i, phi_i + phi_h, theta_o, phi_o + phi_h), above)


def _half_angles(model: Low2012 | Conductor | Translucent, count: int) -> FloatArray:
    """theta_h of samples, (count,) radians from 0 to grazing: evenly spaced in the lobe's fall and in the angle."""
    lobe = model.surface if isinstance(model, Translucent) else model
    theta = np.concatenate([[0.0], np.geomspace(lobe.width, _GRAZING_PUBLISHED, 4000)])
    way = lobe.log_falloff(theta) / _FALL + theta / _FALL_ANGLE
    return np.interp(np.linspace(0, way[-1], count), way, theta)
