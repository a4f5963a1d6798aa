"""A starter library: all materials of MERL by the published parameters of a microfacet model, as if they were files.

The parameters are those of J. Low, J. Kronander, A. Ynnerman, J. Unger: BRDF Models for Accurate and Efficient
Rendering of Glossy Surfaces, ACM TOG 31(1), 2012 (`model.low2012`). They were fitted to measurements of W. Matusik,
H. Pfister, M. Brand, L. McMillan: A Data-Driven Reflectance Model, ACM TOG 22(3), 2003, and are no measurements.

`formats.load` takes a virtual path, ``published:NAME``, where it takes files. Samples of the model are then made, where
fits need them: in half and difference angles, and close together where the lobe falls. Near the horizon the model has a
ridge (the shadowing of its grooves), which no fit of this size follows and no camera resolves: it is left out.
"""

import csv
import difflib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .arrays import Directions, FloatArray, selected
from .coordinates.rusinkiewicz import of_half_and_difference
from .errors import DatasetError
from .model.low2012 import Low2012
from .samples import HORIZON, RGB, Samples

PREFIX = "published:"
CITATION = "Low, Kronander, Ynnerman, Unger 2012, ACM TOG 31(1)"
TAGS = ("paint", "metallic", "plastic", "rubber", "fabric", "wood", "stone", "ceramic", "foam", "metal")
_DARKER = "metal"           # the tag of what a published fit makes darker than it is
_DATA = Path(__file__).parent / "data"
_HALF, _DIFFERENCE, _AROUND = 20, 18, 6         # angles theta_h and theta_d, and azimuths phi_d in a quarter turn
_GRAZING = np.radians(85)
_FALL, _TURN = 2.0, np.radians(6)       # changes of the lobe's logarithm, and of theta_h, that count the same


class Published(NamedTuple):
    """A material of the library.

    Attributes
    ----------
    name : str
        In MERL's database.
    label : str
        What people call it.
    tags : tuple of str
        What it is made of, of `TAGS`.
    model : Low2012
    """

    name: str
    label: str
    tags: tuple[str, ...]
    model: Low2012

    @property
    def path(self) -> str:
        """The virtual path, which `load` takes."""
        return PREFIX + self.name

    @property
    def brief(self) -> str:
        """What it is, in a line."""
        return f"Published fit of MERL's {self.name} (Low et al. 2012), not a measurement"

    @property
    def description(self) -> str:
        """What it is, with the source."""
        return f"Published fit of MERL's {self.name}, not a measurement ({CITATION})"


def list_published() -> list[str]:
    """The names of the materials, in alphabetical order.

    Examples
    --------
    >>> len(list_published()), list_published()[:2]
    (100, ['alum-bronze', 'alumina-oxide'])
    """
    return sorted(materials())


def offered() -> list[Published]:
    """The materials that users are offered to begin with: all but the metals.

    A metal reflects more than half of the light that falls straight on it. The published fits of MERL's metals reflect
    3 to 19 %, because the mirror peak is not in them: they would look black. They can still be loaded by name.
    """
    return [each for each in materials().values() if _DARKER not in each.tags]


def load_published(name: str) -> Samples:
    """Samples of a material's model.

    Parameters
    ----------
    name : str
        One of `list_published`.

    Returns
    -------
    Samples
        Red, green and blue, linear Rec.709. Their `notes` say that they are not measured.

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
    at = directions(material.model)
    return Samples(*at, material.model.evaluate(*at), RGB, material.label, material.path, (material.description,))


def find(name: str) -> Published:
    """The material of a name. Raises DatasetError, as `load_published` does."""
    if name in materials():
        return materials()[name]
    close = difflib.get_close_matches(name.lower(), materials(), n=4, cutoff=0.4)
    close += [each for each in list_published() if name and name.lower() in each and each not in close][:4]
    expected = f"did you mean {', '.join(close)}?" if close else "fitter.list_published() has the names"
    raise DatasetError(f"no published material {name!r}; {expected}", PREFIX + name)


def name_in(path: str | Path) -> str | None:
    """The material that a virtual path names; None for the path of a file.

    Examples
    --------
    >>> name_in("published:chrome"), name_in("chrome.binary")
    ('chrome', None)
    """
    text = str(path)
    return text[len(PREFIX):] if text.startswith(PREFIX) else None


@cache
def materials() -> dict[str, Published]:
    """All materials by name."""
    names = {row["name"]: row for row in _rows("merl_names.csv")}
    by_name = {}
    for row in _rows("low2012.csv"):
        name = row["name"]
        kd, a = ([float(row[f"{what}_{channel}"]) for channel in "rgb"] for what in ("kd", "a"))
        model = Low2012(np.array(kd), np.array(a), float(row["b"]), float(row["c"]), float(row["eta"]))
        by_name[name] = Published(name, names[name]["label"], tuple(names[name]["tags"].split()), model)
    return by_name


def _rows(name: str) -> list[dict[str, str]]:
    with open(_DATA / name, encoding="utf-8", newline="") as stream:
        return [*csv.DictReader(line for line in stream if not line.startswith("#"))]


def directions(model: Low2012) -> Directions:
    """Where samples of a model are made: pairs of directions, radians."""
    theta_h, theta_d, phi_d = (grid.ravel() for grid in np.meshgrid(
        _half_angles(model), np.linspace(0, _GRAZING, _DIFFERENCE), np.linspace(0, HORIZON, _AROUND), indexing="ij"))
    at_normal = theta_h == 0                # there, phi_d turns both directions alike
    distinct = ~at_normal | (phi_d == HORIZON)
    theta_h, theta_d, phi_d = theta_h[distinct], theta_d[distinct], phi_d[distinct]
    pairs = of_half_and_difference(theta_h, np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d),
                                   np.cos(theta_d))
    return selected(pairs, np.maximum(pairs[0], pairs[2]) < _GRAZING + 1e-9)


def _half_angles(model: Low2012) -> FloatArray:
    """theta_h of samples, (_HALF,) radians from 0 to grazing: evenly spaced in the lobe's fall and in the angle."""
    narrow = min(0.05 * np.sqrt(2 / model.b), 0.01)
    theta = np.concatenate([[0.0], np.geomspace(narrow, _GRAZING, 4000)])
    fall = model.c * np.log1p(model.b * (1 - np.cos(theta)))
    way = fall / _FALL + theta / _TURN
    return np.interp(np.linspace(0, way[-1], _HALF), way, theta)
